// render/plan/visibility_rays.cpp: see visibility_rays.h.
#include "render/plan/visibility_rays.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr int kPixelsPerRay = 4;     // along each axis: a brick that matters covers many pixels
constexpr double kSegmentVoxels = 1; // opacities need no shorter ones
glm::ivec2 smallSize(const glm::ivec2& imageSize) {
    return glm::max((imageSize + (kPixelsPerRay - 1)) / kPixelsPerRay, glm::ivec2(1));
}

} // namespace

VisibilityRays visibilityRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize,
                              const Strides& strides) {
    VisibilityRays rays{{}, strides};
    rays.strides.segmentVoxels = std::max(kSegmentVoxels, strides.segmentVoxels);
    rays.frame = rayFrame(camera, info, smallSize(imageSize), rays.strides.segmentVoxels);
    return rays;
}

std::size_t visibilityBytes(const glm::ivec2& imageSize, const glm::ivec3& bricks) {
    const glm::ivec2 size = smallSize(imageSize);
    return rayStateBytes(size) + countingBytes(size, bricks);
}

} // namespace tessera
