// render/transport/path_scene.cpp: see path_scene.h.
#include "render/transport/path_scene.h"

#include "core/base/volume.h"
#include "render/transport/phase.h"

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
constexpr float kLaterWidth = 0.36f, kLaterPower = 8; // at least, at most

SurfaceResponses responsesOf(const SurfaceFinish& finish) {
    const auto roughness = static_cast<float>(finish.roughness * finish.roughness);
    const SurfaceResponse first{static_cast<float>(finish.mirrored), roughness,
                                static_cast<float>(finish.translucent),
                                static_cast<float>(finish.translucentPower)};
    SurfaceResponse later = first;
    later.width = std::max(first.width, kLaterWidth);
    later.power = std::min(first.power, kLaterPower);
    return {first, later};
}

/// Of the sky's own frame, where x is the front, y right of who looks there, z up.
glm::vec3 inSky(const PathScene& scene, const glm::vec3& d) {
    const auto along = [&](const glm::vec3& axis) { return d.x * axis.x + d.y * axis.y + d.z * axis.z; };
    return {along(scene.front), along(scene.right), along(scene.up)};
}

/// Which of the two softboxes is seen in a direction of the sky's own frame: squares of twice atan(1/2), 30
/// degrees above the horizon, 45 to the right of the front (1) and to the left (-1); 0: neither.
int softboxAt(const glm::vec3& d) {
    const float side = d.y > 0.0f ? 1.0f : -1.0f;
    constexpr float kAcross = 0.612372436f, kUp = 0.5f, kHalf = 0.707106781f; // cos 30 cos 45, sin 30, cos 45
    const float out = kAcross * (d.x + side * d.y) + kUp * d.z;
    const float aside = kHalf * (side * d.y - d.x);
    const float above = 0.866025404f * d.z - kUp * kHalf * (d.x + side * d.y);
    return std::max(std::abs(aside), std::abs(above)) <= 0.5f * out ? static_cast<int>(side) : 0;
}
glm::vec3 softboxColour(const Environment& sky, const glm::vec3& d) {
    const int box = softboxAt(d);
    return box == 0 ? glm::vec3(0.0f) : glm::vec3(sky.intensity * (box > 0 ? sky.colour : sky.below));
}

/// Of a sky that is a formula: means of its texels, whose middles and quarters are looked at.
std::shared_ptr<const DirectionTable> tableOf(const Environment& sky) {
    constexpr int kColumns = 128, kRows = 64, kPlaces = 4; // of a texel, a side
    std::vector<float> weights;
    weights.reserve(kColumns * kRows);
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            float sum = 0;
            for (int place = 0; place < kPlaces * kPlaces; ++place) {
                const auto at = [](int whole, int part) {
                    return static_cast<float>(whole) + (static_cast<float>(part) + 0.5f) / kPlaces;
                };
                const glm::vec2 down = turnedBy(at(row, place / kPlaces) / (2 * kRows)),
                                turn = turnedBy(at(column, place % kPlaces) / kColumns);
                sum += luminanceOf(softboxColour(sky, {-down.y * turn.x, -down.y * turn.y, down.x}));
            }
            weights.push_back(sum);
        }
    return std::make_shared<const DirectionTable>(glm::ivec2(kColumns, kRows), weights);
}

void setSky(const Environment& sky, const glm::dmat3& axes, PathScene& scene) {
    const glm::dvec3 up = glm::normalize(sky.up);
    // Anterior, as far as up leaves it; else superior.
    const glm::dvec3 ahead = std::abs(up.y) > 0.999 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, -1, 0);
    const glm::dvec3 level = glm::normalize(ahead - glm::dot(ahead, up) * up);
    const double turn = glm::radians(sky.rotation);
    const glm::dvec3 front = std::cos(turn) * level + std::sin(turn) * glm::cross(up, level);
    const auto inPatient = [&](const glm::dvec3& v) {
        return glm::vec3(sky.frame == LightFrame::patient ? v : axes * v);
    };
    scene.up = inPatient(up);
    scene.front = inPatient(front);
    scene.right = inPatient(glm::cross(front, up));
    if (const auto& map = sky.file.map) // its own
        scene.skyTable = {map, &map->table()};
    else if (sky.file.path.empty() && sky.sky == Sky::softboxes)
        scene.skyTable = tableOf(sky);
    if (scene.skyTable && !scene.skyTable->any())
        scene.skyTable = nullptr;
}
} // namespace

