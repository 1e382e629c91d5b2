// tests/support/occluded_surfaces.h: isosurfaces of the torso that darken one another, alone and in a volume
// that shows.
#pragma once

#include "render/light/surface_light.h"
#include "render/picture/render_scene.h"
#include "tests/support/surface_fixture.h"

#include <vector>

namespace tessera::test {

inline Scene occludedScene(int camera, const glm::ivec2& size = {24, 24},
                           const SurfaceOcclusion& occlusion = {}) {
    Scene scene = torsoScene(camera, false, Integrator::midpoint, size);
    scene.surfaces = {{180, {0.9, 0.6, 0.5}, 0.7}, {250, {0.95, 0.9, 0.8}, 1}}; // the ribs' edge, and deeper
    scene.shading.ambient = 0.8, scene.shading.diffuse = 0.2, scene.shading.specular = 0;
    scene.lighting.surfaceOcclusion = occlusion;
    return scene;
}

/// The same in a volume that shows: soft tissue and, graded, its edges.
inline Scene inVolume(Scene scene, bool graded = false) {
    TransferFunction tissue = TransferFunction::fromOpacity(
        {{-150, 0}, {-50, 0.02}, {100, 0.05}}, {{-50, {0.9, 0.7, 0.5}}, {100, {0.8, 0.3, 0.3}}}, 3);
    if (graded)
        tissue.setGradientOpacity(GradientOpacity::fromPoints({{0, 0.1}, {30, 1}}));
    scene.volumes[0].transferFunction = tissue;
    return scene;
}

inline std::vector<LightTaken> traced(const SurfaceTracer& tracer, const std::vector<LightWay>& ways) {
    std::vector<LightTaken> taken(ways.size());
    tracer.trace(ways, taken);
    return taken;
}

/// Bricks of the torso that the native engine leaves out because no ray comes near them.
inline std::size_t unseenBricks(const Scene& scene) {
    Budgets budgets;
    const StoreReader store(storePath("torso"), budgets.ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    return renderScene(scene, store, budgets.ram, budgets.gpu, options).unseenBricks;
}

} // namespace tessera::test
