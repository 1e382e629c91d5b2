// render/backends/reference/light_sources.cpp: see light_sources.h.
#include "render/backends/reference/light_sources.h"

#include "core/base/brick.h"
#include "core/base/error.h"
#include "render/backends/reference/stored_function.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/trigonometric.hpp>
#include <numbers>

namespace tessera {
namespace {

constexpr double kGoldenAngle = std::numbers::pi * (3 - 2.23606797749978969641); // 3 - sqrt(5)

/// Across a direction: two unit vectors at right angles to it and to each other, the second its "up".
std::array<glm::dvec3, 2> across(const glm::dvec3& direction) {
    const glm::dvec3 axis = std::abs(direction.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    const glm::dvec3 up = glm::normalize(axis - direction * glm::dot(axis, direction));
    return {glm::cross(up, direction), up};
}

/// Middle of the box around all bricks that can show something, patient space.
glm::dvec3 middleOfWhatShows(const ReferenceInput& input) {
    glm::dvec3 low(0), high(input.info->extentVoxels);
    if (const Statistics* s = input.statistics) {
        const StoredFunction function(*input.function, input.surfaces, *input.info);
        glm::ivec3 first = s->bricks, last(-1);
        for (std::size_t b = 0; b < s->wideMin.size(); ++b)
            if ((s->showsOfBrick(b, 2) & kShowsMedium) != 0 ||
                (s->showsOfBrick(b, 2) != 0 &&
                 !function.emptyOver(double{s->wideMin[b]}, double{s->wideMax[b]}))) {
                first = glm::min(first, gridPosition(b, s->bricks));
                last = glm::max(last, gridPosition(b, s->bricks));
            }
        if (last.x >= 0) {
            low = glm::dvec3(first * kBrickExtent);
            high = glm::min(high, glm::dvec3((last + 1) * kBrickExtent));
        }
    }
    return glm::dvec3(input.info->patientFromVoxel * glm::dvec4(0.5 * (low + high), 1));
}

} // namespace

LightSources::LightSources(const ReferenceInput& input) {
    meshes = input.meshes;
    if (scatters(input.lighting))
        throw InputError(
            "lighting.lights: expected none with \"scatter\", whose light the reference does not "
            "gather, found one");
    hasOcclusion = input.lighting.occlusion.has_value();
    ambientChannels = tessera::ambientChannels(input.lighting);
    if (hasOcclusion) {
        occlusion = *input.lighting.occlusion;
        if (occlusion.method == OcclusionMethod::histogram)
            throw InputError("lighting.occlusion.method: expected a method of rays, which the reference "
                             "integrates, found histogram");
        directions = occlusionDirections(occlusion);
    }
    offsetMm =
        kOffsetVoxels * std::cbrt(std::abs(glm::determinant(glm::dmat3(input.info->patientFromVoxel))));
    const glm::dmat3 axes = patientFromCamera(input.camera);
    for (const Light& light : castingLights(input.lighting.lights)) {
        const bool withCamera = light.frame == LightFrame::camera;
        Caster caster;
        caster.isPoint = light.kind == LightKind::point;
        glm::dvec3 middle(0),
            towards(0); // of the disk; from the lit region, which sets the disk's orientation
        double far = 1;
        if (caster.isPoint) {
            middle = withCamera ? input.camera.position + axes * light.position : light.position;
            towards = middleOfWhatShows(input) - middle;
            far = glm::length(towards);
            towards = far > 0 ? towards / far : glm::dvec3(0, 0, 1);
        } else {
            // A light without a direction gets that of the others.
            const double length = glm::length(light.direction);
            const glm::dvec3 d = length > 0 ? light.direction / length : glm::dvec3(0, 0, 1);
            middle = withCamera && length > 0 ? axes * d : d;
            towards = middle;
        }
        caster.middle = middle;
        const int places = light.softness > 0 && far > 0 ? kPlacesOfSoftLight : 1;
        const double radius = far * std::tan(glm::radians(light.softness / 2));
        const auto [right, up] = across(towards);
        for (int n = 0; n < places; ++n) {
            const double out = places > 1 ? radius * std::sqrt((n + 0.5) / places) : 0;
            const glm::dvec3 place =
                middle + out * std::cos(n * kGoldenAngle) * right + out * std::sin(n * kGoldenAngle) * up;
            caster.places.push_back(caster.isPoint ? place : glm::normalize(place));
        }
        casters.push_back(caster);
    }
}

} // namespace tessera
