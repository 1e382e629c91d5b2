// bricking/levels/predicted_visibility.h: the predicted visibility of every brick: the share that the camera
// sees past the bricks in front of it. It uses opacities from the bricks' sampled rays (level_error.h). No
// voxel is read and nothing is drawn, so levels depend only on the scene.
#pragma once

#include "bricking/levels/level_error.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"

#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// Per brick, [z][y][x], in [kHiddenVisibility, 1]: the mean transmittance of the picture's rays where they
/// enter the brick. Each brick in front has the mean transmittance of its sampled rays, as a power of the
/// path's length. 1 if no ray was sent. Independent of threads.
std::vector<float> predictVisibility(const LevelErrors& errors, const Camera& camera, const VolumeInfo& info,
                                     const glm::ivec2& imageSize, int threads = 0);

} // namespace tessera
