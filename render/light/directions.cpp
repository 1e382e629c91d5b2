// render/light/directions.cpp: see directions.h.
#include "render/light/directions.h"

#include "core/base/brick.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <numbers>

namespace tessera {
namespace {

using Face = std::array<glm::dvec3, 3>;

std::vector<Face> tetrahedron() {
    const glm::dvec3 a(1, 1, 1), b(1, -1, -1), c(-1, 1, -1), d(-1, -1, 1);
    return {{a, b, c}, {a, b, d}, {a, c, d}, {b, c, d}};
}

std::vector<Face> octahedron() {
    std::vector<Face> faces;
    for (int n = 0; n < 8; ++n)
        faces.push_back({glm::dvec3((n & 1) != 0 ? -1 : 1, 0, 0), glm::dvec3(0, (n & 2) != 0 ? -1 : 1, 0),
                         glm::dvec3(0, 0, (n & 4) != 0 ? -1 : 1)});
    return faces;
}

/// The corners of an icosahedron are those of three golden rectangles; three mutually nearest corners are a
/// face.
std::vector<Face> icosahedron() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    std::vector<glm::dvec3> corners;
    for (const double s : {-1.0, 1.0})
        for (const double t : {-g, g}) {
            corners.emplace_back(0, s, t);
            corners.emplace_back(s, t, 0);
            corners.emplace_back(t, 0, s);
        }
    const auto areNear = [&](std::size_t i, std::size_t j) {
        return glm::distance(corners[i], corners[j]) < 2.1; // edges are 2 long
    };
    std::vector<Face> faces;
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t j = i + 1; j < corners.size(); ++j)
            for (std::size_t k = j + 1; k < corners.size(); ++k)
                if (areNear(i, j) && areNear(j, k) && areNear(i, k))
                    faces.push_back({corners[i], corners[j], corners[k]});
    return faces;
}

/// The solid angle of a triangle, as a share of the sphere.
/// @param f  unit vectors
/// Source: Van Oosterom, Strackee, The solid angle of a plane triangle, 1983, equation 8.
double partOfSphere(const Face& f) {
    const double volume = std::abs(glm::dot(f[0], glm::cross(f[1], f[2])));
    const double around = 1 + glm::dot(f[0], f[1]) + glm::dot(f[1], f[2]) + glm::dot(f[2], f[0]);
    return 2 * std::atan2(volume, around) / (4 * std::numbers::pi);
}

/// Faces of the solid that has 4^n times as few; n.
int halvings(int count, int faces) {
    int n = 0;
    for (; count > faces && count % 4 == 0; count /= 4)
        ++n;
    return count == faces ? n : -1;
}

} // namespace

bool isDirectionCount(int count) {
    return halvings(count, 4) >= 0 || halvings(count, 8) >= 0 || halvings(count, 20) >= 0;
}

std::vector<SphereDirection> sphereDirections(int count) {
    TESSERA_CHECK(isDirectionCount(count));
    std::vector<Face> faces = halvings(count, 4) >= 0   ? tetrahedron()
                              : halvings(count, 8) >= 0 ? octahedron()
                                                        : icosahedron();
    while (faces.size() < static_cast<std::size_t>(count)) {
        std::vector<Face> finer;
        for (const Face& f : faces) {
            const glm::dvec3 a = glm::normalize(f[0]), b = glm::normalize(f[1]), c = glm::normalize(f[2]);
            const glm::dvec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c),
                             ca = glm::normalize(c + a);
            for (const Face& quarter : {Face{a, ab, ca}, Face{ab, b, bc}, Face{ca, bc, c}, Face{ab, bc, ca}})
                finer.push_back(quarter);
        }
        faces = std::move(finer);
    }
    std::vector<SphereDirection> directions;
    for (const Face& f : faces) {
        const Face unit{glm::normalize(f[0]), glm::normalize(f[1]), glm::normalize(f[2])};
        directions.push_back({glm::normalize(unit[0] + unit[1] + unit[2]), partOfSphere(unit)});
    }
    return directions;
}

std::vector<SphereDirection> occlusionDirections(const Occlusion& occlusion) {
    std::vector<SphereDirection> directions = sphereDirections(occlusion.rays);
    if (!occlusion.weights)
        return directions;
    double sum = 0;
    for (SphereDirection& direction : directions)
        sum += direction.part *= directionWeight(occlusion, direction.towards);
    for (SphereDirection& direction : directions)
        direction.part /= sum;
    return directions;
}

SurfaceAround surfaceAround(const glm::vec3& rise, float mean, const glm::mat3& toPatient) {
    const float length = glm::length(rise);
    const glm::vec3 out = -(toPatient * rise);
    const float steep = glm::length(out);
    if (!(length > 0 && mean > 0 && steep > 0))
        return {};
    return {out / steep, std::min(1.0f, length / mean)};
}

namespace {

/// A step along the steepest axis of a direction, samples of level 0.
OcclusionRay rayAlong(const SphereDirection& direction, const glm::dmat3& voxelFromPatient) {
    OcclusionRay ray;
    ray.direction = direction.towards;
    ray.part = direction.part;
    const glm::dvec3 voxelsPerMm = voxelFromPatient * direction.towards;
    for (int axis = 1; axis < 3; ++axis)
        if (std::abs(voxelsPerMm[axis]) > std::abs(voxelsPerMm[ray.axis]) * (1 + 1e-9))
            ray.axis = axis;
    const double steepest = std::abs(voxelsPerMm[ray.axis]);
    ray.step = voxelsPerMm / steepest;
    ray.step[ray.axis] = std::copysign(1.0, ray.step[ray.axis]);
    ray.stepMm = 1 / steepest;
    return ray;
}

int stepsWithin(double mm, double stepMm) {
    return static_cast<int>(std::lround(std::clamp(mm / stepMm, 0.0, 1e6)));
}

} // namespace

int occlusionLevel(const Occlusion& occlusion, const VolumeInfo& info) {
    const glm::dmat3 voxelFromPatient = glm::inverse(glm::dmat3(info.patientFromVoxel));
    double shortest = 0;
    for (const SphereDirection& direction : sphereDirections(occlusion.rays)) {
        const double step = rayAlong(direction, voxelFromPatient).stepMm;
        shortest = shortest > 0 ? std::min(shortest, step) : step;
    }
    int level = 0;
    while (level + 1 < kLevelCount &&
           stepsWithin(occlusion.radiusMm, std::ldexp(shortest, level)) > kMostOcclusionSteps)
        ++level;
    return level;
}

OcclusionRays occlusionRays(const Occlusion& occlusion, const VolumeInfo& info, int level) {
    const glm::dmat3 voxelFromPatient = glm::inverse(glm::dmat3(info.patientFromVoxel));
    OcclusionRays all;
    for (const SphereDirection& direction : occlusionDirections(occlusion)) {
        OcclusionRay ray = rayAlong(direction, voxelFromPatient);
        ray.stepMm = std::ldexp(ray.stepMm, level);
        const int whole = std::clamp(stepsWithin(occlusion.radiusMm, ray.stepMm), 1, kMostOcclusionSteps);
        ray.skipped = std::min(stepsWithin(occlusion.offsetMm, ray.stepMm), whole - 1);
        ray.steps = whole - ray.skipped;
        all.reach = glm::max(all.reach, glm::ivec3(glm::ceil(glm::abs(ray.step) * double(whole))) + 1);
        all.rays.push_back(ray);
    }
    std::stable_sort(all.rays.begin(), all.rays.end(),
                     [](const OcclusionRay& a, const OcclusionRay& b) { return a.stepMm < b.stepMm; });
    return all;
}

} // namespace tessera
