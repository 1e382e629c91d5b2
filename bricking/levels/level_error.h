// bricking/levels/level_error.h: the predicted error of each brick at each level under a transfer function,
// which selection minimises.
//
// The error of a brick at a level is defined for the brick alone on black, seen along the axes from both
// ends. It is the mean over its rays of the distance in CIE 1976 L*u*v* between the ray composited from level
// 0 and from that level. It is predicted by compositing the rays sampled at import (brick_rays.h) in this
// way, half of them from either end. The prediction has little bias, but the variance of a sample of 24 rays.
//
// Selecting the largest gains would select the largest deviations, so errors are smoothed. A tenth of a
// brick's error comes from its neighbours. A quarter of its distribution over levels comes from all bricks
// together.
//
// The error accounts for colour changes along a ray, occlusion within the brick, noise that cancels along a
// ray, and narrow peaks of the function. A visible structure may be met by none of the rays. The brick then
// gets the error of one white ray among them, growing with the level, because small structures matter. The
// error ignores the space before and behind the brick, lighting, and neighbours of other levels.
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
    std::vector<std::uint8_t> shows; // [z][y][x]: 0 for bricks that are invisible under the function
    /// [z][y][x][level]: in L*u*v* units; 0 at level 0 and for invisible bricks.
    std::vector<std::array<float, kLevelCount>> errors;
    /// [z][y][x][level]: length of the mean difference of those rays, likewise: the error that remains if a
    /// pixel averages them.
    std::vector<std::array<float, kLevelCount>> biases;
    std::vector<float> transmittances; // [z][y][x]: mean of the rays at level 0; 1 for invisible bricks
};

/// rayErrors(), smoothed. Independent of camera and threads.
/// @param shows  per brick; every visible brick must have its rays (checked)
LevelErrors predictErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                          const VolumeInfo& info, int threads = 0);

/// Upper bound on the memory of predictErrors() with its result, without the rays.
std::size_t predictErrorsBytes(std::size_t bricks);

/// The end from which a sampled ray is composited. Half of the rays of a part, and of the two rays of a
/// group, are seen from either end, because a brick's two sides may differ. True: from its last sample.
constexpr bool seenFromItsEnd(int part, int ray) {
    return ((ray / 2 + part) & 1) != 0;
}

/// The weighted mean over the sampled rays, not smoothed.
LevelErrors rayErrors(const BrickRays& rays, std::vector<std::uint8_t> shows, const TransferTable& table,
                      const VolumeInfo& info, int threads = 0);

/// Smooths errors: error(level) = (1 - kProfileShare) * e(level) + kProfileShare * s * (share of the level in
/// the sum over all bricks). Here e is kOwnShare of the brick's own error plus the rest from the mean of its
/// six visible neighbours, and s is the sum of e over levels. Both constants were measured: the worst choices
/// improve a little, the others do not change. A single brick is unchanged.
constexpr float kOwnShare = 0.9f, kProfileShare = 0.25f;
void smoothErrors(LevelErrors& errors, int threads = 0);

} // namespace tessera
