// bricking/levels/view_weight.h: the camera's weight of each brick: the pixels that it covers, and the finest
// level that a pixel can still show.
#pragma once

#include "core/base/brick.h"
#include "core/base/volume.h"
#include "core/scene/camera.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

struct ViewWeights {
    glm::ivec3 bricks{0};
    double pixels = 0; // of the picture
    /// [z][y][x]: pixels that a brick covers, clipped to the picture; 0 if it is outside the picture. A brick
    /// outside whose samples may blend into one inside has a quarter of the area of the box half a brick
    /// larger on every side.
    std::vector<float> area;
    /// [z][y][x]: the finest level that a pixel can show, by samples not larger than a pixel along each axis
    /// at the brick's nearest point. kLevelCount-1 where area is 0.
    std::vector<std::uint8_t> finest;
};

/// Exact for any affine and projection, a camera inside the volume included. Independent of threads.
/// @param shows  LevelErrors::shows: invisible bricks are skipped and have area 0; empty: all bricks
ViewWeights viewWeights(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize,
                        int threads = 0, std::span<const std::uint8_t> shows = {});

} // namespace tessera
