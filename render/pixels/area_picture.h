// render/pixels/area_picture.h: a picture whose pixels are means over their areas (docs/sampling.md,
// "Pixels"). It chooses the next rays and receives their colours; any engine casts them. Every array of rays
// refines the picture. The same samples give the same picture, by any engine and in any parts.
#pragma once

#include "core/image/picture_tile.h"
#include "core/scene/scene.h"
#include "render/engine.h"
#include "render/pixels/pixel_places.h"
#include "render/pixels/pixel_sums.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// Statistics of a picture's samples.
struct PixelReport {
    int asked = 1;                      // samples per pixel; 0: as many as each needs
    double taken = 1;                   // in the mean over pixels
    int most = 1;                       // of any pixel
    int ofEarlierRuns = 0;              // samples per pixel that were kept; they count in `taken`
    std::optional<StandardError> error; // none: one ray per pixel, or automatic
};

/// Automatic samples: the allowed error of a pixel's mean, and the allowed cost. The cost is one ray for
/// every pixel with a visible centre, plus a constant number for pictures of any size. These are constants,
/// not measured times, so that pictures are reproducible.
struct PixelGoal {
    PixelTarget target;
    std::size_t rays = std::size_t{1} << 17; // constant number for the picture
    int most = 64;                           // samples of a pixel; a power of two
};

/// A part of a picture that is drawn by itself.
struct AreaOfPicture {
    PictureTile tile;
    glm::ivec2 most{0}; // of the parts, the largest: what arrays of rays have memory for
};

/// Pixels to sample whatever their centres show, by number, ascending. It is called once for automatic
/// samples, after the centres; its memory, 8 bytes per pixel, is not used by ray arrays yet.
using Overlooked = std::function<std::vector<std::uint32_t>(const Image& middles)>;

class AreaPicture {
  public:
    /// @param picture  rays without places
    /// @param threads  for choosing, placing and adding samples; 0: all processors
    /// @param phasedStep  with automatic samples: the step of all rays but those through centres, voxels;
    ///     these rays have phases. None: the picture's own step, without phases
    /// @param others  pictures that add() takes beside the colours
    /// @param part  with samples that are a number: this part alone, with the same samples
    AreaPicture(const Rays& picture, const PixelSampling& sampling, int threads = 0,
                const PixelGoal& goal = {}, Overlooked overlooked = {}, std::optional<double> phasedStep = {},
                std::size_t others = 0, const std::optional<AreaOfPicture>& part = {});

    /// With automatic samples: continues until another goal is met. Allows as many more rays as the goal has,
    /// and one for every visible pixel.
    void goOn(const PixelGoal& goal);

    /// Continues from the samples of another run, equally many of all pixels: the same picture as if this one
    /// had taken them. Before any rays are drawn, of a picture whose samples are a number.
    /// @param samples  of a pixel; a power of two that is at most the number asked for
    /// @param sums  of the colours and the others; takes them
    void goOnFrom(int samples, const std::function<void(std::span<PixelSums*>)>& sums);
    /// Samples of a pixel if all have the same number, and it is one that goOnFrom() takes; else 0.
    int wholeSamples() const;
    /// Sums of the colours and of the others, as goOnFrom() gets them.
    std::vector<const PixelSums*> allSums() const;

    /// The next rays, to be cast completely; none: the picture is done. They refer to data in this object.
    std::optional<Rays> next();
    /// Takes the colours of the rays of next().
    /// @param others  further pictures of the same rays, such as light to add; they do not affect the choice
    ///     of samples
    void add(const Image& drawn, std::span<const Image> others = {});

    Image image() const { return sums_.image(); }
    /// The mean of one of the others.
    Image other(std::size_t number) const { return others_.at(number).image(); }
    /// The number of samples that every pixel has, where a round has just ended; none amid one, and where
    /// pixels decide.
    std::optional<int> samplesOfAll() const;
    PixelReport report() const;
    const PixelSums& sums() const { return sums_; }
    /// Share of the work done, with part of the current array; an estimate for automatic samples, and where a
    /// noise is asked for.
    double share(double ofArray) const;

    /// Standard error of the picture (rms) after the last round; none before samples tell it.
    std::optional<double> noise() const { return noise_; }
    /// Rounds that are drawn; of a number of samples each doubles them.
    int roundsDone() const { return round_; }

    /// RAM per pixel of this and the arrays; charged by the picture's plan.
    static std::size_t bytesPerPixel(const PixelSampling& sampling);
    /// Largest number of rays in an array: as many as pixels, at least a few.
    static std::size_t mostRays(const glm::ivec2& imageSize);

  private:
    void beginRound();
    bool takeOverlooked();
    void chooseNeedy();
    void take(std::uint32_t pixel, int upTo);
    bool decides() const { return sampling_.samples == PixelSampling::kAutomatic; }
    int firstSamples() const { return picture_.paths ? 1 : 2; }
    int samplesAfter(int round) const;
    int rounds() const;
    bool isQuiet();
    struct Part { // of an array: pixels of pixels_, and their first ray
        std::size_t first, end, firstRay;
    };
    std::size_t divide();
    glm::ivec2 pixelAt(std::uint32_t number) const;
    struct Runs { // of a part: the ray behind them; no further one fits into the array
        std::size_t end;
        bool full;
    };
    template <typename Visit> Runs forEachRun(const Part& part, const Visit& visit) const;

    Rays picture_;
    PixelSampling sampling_;
    PixelGoal goal_;
    Overlooked overlooked_; // none after its call
    int threads_;
    PixelPlaces places_;
    glm::ivec2 from_;      // the first pixel on the picture
    std::size_t mostRays_; // of an array
    PixelSums sums_;
    std::vector<PixelSums> others_;
    std::optional<double> noise_;
    int round_ = -1;
    std::vector<std::uint32_t> pixels_; // of this round
    std::vector<std::uint16_t> upTo_;   // samples of each pixel after it, less one
    std::vector<float> needs_;          // of all pixels before this round; none: not estimated yet
    std::vector<Part> parts_;           // of the array at hand
    std::size_t first_ = 0;             // index of a pixel that lacks samples
    std::optional<double> phasedStep_;
    std::size_t ofOverlooked_ = 0;        // rays
    std::size_t budget_ = 0, left_ = 0;   // allowed and remaining rays of automatic samples
    std::size_t taken_ = 0, ofArray_ = 0; // rays; of the array at hand
    bool drawing_ = false;
    std::vector<glm::vec2> array_;       // of rays; none: through all pixel centres
    std::vector<std::uint32_t> numbers_; // of the array's samples, where paths of light ask for them
    glm::ivec2 arraySize_{0};
};

} // namespace tessera
