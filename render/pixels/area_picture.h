// render/pixels/area_picture.h: a picture whose pixels are means over their areas (docs/sampling.md,
// "Pixels"). It says which rays to take next and is given what they gathered; any engine takes them. Every
// array of rays refines the picture that is there. The same samples give the same picture, whoever draws them
// and in whatever parts.
#pragma once

#include "core/scene/scene.h"
#include "render/engine.h"
#include "render/pixels/pixel_places.h"
#include "render/pixels/pixel_sums.h"
#include "render/pixels/sample_needs.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace tessera {

/// What is known of a picture's samples.
struct PixelReport {
    int asked = 1;                      // samples a pixel; 0: as many as each needs
    double taken = 1;                   // in the mean over pixels
    int most = 1;                       // of any pixel
    std::optional<StandardError> error; // none: one ray through each middle, or pixels decide
};

/// Where pixels decide: how far a pixel's mean may be off, and what all of them may cost. The cost is one ray
/// for every pixel whose middle shows something, and as many more as pictures of any size can afford.
/// Figures, not measurements of time, so that pictures stay the same.
struct PixelGoal {
    PixelTarget target;
    std::size_t rays = std::size_t{1} << 17; // of the picture, besides those
    int most = 64;                           // samples of a pixel; a power of two
};

/// Pixels to sample whatever their middles show, by number, ascending. It is asked once where pixels decide,
/// after the middles; what it takes besides these, 8 bytes a pixel, arrays of rays have not taken yet.
using Overlooked = std::function<std::vector<std::uint32_t>(const Image& middles)>;

class AreaPicture {
  public:
    /// @param picture  without places
    /// @param threads  that decide where samples go; 0: all processors
    /// @param phasedStep  where pixels decide: the step of all rays but those through middles, voxels; they
    ///     have phases. None: the picture's own, and no phases
    AreaPicture(const Rays& picture, const PixelSampling& sampling, int threads = 0,
                const PixelGoal& goal = {}, Overlooked overlooked = {},
                std::optional<double> phasedStep = {});

    /// Where pixels decide: goes on from what is there, until another goal is met. As many more rays as the
    /// goal has, and one for every pixel that shows something.
    void goOn(const PixelGoal& goal);

    /// The rays to draw next, to their end; none: the picture is done. They read what is kept here.
    std::optional<Rays> next();
    /// What the rays of next() gathered.
    /// @param light  what is added to it, of every array or of none: it does not decide where samples go
    void add(const Image& drawn, const Image* light = nullptr);

    Image image() const { return sums_.image(); }
    /// What is added to it.
    Image light() const { return light_->image(); }
    PixelReport report() const;
    const PixelSums& sums() const { return sums_; }
    /// Part of the work that is done, where some of the array at hand is; a guess where pixels decide.
    double share(double ofArray) const;

    /// RAM that this and the arrays take for a pixel; charged by whoever plans the picture.
    static std::size_t bytesPerPixel();
    /// Rays of an array at most: as many as there are pixels, a few at least.
    static std::size_t mostRays(const glm::ivec2& imageSize);

  private:
    void beginRound();
    bool takeOverlooked();
    void chooseNeedy();
    void take(std::uint32_t pixel, int upTo);
    bool decides() const { return sampling_.samples == PixelSampling::kAutomatic; }
    int rounds() const;
    template <typename Visit> void forEachRun(const Visit& visit) const;

    Rays picture_;
    PixelSampling sampling_;
    PixelGoal goal_;
    Overlooked overlooked_; // none once it was asked
    int threads_;
    PixelPlaces places_;
    PixelSums sums_;
    std::optional<PixelSums> light_;
    int round_ = -1;
    std::vector<std::uint32_t> pixels_; // of this round
    std::vector<std::uint8_t> upTo_;    // samples that each has after it, less one
    std::size_t first_ = 0;             // of them that lacks samples
    std::optional<double> phasedStep_;
    std::size_t ofOverlooked_ = 0;      // rays
    std::size_t budget_ = 0, left_ = 0; // rays that may be taken where pixels decide, and may still be
    std::size_t taken_ = 0;             // rays
    bool drawing_ = false;
    std::vector<glm::vec2> array_; // of rays; none: through the middles of all pixels
    glm::ivec2 arraySize_{0};
};

} // namespace tessera
