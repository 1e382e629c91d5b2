// render/visibility_pass.cpp: see visibility_pass.h.
#include "render/visibility_pass.h"

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

VisibilityPass::VisibilityPass(std::uint32_t features, const VolumeInfo& info, Ledger& gpu)
    : features_((features & (kFeatureBricked | kFeatureNormalised | kFeatureMixed)) | kFeatureHardware |
                kFeatureVisibility),
      info_(info), gpu_(gpu) {}

std::size_t VisibilityPass::bytes(const glm::ivec2& imageSize, const glm::ivec3& bricks) {
    const glm::ivec2 size = smallSize(imageSize);
    return March::stateBytes(size) + March::visibilityBytes(size, bricks);
}

void VisibilityPass::begin(const VisibilityRays& rays, const Optics& optics) {
    if (march_) {
        march_->setFunction(optics);
        march_->restart(rays.frame, rays.strides, nullptr);
    } else {
        march_.emplace(features_, rays.frame, info_, rays.strides, optics, nullptr, gpu_);
    }
}

bool VisibilityPass::countUntil(const FieldSource& source, const MarchSlicing& slicing,
                                March::Clock::time_point deadline, Work& work) {
    return march_->runUntil(source, slicing, deadline, work);
}

std::vector<SeenBrick> VisibilityPass::count(const VisibilityRays& rays, const FieldSource& source,
                                             const Optics& optics, Work& work) {
    begin(rays, optics);
    march_->run(source, MarchSlicing{}, work);
    return seen();
}

} // namespace tessera
