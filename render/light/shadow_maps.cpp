// render/light/shadow_maps.cpp: see shadow_maps.h.
#include "render/light/shadow_maps.h"

#include "core/base/error.h"
#include "render/light/light_sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <limits>

namespace tessera {
namespace {

constexpr double kWidestView = 110; // degrees: above this six maps waste fewer rays
constexpr double kGoldenAngle = 2.399963229728653;

/// Corners of the box of visible bricks, patient space.
std::vector<glm::dvec3> shownCorners(const LightPath& field) {
    const glm::ivec3 grid = field.selection->bricks;
    glm::ivec3 low = grid, high(-1);
    for (std::size_t b = 0; b < field.selection->levels.size(); ++b)
        if (field.selection->levels[b] != Selection::kEmpty) {
            low = glm::min(low, gridPosition(b, grid));
            high = glm::max(high, gridPosition(b, grid));
        }
    if (high.x < 0) { // nothing shows
        low = glm::ivec3(0);
        high = glm::ivec3(0);
    }
    const glm::dvec3 from(low * kBrickExtent),
        to(glm::min((high + 1) * kBrickExtent, field.info->extentVoxels));
    std::vector<glm::dvec3> corners;
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 corner((n & 1) != 0 ? to.x : from.x, (n & 2) != 0 ? to.y : from.y,
                                (n & 4) != 0 ? to.z : from.z);
        corners.emplace_back(field.info->patientFromVoxel * glm::dvec4(corner, 1));
    }
    return corners;
}

glm::dvec3 middleOf(const std::vector<glm::dvec3>& corners) {
    glm::dvec3 sum(0);
    for (const glm::dvec3& c : corners)
        sum += c;
    return sum / static_cast<double>(corners.size());
}

/// At right angles to a direction, the same for directions that are nearly the same.
glm::dvec3 upFor(const glm::dvec3& direction) {
    const glm::dvec3 axis =
        std::abs(direction.z) < 0.9 * glm::length(direction) ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    return glm::normalize(axis - direction * (glm::dot(axis, direction) / glm::dot(direction, direction)));
}

/// The n-th of points spread evenly over a disk of radius 1.
glm::dvec2 onDisk(int n, int count) {
    const double radius = std::sqrt((n + 0.5) / count), angle = n * kGoldenAngle;
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

int mapsOf(double softness) {
    return softness > 0 ? ShadowQuality::kMapsOfSoftLight : 1;
}
int sizeOf(double softness, const ShadowQuality& quality) {
    return std::max(1, softness > 0 ? quality.mapSize / 2 : quality.mapSize);
}
int lightMapSizeOf(bool isSoft, const ShadowQuality& quality) {
    return std::max(LightMapping::kLeastSize / 2,
                    quality.lightMap->size / quality.lightMapPart / (isSoft ? 2 : 1));
}

Camera parallelCamera(const glm::dvec3& towards, const std::vector<glm::dvec3>& corners) {
    Camera camera;
    camera.projection = Projection::parallel;
    camera.focalPoint = middleOf(corners);
    camera.viewUp = upFor(towards);
    const glm::dvec3 right = glm::cross(camera.viewUp, towards);
    double half = 0, far = 0;
    for (const glm::dvec3& c : corners) {
        const glm::dvec3 d = c - camera.focalPoint;
        half = std::max({half, std::abs(glm::dot(d, right)), std::abs(glm::dot(d, camera.viewUp))});
        far = std::max(far, glm::length(d));
    }
    camera.position = camera.focalPoint + towards * (2 * far);
    camera.parallelScale = half;
    return camera;
}

Camera eyeAt(const glm::dvec3& position, const glm::dvec3& forward, double degrees) {
    Camera camera;
    camera.projection = Projection::perspective;
    camera.position = position;
    camera.focalPoint = position + forward;
    camera.viewUp = upFor(forward);
    camera.viewAngle = degrees;
    return camera;
}

/// Full angle of a square view from a point that holds all corners; 360 if none does.
double angleFor(const glm::dvec3& position, const std::vector<glm::dvec3>& corners) {
    const glm::dvec3 middle = middleOf(corners) - position;
    if (!(glm::length(middle) > 0))
        return 360;
    const glm::dvec3 forward = glm::normalize(middle), up = upFor(forward), right = glm::cross(up, forward);
    double tangent = 0;
    for (const glm::dvec3& c : corners) {
        const glm::dvec3 d = c - position;
        const double along = glm::dot(d, forward);
        if (!(along > 0))
            return 360;
        tangent =
            std::max({tangent, std::abs(glm::dot(d, right)) / along, std::abs(glm::dot(d, up)) / along});
    }
    return 2 * glm::degrees(std::atan(tangent));
}

} // namespace

PlacedLight placedLight(const Light& light, const Camera& camera) {
    const glm::dmat3 axes = light.frame == LightFrame::camera ? patientFromCamera(camera) : glm::dmat3(1);
    PlacedLight placed;
    placed.isPoint = light.kind == LightKind::point;
    placed.softness = light.softness;
    placed.scatters = light.scatter > 0;
    const double length = glm::length(light.direction);
    if (length > 0)
        placed.towards = axes * (light.direction / length);
    placed.position =
        light.frame == LightFrame::camera ? camera.position + axes * light.position : light.position;
    return placed;
}

namespace {

std::size_t bytesOfMap(ShadowMapKind kind, int size) {
    switch (kind) {
    case ShadowMapKind::first:
        return FirstHitMap::bytes(size);
    case ShadowMapKind::variance:
        return VarianceMap::bytes(size);
    case ShadowMapKind::deep:
        break;
    }
    return DeepShadowMap::bytes(size);
}

/// @param rayMm  distance of neighbouring rays
/// @param middleMm  of what they see, from their start
/// @param oneOfSides  of six views from one place
std::shared_ptr<ShadowMap> mapOf(const ShadowQuality& quality, int size, double voxelMm, double rayMm,
                                 double middleMm, bool oneOfSides) {
    constexpr double kMostBias = 4, kLeastDeviation = 0.02; // voxels
    const ShadowMapping& mapping = quality.mapping;
    const FirstHits hits{static_cast<float>(mapping.threshold), mapping.filter,
                         static_cast<float>(std::min(mapping.filter * rayMm, kMostBias * voxelMm)),
                         oneOfSides};
    switch (mapping.kind) {
    case ShadowMapKind::first:
        return std::make_shared<FirstHitMap>(size, hits);
    case ShadowMapKind::variance:
        return std::make_shared<VarianceMap>(size, hits, static_cast<float>(middleMm),
                                             static_cast<float>(kLeastDeviation * voxelMm));
    case ShadowMapKind::deep:
        break;
    }
    return std::make_shared<DeepShadowMap>(size, quality.layers);
}

} // namespace

ShadowQuality qualityOf(ShadowQuality quality, const Lighting& lighting) {
    quality.mapping = lighting.shadowMap;
    quality.lightMap.reset();
    if (scattersByMaps(lighting))
        quality.lightMap = lighting.lightMap;
    return quality;
}

std::size_t ShadowMaps::bytes(const Light& light, const ShadowQuality& quality) {
    const int sides = light.kind == LightKind::point ? 6 : 1;
    std::size_t bytes = bytesOfMap(quality.mapping.kind, sizeOf(light.softness, quality));
    if (quality.lightMap && light.scatter > 0)
        bytes += LightMap::bytes(lightMapSizeOf(light.softness > 0, quality));
    return static_cast<std::size_t>(mapsOf(light.softness) * sides) * bytes;
}

std::size_t ShadowMaps::sweepBytes(const Light& light, const ShadowQuality& quality) {
    return quality.lightMap && light.scatter > 0
               ? MapSweep::bytes(lightMapSizeOf(light.softness > 0, quality))
               : 0;
}

void ShadowMaps::addView(const Camera& camera, const VolumeInfo& info, const std::vector<glm::dvec3>& corners,
                         bool scatters) {
    View view;
    view.camera = camera;
    view.plane = rayPlane(camera, info, {size_, size_});
    view.right = view.plane.right / glm::dot(view.plane.right, view.plane.right);
    view.up = view.plane.up / glm::dot(view.plane.up, view.plane.up);
    view.far = glm::length(view.plane.toCentre);
    if (!view.plane.perspective)
        rayMm_ = std::max(rayMm_, quality_.offset * camera.parallelScale / size_);
    const double voxelMm = std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
    views_.push_back(view);
    maps_.push_back(mapOf(quality_, size_, voxelMm, 2 * glm::length(view.plane.right) / size_,
                          view.plane.perspective ? view.far : 0, perLight_ > 1));
    if (!quality_.lightMap || !scatters)
        return;
    const RayPlane& plane = view.plane;
    double nearMm = std::numeric_limits<double>::max(), farMm = std::numeric_limits<double>::lowest();
    for (const glm::dvec3& corner : corners) {
        const glm::dvec3 from = corner - (plane.perspective ? camera.position : plane.centre);
        const double along = glm::dot(from, plane.forward);
        nearMm = std::min(nearMm, along);
        farMm = std::max(farMm, plane.perspective ? glm::length(from) : along);
    }
    if (plane.perspective)
        nearMm = perLight_ > 1 ? 0 : std::max(0.0, nearMm);
    const int size = lightMapSizeOf(isSoft_, quality_);
    const double rayMm = 2 * glm::length(plane.right) / size / (plane.perspective ? view.far : 1);
    LightGrid grid = LightGrid::between(nearMm, farMm, rayMm, size, plane.perspective);
    grid.oneOfSides = perLight_ > 1;
    lightMaps_.push_back(std::make_shared<LightMap>(grid));
}

ShadowMaps::ShadowMaps(const PlacedLight& light, const LightPath& field, const ShadowQuality& quality)
    : quality_(quality), light_(light.isPoint ? light.position : light.towards), isPoint_(light.isPoint),
      offsetMm_(quality.offset *
                std::cbrt(std::abs(glm::determinant(glm::dmat3(field.info->patientFromVoxel))))) {
    const std::vector<glm::dvec3> corners = shownCorners(field);
    size_ = sizeOf(light.softness, quality);
    isSoft_ = light.softness > 0;
    const int maps = mapsOf(light.softness);
    const double half = std::tan(glm::radians(light.softness / 2));
    const bool toAllSides = light.isPoint && angleFor(light.position, corners) > kWidestView;
    perLight_ = toAllSides ? 6 : 1;
    for (int n = 0; n < maps; ++n) {
        const glm::dvec2 side = maps > 1 ? half * onDisk(n, maps) : glm::dvec2(0);
        if (!light.isPoint) {
            const glm::dvec3 up = upFor(light.towards), right = glm::cross(up, light.towards);
            addView(parallelCamera(glm::normalize(light.towards + side.x * right + side.y * up), corners),
                    *field.info, corners, light.scatters);
            continue;
        }
        const glm::dvec3 middle = middleOf(corners) - light.position;
        const double far = glm::length(middle);
        glm::dvec3 position = light.position;
        if (far > 0 && maps > 1) {
            const glm::dvec3 forward = middle / far, up = upFor(forward);
            position += far * (side.x * glm::cross(up, forward) + side.y * up);
        }
        if (!toAllSides) {
            const double angle = std::clamp(angleFor(position, corners), 1.0, 150.0);
            addView(eyeAt(position, glm::normalize(middleOf(corners) - position), angle), *field.info,
                    corners, light.scatters);
        } else {
            for (int axis = 0; axis < 3; ++axis)
                for (const double sign : {1.0, -1.0}) {
                    glm::dvec3 forward(0);
                    forward[axis] = sign;
                    addView(eyeAt(position, forward, 90), *field.info, corners, light.scatters);
                }
        }
    }
}

bool ShadowMaps::placeOn(const View& view, const glm::dvec3& place, glm::vec2& at, float& mm) const {
    const auto size = static_cast<double>(size_);
    double x = 0, y = 0;
    if (view.plane.perspective) {
        const glm::dvec3 d = place - view.camera.position;
        const double along = glm::dot(d, view.plane.forward);
        if (!(along > 0))
            return false;
        x = glm::dot(d, view.right) * view.far / along;
        y = glm::dot(d, view.up) * view.far / along;
        mm = static_cast<float>(glm::length(d));
    } else {
        const glm::dvec3 d = place - view.plane.centre;
        x = glm::dot(d, view.right);
        y = glm::dot(d, view.up);
        mm = static_cast<float>(glm::dot(d, view.plane.forward));
    }
    at = glm::vec2(0.5 * (1 + x) * size, 0.5 * (1 - y) * size);
    return true;
}

namespace {
/// The side of six on which a direction lies: x, y and z, up and down each.
std::size_t sideOf(const glm::dvec3& direction) {
    std::size_t axis = 0;
    for (std::size_t other = 1; other < 3; ++other)
        if (std::abs(direction[static_cast<int>(other)]) > std::abs(direction[static_cast<int>(axis)]))
            axis = other;
    return 2 * axis + (direction[static_cast<int>(axis)] < 0 ? 1 : 0);
}
} // namespace

std::size_t ShadowMaps::viewOf(std::size_t first, const glm::dvec3& place) const {
    return perLight_ > 1 ? first + sideOf(place - views_[first].camera.position) : first;
}

glm::vec3 ShadowMaps::scattered(const glm::dvec3& place) const {
    TESSERA_CHECK(!lightMaps_.empty());
    glm::vec3 sum(0);
    for (std::size_t first = 0; first < views_.size(); first += static_cast<std::size_t>(perLight_)) {
        const std::size_t n = viewOf(first, place);
        glm::vec2 at(0.5f * static_cast<float>(size_));
        float mm = 0;
        // Behind the light there is none; at one inside that of the first shell.
        if (placeOn(views_[n], place, at, mm) || (perLight_ > 1 && place == views_[n].camera.position))
            sum += lightMaps_[n]->at(
                at * (static_cast<float>(lightMaps_[n]->grid().size) / static_cast<float>(size_)), mm);
    }
    return sum / static_cast<float>(maps_.size() / static_cast<std::size_t>(perLight_));
}

float ShadowMaps::light(const glm::dvec3& place, int level) const {
    const glm::dvec3 towards = isPoint_ ? light_ - place : light_;
    const double far = glm::length(towards);
    const double offsetMm = std::max(std::ldexp(offsetMm_, level), rayMm_);
    const bool isFar = !isPoint_ || far > offsetMm; // directions are unit vectors, at any offset
    const glm::dvec3 from = isFar ? place + towards * (offsetMm / far) : place;
    const std::size_t lights = maps_.size() / static_cast<std::size_t>(perLight_);
    float sum = 0;
    for (std::size_t first = 0; first < views_.size(); first += static_cast<std::size_t>(perLight_)) {
        const std::size_t n = viewOf(first, from);
        glm::vec2 at(0);
        float mm = 0;
        if (!placeOn(views_[n], from, at, mm)) { // behind the light, or at one inside
            sum += 1;
            continue;
        }
        if (perLight_ > 1) // what is beyond a side's outermost rays is another's
            at = glm::clamp(at, 0.5f, static_cast<float>(size_) - 0.5f);
        sum += maps_[n]->between(at, mm);
    }
    return std::min(1.0f, sum / static_cast<float>(lights));
}

void ShadowMaps::light(const glm::dvec3& place, const glm::dvec3& step, int level,
                       const native::PacketTarget& target, float* out) const {
    constexpr int kRun = native::kOcclusionRun;
    if (isPoint_ || !maps_.front()->numbers()) {
        for (int n = 0; n < kRun; ++n)
            out[n] = light(place + double(n) * step, level);
        return;
    }
    std::fill_n(out, kRun, 0.0f);
    const glm::dvec3 offset = light_ * (std::max(std::ldexp(offsetMm_, level), rayMm_) / glm::length(light_));
    native::ShadowLook look;
    const auto set = [](double(&to)[3], const glm::dvec3& from) {
        for (int axis = 0; axis < 3; ++axis)
            to[axis] = from[axis];
    };
    set(look.place, place), set(look.step, step), set(look.offset, offset);
    static_assert(native::kNumbersOfRay == 2 * DeepShadowMap::kLayers);
    for (std::size_t n = 0; n < views_.size(); ++n) {
        look.rays = maps_[n]->numbers();
        look.size = size_;
        set(look.centre, views_[n].plane.centre), set(look.forward, views_[n].plane.forward);
        set(look.right, views_[n].right), set(look.up, views_[n].up);
        target.addShadows(look, out);
    }
    const auto lights = static_cast<float>(maps_.size() / static_cast<std::size_t>(perLight_));
    for (int n = 0; n < kRun; ++n)
        out[n] = std::min(1.0f, out[n] / lights);
}

} // namespace tessera
