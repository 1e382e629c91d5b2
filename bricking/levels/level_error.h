// bricking/levels/level_error.h: the predicted error of each brick at each level under a transfer function,
// which selection minimises.
//
// The error of a brick at a level is defined for the brick alone before black, seen along the axes from both
// ends. It is the mean over its rays of the distance in CIE 1976 L*u*v* between the ray composited from level
// 0 and from that level. It is predicted by compositing the rays that import sampled (brick_rays.h) in just
// that way, half of them from either end. The prediction has no bias to speak of, but the scatter of a sample
// of 24 rays.
//
// A choice that looks for the largest gains finds the largest scatter, so errors are smoothed. A tenth of a
// brick's error is that of its neighbours. A quarter of how it is shared out among levels is as in
// all bricks together.
//
// The error holds colour that changes along a ray, values behind one another, noise that cancels along a ray,
// and narrow peaks of the function. A brick may show something that none of its rays met. It then gets the
// error of one white ray among them, growing with the level: small things are what people look for. The error
// leaves out the space before and behind the brick, lighting, and neighbours of other levels.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/transfer_function.h"

#include <array>
#include <cstdint>
#include <vector>

namespace tessera {

struct LevelErrors {
    glm::ivec3 bricks{0};
    std::vector<std::uint8_t> shows; // [z][y][x]: 0 where the function shows nothing of a brick
    /// [z][y][x][level]: in L*u*v* units; 0 at level 0 and for bricks that show nothing.
    std::vector<std::array<float, kLevelCount>> errors;
    /// [z][y][x][level]: length of the mean difference of those rays, likewise: what is left of the error
    /// when a pixel averages them.
    std::vector<std::array<float, kLevelCount>> biases;
    std::vector<float>
        transmittances; // [z][y][x]: mean of the rays at level 0; 1 for bricks that show nothing
};

/// rayErrors(), smoothed. Independent of camera and threads.
/// @param shows  per brick; every brick that shows must have its rays (checked)
LevelErrors predictErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                          const VolumeInfo& info, int threads = 0);

/// Memory that predictErrors() takes at most, its result included, besides the rays.
std::size_t predictErrorsBytes(std::size_t bricks);

/// The end from which a sampled ray is composited, as the eye of a camera there would see it. Half of the
/// rays of a part, and of a pair of rays that stand for one group, are seen from either end, because a
/// brick's two sides may look different. True: from its last sample.
constexpr bool seenFromItsEnd(int part, int ray) {
    return ((ray / 2 + part) & 1) != 0;
}

/// The weighted mean over the sampled rays, as it is.
LevelErrors rayErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                      const VolumeInfo& info, int threads = 0);

/// Takes scatter out. e of a brick is kOwnShare of its own error and, for the rest, the mean of its six
/// neighbours that show. s is the sum of e over levels. error(level) = (1 - kProfileShare) * e(level) +
/// kProfileShare * s * (share of the level in the sum over all bricks). Both constants were measured: the
/// worst choices lose a little less, the others neither lose nor win. A single brick stays as it is.
constexpr float kOwnShare = 0.9f, kProfileShare = 0.25f;
void smoothErrors(LevelErrors& errors, int threads = 0);

} // namespace tessera
