// render/pixels_again.h: some of a picture's pixels drawn again, as they are and as they should be: the pairs
// that its measured errors are made of (docs/measured-errors.md).
#pragma once

#include "core/image.h"
#include "core/work.h"
#include "render/engine.h"
#include "render/pixels/pixel_places.h"
#include "render/plan/scene_plan.h"
#include "render/verify/measured_errors.h"
#include "render/verify/verify_plan.h"

#include <cstddef>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

/// How wrong a picture is against the mean over each pixel's area of the integral through the finest level.
struct PictureMeasurement {
    Verify mode = Verify::none;
    std::string whyNot; // nothing was measured; empty: it was, as far as `all` holds numbers
    MeasuredErrors all;
    /// The same pixels with the picture's own levels, step and filtering, but as many samples as the truth:
    /// what the picture's samples of a pixel leave out; and what levels, step, filtering and ended rays do.
    MeasuredErrors sampling, rays;
    int samples = 0; // of the truth of a pixel
    std::size_t bytesRead = 0;
    double seconds = 0;
};

/// What was measured, a line each; the first says how wrong the picture is, or that it was not measured.
std::vector<std::string> describe(const PictureMeasurement& measurement);
const std::vector<std::string>& verifyNames(); // in the order of Verify

/// The chosen pixels' own samples: places that no sample of the picture knows of, and what rays through them
/// come to.
class PixelsAgain {
  public:
    /// @param picture  linear, premultiplied
    /// @param round    of choices: none has a pixel of an earlier one, unless all pixels are taken
    PixelsAgain(const Image& picture, const VerifyPlan& plan, const PixelSampling& sampling, int round);

    std::size_t pixels() const { return sample_.pixels.size(); }
    /// RAM that it and its arrays of rays take beside what a picture of this size may.
    std::size_t bytes() const;

    struct Limits {
        Slicing slicing;
        std::size_t mostBytes = SIZE_MAX; // of bricks that may be brought
    };
    /// Rays of a length of segments through all places, to their end; the mean of each replicate. None where
    /// bricks would take more than the limit.
    std::optional<std::vector<glm::vec4>> draw(RayCaster& caster, Engine& engine, const ScenePlan& plan,
                                               double segmentVoxels, const Limits& limits, Work& work) const;

    /// @param own, truth   of draw()
    /// @param boundChance  with which MeasuredErrors::luvP99Bound holds
    void measure(const std::vector<glm::vec4>& own, const std::vector<glm::vec4>& truth, double boundChance,
                 PictureMeasurement& out) const;

  private:
    std::vector<glm::vec4> means(const std::vector<glm::vec4>& replicates) const;

    glm::ivec2 size_;
    PixelSample sample_;
    std::vector<glm::vec4> picture_; // of the chosen pixels
    int replicates_, samples_;
    PixelPlaces places_;
    std::uint32_t firstSet_;
};

} // namespace tessera
