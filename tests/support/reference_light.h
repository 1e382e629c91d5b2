// tests/support/reference_light.h: the reference's rays of light, for tests: through prepared scenes, and
// what they are made of.
#pragma once

#include "render/backends/reference/light_rays.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace tessera::test {

/// What was measured, for those who ask: TESSERA_TELL=1.
template <typename... Values> void tell(const char* format, const Values&... values) {
    if (std::getenv("TESSERA_TELL"))
        std::printf(format, values...);
}

inline ReferenceInput referenceInput(const Prepared& prepared, const Scene& scene) {
    const FramePlan& p = prepared.p;
    return {p.layer().cache.get(), &p.info(), &p.layer().function, scene.shading, &p.layer().statistics, 1,
            scene.surfaces,        {},        p.view.lighting,     p.view.camera};
}
inline Image referencePicture(const ReferenceInput& input, const Prepared& prepared) {
    const FramePlan& p = prepared.p;
    Image image(p.view.imageSize);
    const auto values = renderReference(input, referenceRays(p.view.camera, p.info(), p.view.imageSize), 0);
    std::transform(values.begin(), values.end(), image.pixels.begin(),
                   [](const glm::dvec4& v) { return glm::vec4(v); });
    return image;
}

/// Rays of light through a volume, and what they are made of.
struct RaysOfLight {
    RaysOfLight(const Prepared& prepared, const Scene& scene, int panels = 1)
        : input(referenceInput(prepared, scene)), function(*input.function, input.surfaces, *input.info),
          optics(shadingOf(input)), obstacles(function, *input.info), sources(input),
          samples(*input.cache, *input.info, 0, nullptr),
          light(*input.info, optics, obstacles, sources, emptyCells, samples, nullptr, panels) {}
    glm::dvec3 patient(const glm::dvec3& voxel) const {
        return glm::dvec3(input.info->patientFromVoxel * glm::dvec4(voxel, 1));
    }
    glm::dvec3 voxelsPerMm(const glm::dvec3& direction) const {
        return glm::inverse(glm::dmat3(input.info->patientFromVoxel)) * direction;
    }
    ReferenceInput input;
    StoredFunction function;
    Optics optics;
    Obstacles obstacles;
    LightSources sources;
    EmptyCells emptyCells;
    LatticeReader samples;
    LightRays light;
};

/// From one side, and casts a shadow.
inline Light keyLight(double softness = 0) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = {-1, 1, 1};
    light.shadow = true;
    light.softness = softness;
    return light;
}

} // namespace tessera::test
