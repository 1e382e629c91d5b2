// render/light/surface_tracer.h: SurfaceTracer: rays of light among isosurfaces, and the light that these
// take. An engine traces them (RayCaster::surfaceTracer()), or the mirror does. All find the same points.
#pragma once

#include "render/contract/ray.h"

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

/// A part of a ray, voxel space.
struct LightWay {
    glm::dvec3 from{0}, direction{0}; // direction: unit
    double voxels = 0;                // its length
    double mmPerVoxel = 1;            // along it
};

/// The light that isosurfaces take along a ray.
struct LightTaken {
    float taken = 0; // total, of 1
    float mm = 0;    // sum over surfaces of their part times its distance along the ray
};

class SurfaceTracer {
  public:
    virtual ~SurfaceTracer() = default;
    /// One per ray, in order. Thread-safe.
    /// @param taken  as many as rays
    virtual void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const = 0;
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

} // namespace tessera
