// render/verify/verify_plan.h: the plan of a verification: the number of pixels drawn again, how they are
// drawn, and the cost that is allowed.
#pragma once

#include "render/verify/pixel_sample.h"

#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

enum class Verify { none, quick, full };
const std::vector<std::string>& verifyNames(); // in the order of Verify

/// What is known before anything is drawn again.
struct VerifyInput {
    glm::ivec2 size{0};
    std::size_t shown = 0;     // pixels of the picture that show something: how many, not which
    int samplesPerPixel = 1;   // of the picture
    double costOfTruthRay = 4; // in rays of the picture: a quarter of its step
    int brickPixels = 0;  // a brick's width where finest bricks must be read for the truth; 0: they are there
    double costTaken = 0; // of kMostQuickCost, by other pixels of the same picture
    Verify mode = Verify::quick;
    std::uint64_t seed = 0;
};

struct VerifyPlan {
    SampleDesign design;   // 0 pixels: nothing is drawn again
    int replicates = 0;    // of the truth of each pixel
    int samples = 0;       // rays of each replicate
    double cost = 0;       // of the pixels that show something, against the picture's rays that do
    bool tellsP99 = false; // as many pixels that show something are expected as a 99th percentile needs
};

/// Pictures from 512x512 up pay at most this for `quick`, in rays.
constexpr double kMostQuickCost = 0.25;

/// One pixel a cluster, spread over the picture: pixels of one brick may be worth as little as a fifth of as
/// many apart (docs/measurements/measured-errors.md). As many more pixels are drawn again as show
/// nothing.
///
/// quick: 1000 pixels that show something, 400 where the picture is smaller than 512x512 or 1000 cost too
/// much, fewer (and then no 99th percentile) where those still do. 16 rays each or, if that gets 400 within
/// the cost, 8; more where the picture itself takes more than 4, because noise in the truth has to be less
/// than the error. Where bricks must be read: 64 clusters of 8 that show something, in tiles of a quarter of
/// a brick, which tell means but no 99th percentile. The reader of the bricks decides whether they are few
/// enough. full: 2000, of 64 rays or more, at any cost.
VerifyPlan verifyPlan(const VerifyInput& input);

} // namespace tessera
