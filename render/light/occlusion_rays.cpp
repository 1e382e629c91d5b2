// render/light/occlusion_rays.cpp: see occlusion_rays.h.
#include "render/light/occlusion_rays.h"

#include "core/base/brick.h"
#include "render/light/directions.h"

#include <algorithm>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace tessera {
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
    for (const SphereDirection& direction : sphereDirections(occlusion.rays)) {
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
