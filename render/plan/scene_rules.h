// render/plan/scene_rules.h: what of a scene does not go together, or is not implemented. All throw
// InputError naming the key.
#pragma once

#include "core/scene/scene.h"
#include "render/plan/frame_plan.h"

#include <algorithm>

namespace tessera {

/// True if occlusion of surfaces takes the place of that of voxels: not where meshes alone have it.
inline bool replacesLightOfVoxels(const Scene& scene) {
    const bool surfaces = std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                                      [](const Isosurface& s) { return s.drawnOpacity() > 0; });
    return scene.lighting.surfaceOcclusion &&
           (surfaces || scene.mode == Mode::isosurface || !drawsMeshes(scene));
}
/// Lights, occlusion and scattered light, by the scene alone.
void checkLight(const Scene& scene);
/// The same, and the integrator.
void checkScene(const Scene& scene);
/// What several processes, each of which has a part of the volume, cannot draw together.
void checkShared(const Scene& scene);
/// Occlusion of surfaces, reflections and paths of light, by what the plan draws. Its layers and view are
/// planned.
void checkPlan(const Scene& scene, const FramePlan& plan);

} // namespace tessera
