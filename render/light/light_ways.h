// render/light/light_ways.h: rays that leave a place in the volume instead of an eye: to what occludes
// isosurfaces (surface_light.h), and to what they mirror (reflections.h).
#pragma once

#include "render/contract/ray.h"
#include "render/plan/frame_plan.h"

#include <cmath>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// A part of a ray, voxel space.
struct LightWay {
    glm::dvec3 from{0}, direction{0}; // direction: unit
    double voxels = 0;                // its length
    double mmPerVoxel = 1;            // along it
};

/// A light ray as a ray of segments of a length in voxels.
template <typename Real> SegmentedRay<Real> segmentedWay(const LightWay& way, double segmentVoxels) {
    SegmentedRay<Real> ray;
    const Real segments = static_cast<Real>(way.voxels / segmentVoxels);
    if (!(segments > Real(0) && segments < Real(1 << 24)))
        return ray;
    ray.entry = typename SegmentedRay<Real>::Vec(way.from);
    ray.direction = typename SegmentedRay<Real>::Vec(way.direction);
    ray.step = static_cast<Real>(segmentVoxels) * ray.direction;
    ray.segmentMm = static_cast<Real>(segmentVoxels * way.mmPerVoxel);
    ray.count = static_cast<int>(std::ceil(segments));
    ray.tail = segments - static_cast<Real>(ray.count - 1);
    return ray;
}

/// A part of a ray that leaves a place, and the distance of its start from there.
struct WayPart {
    LightWay way;
    double beginMm = 0;
};
/// Appends the parts that the frame's box, slabs and cuts leave, in order.
/// @param voxelsPerMm  the ray's direction, voxel space, of 1 mm
/// @param mostMm  the ray's length
void addWayParts(const RayFrame<double>& frame, const glm::dvec3& from, const glm::dvec3& voxelsPerMm,
                 double mostMm, std::vector<WayPart>& parts);

/// The way along a normal over which some coordinate changes by the distance of samples in the brick at hand;
/// voxels.
/// @param along  the normal, voxel space, any length above 0
/// @param finest  of level 0, whatever levels were chosen
glm::dvec3 pitchAlong(const FramePlan& plan, const glm::dvec3& voxel, const glm::dvec3& along, bool finest);

} // namespace tessera
