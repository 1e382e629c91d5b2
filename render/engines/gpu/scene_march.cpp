// render/engines/gpu/scene_march.cpp: see scene_march.h.
#include "render/engines/gpu/scene_march.h"

#include "render/residency/texels.h"

namespace tessera {

std::uint32_t marchFeatures(const PreparedScene& scene, bool counting) {
    std::uint32_t f = 0;
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
    : source{&atlas, scene.selection.finest(), nullptr, nullptr} {
    if (!scene.mixed())
        return;
    source.map = &scene.levels;
    source.textures = &textures.emplace(scene.levels, gpu);
}

SceneMarch::SceneMarch(std::uint32_t features, const PreparedScene& scene, Ledger& gpu)
    : scene_(scene), gpu_(gpu), features_(features),
      rayCount_(static_cast<std::size_t>(scene.imageSize.x) * static_cast<std::size_t>(scene.imageSize.y)),
      march_(features, scene.frame, scene.info(), scene.strides(), scene.optics,
             (features & kFeatureSkipping) ? &scene.occupancy : nullptr, gpu) {
    if ((features & kFeatureSkipping) && scene.mapsNearSurfaces)
        march_.setNearSurfaces(scene.nearSurfaces);
}

std::size_t SceneMarch::refine(const FieldSource& source) {
    if (!(features_ & kFeatureSkipping) || (features_ & kFeaturePasses))
        return 0;
    const auto refined = [&](const GlTexture3d& map, const Occupancy& occupancy, const TransferTable& table) {
        if (!refiningPays(occupancy, rayCount_) || gpu_.freeBytes() < refiningBytes(table.entries.size()))
            return std::size_t{0};
        return refineSkipping(map, occupancy, table, scene_.optics, features_, scene_.info(), source, gpu_);
    };
    if (scene_.mapsNearSurfaces)
        refined(march_.nearSurfacesMap(), scene_.nearSurfaces, scene_.surfaceTable);
    return refined(march_.skippingMap(), scene_.occupancy, scene_.table);
}

} // namespace tessera
