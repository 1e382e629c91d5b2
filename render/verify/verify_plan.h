// render/verify/verify_plan.h: the plan of a verification: the number of pixels drawn again, their rays, and
// the allowed cost.
#pragma once

#include "render/verify/measured_errors.h"
#include "render/verify/pixel_sample.h"

#include <cstddef>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

enum class Verify { none, quick, full };
const std::vector<std::string>& verifyNames(); // in the order of Verify

/// The inputs, before anything is drawn again.
struct VerifyInput {
    glm::ivec2 size{0};
    std::size_t shown = 0;     // number of visible pixels of the picture
    int samplesPerPixel = 1;   // of the picture
    double costOfTruthRay = 4; // cost in rays of the picture: with a quarter of its step
    int brickPixels = 0;  // a brick's width if finest bricks must be read for the truth; 0: they are resident
    double costTaken = 0; // share of kMostQuickCost spent on other pixels of the same picture
    Verify mode = Verify::quick;
    std::uint64_t seed = 0;
};

struct VerifyPlan {
    SampleDesign design;   // 0 pixels: nothing is drawn again
    int replicates = 0;    // for the truth of each pixel
    int samples = 0;       // rays of each replicate
    double cost = 0;       // of the visible pixels, relative to the picture's visible rays
    bool tellsP99 = false; // enough visible pixels are expected for a 99th percentile
};

/// Largest cost of `quick` for pictures from 512x512 up, in rays.
constexpr double kMostQuickCost = 0.25;

/// One pixel per cluster, spread over the picture: pixels of one brick may be worth a fifth of as many
/// separate ones (docs/measurements/measured-errors.md). Invisible pixels are drawn again in addition.
///
/// Mode quick: 1000 visible pixels; 400 if the picture is smaller than 512x512 or 1000 cost too much; fewer,
/// without a 99th percentile, if these still do. Each has 16 rays, or 8 if that gets 400 within the cost. It
/// has more if the picture itself has more than 4, because noise in the truth must be less than the error. If
/// bricks must be read: 64 clusters of 8 visible pixels, in tiles of a quarter of a brick, for means without
/// a 99th percentile. The reader of the bricks decides whether they are few enough. Mode full: 2000 pixels of
/// 64 rays or more, at any cost.
VerifyPlan verifyPlan(const VerifyInput& input);

// The error of a picture, measured by drawing some of its pixels again.

/// The error of a picture against the mean over each pixel's area of the integral through the finest level.
struct PictureMeasurement {
    Verify mode = Verify::none;
    std::string whyNot; // the reason if nothing was measured; empty: `all` has the numbers
    MeasuredErrors all;
    /// The same pixels with the picture's own levels, step, filtering and early termination, but as many
    /// samples as the truth. They separate the error of the picture's pixel samples from all other causes.
    MeasuredErrors sampling, rays;
    /// The picture has light per voxel or surface: the error of that light is not in these numbers, because
    /// the truth has the same light.
    bool keptLight = false;
    /// The truth has the picture's own levels and step: of paths of light, which have no other.
    bool keptRays = false;
    /// Of Verify::full: what planes, maps and numbers of rays cost, against single ways of light, the rest
    /// being the same. None: whyNoLight says why, where it was asked for.
    std::optional<MeasuredErrors> light;
    std::string whyNoLight;
    bool singleRays = false;          // the picture has one ray per pixel
    int samples = 0, mostSamples = 0; // rays of a pixel's truth; rays with which it was too noisy
    std::size_t bytesRead = 0;
    double seconds = 0;
};

} // namespace tessera
