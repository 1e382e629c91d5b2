// render/picture/pixels_again.h: some of a picture's pixels drawn again, as they are and as they should be.
// Measured errors are made of these pairs (docs/measurements/measured-errors.md).
#pragma once

#include "core/base/work.h"
#include "core/image/image.h"
#include "render/engine.h"
#include "render/pixels/pixel_places.h"
#include "render/plan/scene_plan.h"
#include "render/verify/measured_errors.h"
#include "render/verify/verify_plan.h"

#include <cstddef>
#include <cstdint>
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
    /// The same pixels with the picture's own levels, step, filtering and ends of rays, but as many samples
    /// as the truth. They tell the error of the picture's samples of a pixel, and that of all other causes.
    MeasuredErrors sampling, rays;
    /// The picture has light that is kept of voxels or surfaces: what that light itself errs by is in none of
    /// these numbers, because the truth has the same.
    bool keptLight = false;
    bool singleRays = false;          // the picture has one ray a pixel
    int samples = 0, mostSamples = 0; // of the truth of a pixel; of those that it was too noisy with
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
        std::uint64_t mostBytes = UINT64_MAX; // of bricks that may be brought, all of work together
    };
    /// The pixels as they are: rays of a length of segments through all places, to their end; the mean of
    /// each replicate.
    /// @param more  pixels too noisy for the picture's largest errors are drawn again with four times the
    ///     samples, at most twice. The spread of replicates decides, which are then discarded, so the choice
    ///     does not bias the result. From then on these are their places.
    /// None where bricks would take more bytes than the limit.
    std::optional<std::vector<glm::vec4>> drawOwn(RayCaster& caster, Engine& engine, const ScenePlan& plan,
                                                  double segmentVoxels, const Limits& limits, bool more,
                                                  Work& work);
    /// The same as they should be, through the same places.
    std::optional<std::vector<glm::vec4>> drawTruth(RayCaster& caster, Engine& engine, const ScenePlan& plan,
                                                    double segmentVoxels, const Limits& limits,
                                                    Work& work) const;

    /// @param own, truth   of drawOwn() and drawTruth()
    /// @param boundChance  with which MeasuredErrors::luvP99Bound holds
    void measure(const std::vector<glm::vec4>& own, const std::vector<glm::vec4>& truth, double boundChance,
                 PictureMeasurement& out) const;

  private:
    /// A caster with what its rays need.
    struct Draws {
        RayCaster& caster;
        Engine& engine;
        const ScenePlan& plan;
        double segmentVoxels;
        const Limits& limits;
        Work& work;
    };
    /// The pixels of one step, to their places in `out`; false where bricks would take too many bytes.
    bool drawStep(int step, const Draws& draws, std::vector<glm::vec4>& out) const;
    /// Those of a step that are too noisy go to the next; false where there are none.
    bool chooseNoisy(int step, const std::vector<glm::vec4>& own);
    /// Of a replicate.
    int samplesOf(int step) const { return samples_ << (2 * step); }
    std::vector<glm::vec4> means(const std::vector<glm::vec4>& replicates) const;

    glm::ivec2 size_;
    PixelSample sample_;
    std::vector<glm::vec4> picture_; // of the chosen pixels
    int replicates_, samples_;
    PixelPlaces places_;
    std::uint32_t firstSet_;
    std::vector<std::uint8_t> step_; // of each pixel: how often its samples were made four times as many
};

} // namespace tessera
