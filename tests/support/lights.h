// tests/support/lights.h: scenes that ask for all that there is of light: every kind and frame, half of which
// stands inside the volume, materials, and weights of gradients.
#pragma once

#include "core/base/volume.h"
#include "core/scene/preset.h"
#include "core/scene/scene.h"
#include "render/plan/planner.h"

#include <string>

namespace tessera::test {

/// Four lights; the point light that is fixed to the patient is inside the volume, on a corner of bricks.
inline std::vector<Light> fourLights(const VolumeInfo& info) {
    std::vector<Light> lights(4);
    lights[0].intensity = 0.3;
    lights[1].kind = LightKind::directional;
    lights[1].direction = {-1, 2, 0.5};
    lights[1].colour = {1, 0.8, 0.4};
    lights[1].intensity = 0.7;
    lights[2].kind = LightKind::point;
    lights[2].frame = LightFrame::patient;
    lights[2].position = glm::dvec3(info.patientFromVoxel * glm::dvec4(32, 32, 32, 1));
    lights[2].attenuation = {1, 0.02, 0.001};
    lights[2].intensity = 3;
    lights[3].kind = LightKind::point;
    lights[3].position = {150, 100, -50};
    lights[3].colour = {0.2, 0.4, 1};
    return lights;
}

/// A preset with two materials side by side, of values in HU.
inline TransferFunction presetWithMaterials(const std::string& preset) {
    ValueSummary values;
    values.isHu = true;
    TransferFunction function = presetFunction(preset, values);
    function.setMaterials({{60, 200, 0.3, 0.5, 0.1, 5}, {200, 4000, 0.1, 0.7, 0.5, 77}});
    return function;
}

/// @param materials  of a scene whose function is a preset by name
inline void lightWithAll(Scene& scene, const VolumeInfo& info, ShadingModel model, bool materials) {
    scene.lighting.lights = fourLights(info);
    scene.shading.model = model;
    scene.shading.gradientWeight = GradientWeight{2, 60};
    if (materials)
        scene.volumes[0].transferFunction =
            presetWithMaterials(std::get<std::string>(scene.volumes[0].transferFunction));
}

/// All that there is of light, for a plan that is made.
inline void lightPlanWithAll(Planner& p) {
    Shading shading;
    shading.gradientWeight = GradientWeight{2, 60};
    Lighting lighting;
    lighting.lights = fourLights(p.info());
    setLighting(p.layer().optics, shading, lighting, presetWithMaterials("bone-1").materials(), p.view.camera,
                p.info());
}

} // namespace tessera::test
