// render/engines/gpu/scene_march.cpp: see scene_march.h.
#include "render/engines/gpu/scene_march.h"

#include "render/residency/texels.h"

namespace tessera {

std::uint32_t marchFeatures(const PreparedScene& scene, bool counting) {
    std::uint32_t f = kFeatureBricked;
    const auto add = [&](bool needed, Feature feature) { f |= needed ? feature : 0u; };
    add(scene.mixed(), kFeatureMixed);
    add(scene.optics.shading, kFeatureShading);
    if (scene.optics.shading || !scene.optics.surfaces.empty())
        f |= gradientFeature(scene.optics.gradient);
    add(scene.quality.skipping, kFeatureSkipping);
    add(scene.quality.fetch == Fetch::hardware, kFeatureHardware);
    add(texelFormat(scene.info().type).normalised, kFeatureNormalised);
    add(scene.optics.termination > 0, kFeatureTermination);
    add(counting, kFeatureCounting);
    add(!scene.optics.surfaces.empty(), kFeatureSurfaces);
    return f | integratorFeatures(scene.optics.integrator);
}

SceneField::SceneField(const PreparedScene& scene, const Atlas& atlas, Ledger& gpu)
    : source{&atlas, nullptr, scene.selection.finest(), nullptr, nullptr} {
    if (!scene.mixed())
        return;
    source.map = &scene.levels;
    source.textures = &textures.emplace(scene.levels, gpu);
}

SceneMarch::SceneMarch(std::uint32_t features, const PreparedScene& scene, Ledger& gpu)
    : scene_(scene), gpu_(gpu), features_(features),
      rayCount_(static_cast<std::size_t>(scene.imageSize.x) * static_cast<std::size_t>(scene.imageSize.y)) {
    const Occupancy* occupancy = (features & kFeatureSkipping) ? &scene.occupancy : nullptr;
    if (occupancy && !(features & kFeaturePasses) && scene.optics.surfaces.empty() &&
        refiningPays(*occupancy, rayCount_) && subBlocksPay(*occupancy, rayCount_, features)) {
        const std::size_t march = rayStateBytes(scene.imageSize) + scene.optics.gpuBytes() +
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
