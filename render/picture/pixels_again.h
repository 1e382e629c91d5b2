// render/picture/pixels_again.h: some of a picture's pixels drawn again, as they are and as they should be.
// Measured errors are made of these pairs (docs/measurements/measured-errors.md).
#pragma once

#include "core/base/work.h"
#include "core/image/image.h"
#include "render/labels/slice_labels.h" // LabelsOver
#include "render/pixels/pixel_places.h"
#include "render/renderer.h"
#include "render/verify/verify_plan.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// The measurements, a line each; the first gives the picture's error, or says that it was not measured.
std::vector<std::string> describe(const PictureMeasurement& measurement);

/// The chosen pixels' own samples: places that no sample of the picture uses, and the colours that rays
/// through them come to.
/// What lies over a pixel of a picture, whatever its rays come to; empty: nothing.
using PixelOver = std::function<LabelsOver(const glm::ivec2& pixel)>;

/// A drawn picture, wherever its pixels are.
struct DrawnPixels {
    glm::ivec2 size{0};
    std::size_t shown = 0;                                    // pixels that show something
    std::function<glm::vec4(const glm::ivec2& pixel)> colour; // linear, premultiplied
    glm::ivec2 together{0}; // rays that are drawn at a time: as many as such a picture has
};
/// The image outlives it.
DrawnPixels pixelsOf(const Image& image);

class PixelsAgain {
  public:
    /// @param round    of choices: none has a pixel of an earlier one, unless all pixels are taken
    /// @param over     lies over all pixels, those drawn again too
    PixelsAgain(const DrawnPixels& picture, const VerifyPlan& plan, const PixelSampling& sampling, int round,
                PixelOver over);

    std::size_t pixels() const { return sample_.pixels.size(); }
    /// RAM that it and its arrays of rays take beside that of a picture of this size.
    std::size_t bytes() const;

    struct Limits {
        Slicing slicing;
        std::uint64_t mostBytes = UINT64_MAX; // of bricks that may be brought, all of work together
    };
    /// The pixels as they are: samples through all places; the mean of each replicate.
    /// @param more  pixels too noisy for the picture's largest errors are drawn again with four times the
    ///     samples, at most twice. The spread of replicates decides, which are then discarded, so the choice
    ///     does not bias the result. From then on these are their places.
    /// None where bricks would take more bytes than the limit.
    std::optional<std::vector<glm::vec4>> drawOwn(PixelSource& source, const Limits& limits, bool more,
                                                  Work& work);
    /// The same through the same places, as the source tells them by now.
    std::optional<std::vector<glm::vec4>> drawAgain(PixelSource& source, const Limits& limits,
                                                    Work& work) const;

    /// The picture's error against the mean of its own rays.
    /// @param own  of drawOwn()
    void measureOwn(const std::vector<glm::vec4>& own, PictureMeasurement& out) const;
    /// The error of kept light: against single ways, which differ in nothing else.
    MeasuredErrors lightError(const std::vector<glm::vec4>& own, const std::vector<glm::vec4>& byWays) const;
    /// @param own, truth   of drawOwn(), and of drawAgain() after PixelSource::toTruth()
    /// @param boundChance  with which MeasuredErrors::luvP99Bound holds
    void measure(const std::vector<glm::vec4>& own, const std::vector<glm::vec4>& truth, double boundChance,
                 PictureMeasurement& out) const;

  private:
    /// The pixels of one step, to their places in `out`; false where bricks would take too many bytes.
    bool drawStep(int step, PixelSource& source, const Limits& limits, Work& work,
                  std::vector<glm::vec4>& out) const;
    /// Those of a step that are too noisy go to the next; false where there are none.
    bool chooseNoisy(int step, const std::vector<glm::vec4>& own);
    /// Of a replicate.
    int samplesOf(int step) const { return samples_ << (2 * step); }
    std::vector<glm::vec4> means(const std::vector<glm::vec4>& replicates) const;

    glm::ivec2 together_; // DrawnPixels::together
    PixelSample sample_;
    std::vector<glm::vec4> picture_; // of the chosen pixels
    int replicates_, samples_;
    PixelPlaces places_;
    std::uint32_t firstSet_;
    PixelOver over_;
    std::vector<std::uint8_t> step_; // of each pixel: how often its samples were made four times as many
};

} // namespace tessera