PathScene pathScene(const Lighting& lighting, const Camera& camera, const VolumeInfo& info,
                    const Optics& optics, const ExtinctionBounds& bounds, const Occupancy* occupancy,
                    std::uint32_t seed, const std::vector<Tissue>& tissues) {
    PathScene scene;
    scene.optics = &optics;
    scene.bounds = &bounds;
    scene.occupancy = occupancy;
    scene.transport = lighting.transport.value();
    scene.environment = lighting.environment;
    const bool smooth = scene.transport.response == TransportResponse::physical &&
                        scene.transport.normals == ScatteringNormals::sobel;
    scene.normals = smooth ? Gradient::sobel : optics.gradient;
    scene.seed = seed;
    const SurfaceFinish finish = scene.transport.surface ? scene.transport.surface->finish : SurfaceFinish();
    const Phase& phase = scene.transport.phase;
    scene.tissues = {{0, 0, responsesOf(finish), phase, static_cast<float>(meanCosine(phase))}};
    const auto placeAt = [&](double value) {
        return placeOf(optics, static_cast<float>((value - info.rescaleIntercept) / info.rescaleSlope));
    };
    for (const Tissue& tissue : tissues) {
        const Phase own = tissue.phase.value_or(phase);
        scene.tissues.push_back({placeAt(tissue.from), placeAt(tissue.to),
                                 responsesOf(tissue.finish.value_or(finish)), own,
                                 static_cast<float>(meanCosine(own))});
    }
    for (const SurfaceLook& surface : optics.surfaces) {
        scene.isovalues.push_back(surface.isovalue);
        scene.isosurfaces.push_back(responsesOf(surface.finish.value_or(finish)));
    }
    if (const auto& surface = scene.transport.surface) {
        const double perStored = 1 / std::abs(info.rescaleSlope);
        scene.steepFrom = static_cast<float>(surface->gradient.low * perStored);
        scene.perSteep =
            static_cast<float>(std::min(1 / ((surface->gradient.high - surface->gradient.low) * perStored),
                                        double{std::numeric_limits<float>::max()}));
    }
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    scene.voxelFromPatient = glm::mat3(glm::dmat3(voxelFromPatient));
    scene.extent = glm::vec3(info.extentVoxels);
    const glm::dmat3 axes = patientFromCamera(camera);
    if (lighting.environment)
        setSky(*lighting.environment, axes, scene);
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
    if (sky.file.map)
        return of(sky.colour, 1.0f) *
               sky.file.map->radianceAt(sky.file.map->table().texelOf(inSky(scene, direction)));
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
    case Sky::softboxes:
        return softboxColour(sky, inSky(scene, direction));
    }
    return glm::vec3(0.0f);
}

ToSky wayToSky(const PathScene& scene, const glm::vec2& two) {
    const DirectionTable& table = *scene.skyTable;
    const DirectionTable::Drawn drawn = table.draw(two);
    const glm::vec3& d = drawn.direction;
    ToSky to{d.x * scene.front + d.y * scene.right + d.z * scene.up};
    const Environment& sky = *scene.environment;
    to.radiance = sky.file.map ? glm::vec3(sky.intensity * sky.colour) * sky.file.map->radianceAt(drawn.texel)
                               : softboxColour(sky, d);
    to.density = table.densityAt(drawn.texel);
    return to;
}

float skyDensity(const PathScene& scene, const glm::vec3& direction) {
    return scene.skyTable ? scene.skyTable->densityAt(scene.skyTable->texelOf(inSky(scene, direction)))
                          : 0.0f;
}

} // namespace tessera
