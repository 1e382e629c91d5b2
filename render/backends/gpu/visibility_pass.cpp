// render/backends/gpu/visibility_pass.cpp: see visibility_pass.h.
#include "render/backends/gpu/visibility_pass.h"

namespace tessera {

VisibilityPass::VisibilityPass(std::uint32_t features, const VolumeInfo& info, MemoryBudget& gpu)
    : features_((features & (kFeatureNormalised | kFeatureMixed)) | kFeatureHardware | kFeatureVisibility),
      info_(info), gpu_(gpu) {}

void VisibilityPass::begin(const VisibilityRays& rays, const Optics& optics) {
    if (march_) {
        march_->setFunction(optics);
        march_->restart({rays.frame, rays.strides}, nullptr);
    } else {
        march_.emplace(features_, rays.frame, info_, rays.strides, optics, nullptr, gpu_);
    }
}

bool VisibilityPass::countUntil(const FieldSource& source, const Slicing& slicing,
                                March::Clock::time_point deadline, Work& work) {
    return march_->runUntil(source, slicing, deadline, work);
}

std::vector<SeenBrick> VisibilityPass::count(const VisibilityRays& rays, const FieldSource& source,
                                             const Optics& optics, Work& work) {
    begin(rays, optics);
    march_->run(source, Slicing{}, work);
    return seen();
}

} // namespace tessera
