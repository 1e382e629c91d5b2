// bricking/levels/predicted_visibility.h: the predicted visibility of every brick: how much of it the camera
// sees past the bricks in front of it. It uses the opacities that the bricks' sampled rays predict
// (level_error.h). No voxel is read and nothing is drawn, so a picture's levels depend on its scene alone.
#pragma once

#include "bricking/levels/level_error.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"

#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// Per brick, [z][y][x], in [kHiddenVisibility, 1]: the mean light that is left when rays of the picture
/// enter it. Each brick before it lets through what its sampled rays let through in the mean, as a power of
/// the path's length. 1 where no ray was sent. Independent of threads.
std::vector<float> predictVisibility(const LevelErrors& errors, const Camera& camera, const VolumeInfo& info,
                                     const glm::ivec2& imageSize, int threads = 0);

} // namespace tessera
