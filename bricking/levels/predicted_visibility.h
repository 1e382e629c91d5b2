// bricking/levels/predicted_visibility.h: how much of every brick the camera will see past those before it,
// from the opacities that the sampled rays of the bricks predict (level_error.h). No voxel is read and
// nothing is drawn, so that a picture's levels depend on its scene alone.
#pragma once

#include "bricking/levels/level_error.h"
#include "core/camera.h"
#include "core/volume.h"

#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// Per brick, [z][y][x], in [kHiddenVisibility, 1]: the mean light that is left when rays of the picture
/// enter it, each brick before it letting through what its sampled rays let through in the mean, as a power
/// of the path's length. 1 where no ray was sent. Independent of threads.
std::vector<float> predictVisibility(const LevelErrors& errors, const Camera& camera, const VolumeInfo& info,
                                     const glm::ivec2& imageSize, int threads = 0);

} // namespace tessera
