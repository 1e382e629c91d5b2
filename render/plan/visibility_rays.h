// render/plan/visibility_rays.h: rays that measure the visibility of every brick: those of a picture with a
// quarter of the pixels along each axis, in long segments.
#pragma once

#include "bricking/levels/visibility.h" // SeenBrick
#include "core/scene/camera.h"
#include "render/contract/ray.h"
#include "render/contract/ray_state.h"
#include "render/contract/strides.h"

namespace tessera {

struct VisibilityRays {
    RayFrame<double> frame;
    Strides strides;
};
/// @param strides  those of the scene's own rays
VisibilityRays visibilityRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize,
                              const Strides& strides);

/// Memory of counting rays beside rayStateBytes().
inline std::size_t countingBytes(const glm::ivec2& size, const glm::ivec3& bricks) {
    return kRayLastBrickBytes * rayCount(size) + sizeof(SeenBrick) * cellCount(bricks);
}
/// Device memory for counting, without the transfer function's table.
/// @param imageSize  of the picture
std::size_t visibilityBytes(const glm::ivec2& imageSize, const glm::ivec3& bricks);

} // namespace tessera
