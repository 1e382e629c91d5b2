// render/scene_march.cpp: see scene_march.h.
#include "render/scene_march.h"

namespace tessera {

SceneMarch::SceneMarch(std::uint32_t features, const PreparedScene& scene, Ledger& gpu)
    : scene_(scene), gpu_(gpu), features_(features),
      rayCount_(static_cast<std::size_t>(scene.imageSize.x) * static_cast<std::size_t>(scene.imageSize.y)) {
    const Occupancy* occupancy = (features & kFeatureSkipping) ? &scene.occupancy : nullptr;
    if (occupancy && !(features & kFeaturePasses) && scene.optics.surfaces.empty() &&
        refiningPays(*occupancy, rayCount_) && subBlocksPay(*occupancy, rayCount_, features)) {
        const std::size_t march = March::stateBytes(scene.imageSize) + scene.optics.gpuBytes() +
                                  mapBytes(scene.info().extentVoxels, scene.mapScale);
        if (gpu.freeBytes() >=
            march + refiningBytes(scene.table.entries.size()) + SubBlocks::placesBytes(*occupancy)) {
            features_ |= kFeatureSubBlocks;
            subBlocks_ = SubBlocks(*occupancy, gpu);
        }
    }
    march_.emplace(features_, scene.frame, scene.info(), scene.strides(), scene.optics, occupancy, gpu);
    if (features_ & kFeatureSubBlocks)
        march_->useSubBlocks(subBlocks_);
    if (occupancy && scene.mapsNearSurfaces)
        march_->setNearSurfaces(scene.nearSurfaces);
}

std::size_t SceneMarch::refine(const FieldSource& source) {
    if (!(features_ & kFeatureSkipping) || (features_ & kFeaturePasses))
        return 0;
    const auto refined = [&](const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table,
                             SubBlocks* subBlocks) {
        if (!refiningPays(occupancy, rayCount_) || gpu_.freeBytes() < refiningBytes(table.entries.size()))
            return std::size_t{0};
        return refineSkipping(map, occupancy, table, scene_.optics, features_, scene_.info(), source, gpu_,
                              subBlocks);
    };
    if (scene_.mapsNearSurfaces)
        refined(march_->nearSurfacesMap(), scene_.nearSurfaces, scene_.surfaceTable, nullptr);
    return refined(march_->skippingMap(), scene_.occupancy, scene_.table,
                   (features_ & kFeatureSubBlocks) ? &subBlocks_ : nullptr);
}

} // namespace tessera
