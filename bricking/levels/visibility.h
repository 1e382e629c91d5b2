// bricking/levels/visibility.h: the visibility of bricks, measured by a picture or predicted.
#pragma once

#include "bricking/levels/level_error.h"
#include "bricking/levels/selection.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

// Visibility measured by a picture, as a factor per brick for the next choice of levels. The factor is stable
// over frames.

/// Light of rays that entered a brick, in whole numbers, so that sums do not depend on the order of rays.
struct SeenBrick {
    static constexpr std::uint32_t kLightOfRay = 256;
    std::uint32_t light = 0; // sum over rays of their transmittance on entry, in 1/kLightOfRay
    std::uint32_t rays = 0;  // that entered
};

/// Factor of a hidden brick: the picture in which it appears then has at least a coarse version of it.
constexpr float kHiddenVisibility = 1.0f / 64;

/// Factors in [kHiddenVisibility, 1] per brick, [z][y][x], for selectLevels(): the mean transmittance on
/// entry; 1 if no ray entered. With `last`, for interactive pictures:
/// - A factor changes only if the light is more than twice or less than half the last one, so that jitter
///   does not change the selection.
/// - It rises at once. While the last selection holds samples of the brick it falls by half per call, so that
///   a brick uncovered a moment later is still there. Otherwise it falls at once.
/// @param last  the last result, or null: factors then follow at once
std::vector<float> visibilityFactors(std::span<const SeenBrick> seen, const Selection& selection,
                                     std::span<const float> last = {});

// The predicted visibility of every brick: the share that the camera sees past the bricks in front of it. It
// uses opacities from the bricks' sampled rays (level_error.h). No voxel is read and nothing is drawn, so
// levels depend only on the scene.

/// Per brick, [z][y][x], in [kHiddenVisibility, 1]: the mean transmittance of the picture's rays where they
/// enter the brick. Each brick in front has the mean transmittance of its sampled rays, as a power of the
/// path's length. 1 if no ray was sent. Independent of threads.
std::vector<float> predictVisibility(const LevelErrors& errors, const Camera& camera, const VolumeInfo& info,
                                     const glm::ivec2& imageSize, int threads = 0);

} // namespace tessera
