// render/transport/path_scene.cpp: see path_scene.h.
#include "render/transport/path_scene.h"

#include "core/base/volume.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <limits>

namespace tessera {

namespace {
/// As the reference's rays of shadow.
constexpr double kLeavesFromVoxels = 2;
/// A narrow highlight that few of a pixel's paths meet at their second place is a bright speck.
constexpr float kLaterWidth = 0.36f;
} // namespace

PathScene pathScene(const Lighting& lighting, const Camera& camera, const VolumeInfo& info,
                    const Optics& optics, const ExtinctionBounds& bounds, const Occupancy* occupancy,
                    std::uint32_t seed) {
    PathScene scene;
    scene.optics = &optics;
    scene.bounds = &bounds;
    scene.occupancy = occupancy;
    scene.transport = lighting.transport.value();
    scene.environment = lighting.environment;
    scene.seed = seed;
    if (const auto& surface = scene.transport.surface) {
        const double perStored = 1 / std::abs(info.rescaleSlope);
        scene.steepFrom = static_cast<float>(surface->gradient.low * perStored);
        scene.perSteep =
            static_cast<float>(std::min(1 / ((surface->gradient.high - surface->gradient.low) * perStored),
                                        double{std::numeric_limits<float>::max()}));
        scene.surface.mirrored = static_cast<float>(surface->mirrored);
        scene.surface.width = static_cast<float>(surface->roughness * surface->roughness);
        scene.laterSurface = {scene.surface.mirrored, std::max(scene.surface.width, kLaterWidth)};
    }
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    scene.voxelFromPatient = glm::mat3(glm::dmat3(voxelFromPatient));
    scene.extent = glm::vec3(info.extentVoxels);
    if (lighting.environment)
        scene.up = glm::vec3(glm::normalize(lighting.environment->up));
    const glm::dmat3 axes = patientFromCamera(camera);
    const auto inPatient = [&](const Light& light, const glm::dvec3& v) {
        return light.frame == LightFrame::patient ? v : axes * v;
    };
    scene.occlusion = lighting.occlusion;
    scene.leavesFromMm = static_cast<float>(
        kLeavesFromVoxels * std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel)))));
    int number = -1;
    for (const Light& light : shiningLights(lighting.lights)) {
        PathLight path;
        path.number = ++number;
        path.casts = light.shadow && light.kind != LightKind::head;
        path.power = glm::vec3(glm::pi<double>() * light.intensity * light.colour);
        path.cosine = static_cast<float>(std::cos(glm::radians(0.5 * light.softness)));
        const bool atEye = light.kind == LightKind::head;
        path.isPoint =
            light.kind == LightKind::point || (atEye && camera.projection == Projection::perspective);
        if (path.isPoint) {
            const glm::dvec3 place = atEye ? camera.position
                                     : light.frame == LightFrame::patient
                                         ? light.position
                                         : camera.position + inPatient(light, light.position);
            path.towards = glm::vec3(glm::dvec3(voxelFromPatient * glm::dvec4(place, 1)));
            if (!atEye)
                path.fading = glm::vec3(light.attenuation);
        } else {
            const glm::dvec3 towards = atEye ? axes[2] : inPatient(light, light.direction);
            if (!(glm::length(towards) > 0))
                continue; // it lights nothing from anywhere
            path.towards = glm::vec3(glm::normalize(towards));
        }
        scene.lights.push_back(path);
    }
    return scene;
}

glm::vec3 skyFrom(const PathScene& scene, const glm::vec3& direction) {
    if (!scene.environment)
        return glm::vec3(0.0f);
    const Environment& sky = *scene.environment;
    const auto of = [&](const glm::dvec3& colour, float share) {
        return glm::vec3(sky.intensity * colour) * share;
    };
    const float height = direction.x * scene.up.x + direction.y * scene.up.y + direction.z * scene.up.z;
    switch (sky.sky) {
    case Sky::uniform:
        return of(sky.colour, 1.0f);
    case Sky::overcast:
        return height > 0.0f ? of(sky.colour, (1.0f + 2.0f * height) * (1.0f / 3.0f)) : glm::vec3(0.0f);
    case Sky::twoTone: {
        const float share = 0.5f + 0.5f * height;
        return of(sky.colour, share) + of(sky.below, 1.0f - share);
    }
    }
    return glm::vec3(0.0f);
}

} // namespace tessera
