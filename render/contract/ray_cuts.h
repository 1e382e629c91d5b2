// render/contract/ray_cuts.h: the parts of a ray that cuts leave (docs/sampling.md, "Cuts"). These cuts keep
// the outside of something or follow an outline, so slabs cannot express them. They are computed in double,
// once for all engines, which get the same floats.
#pragma once

#include "core/base/volume.h"
#include "core/scene/cuts.h"
#include "render/contract/ray.h"

#include <cstddef>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

/// A part of a ray, in voxels along it from where its drawn part begins (the volume's box and all slabs).
struct RayInterval {
    float from = 0, to = 0; // to >= from; equal only at a plane's one sample
};

/// Cuts in voxel space. A ray keeps what all of them keep.
class RayCuts {
  public:
    using Part = RayPart;
    /// The inside of all slabs is kept, or all but that.
    void add(std::vector<RaySlab<double>> slabs, Keep keep) { bodies_.push_back({std::move(slabs), keep}); }
    void add(const Scissors& scissors, const VolumeInfo& info);
    bool any() const { return !bodies_.empty() || !outlines_.empty(); }

    /// Of base + t * direction, t in [t0, t1]: the kept parts, in order, apart from one another. At a plane's
    /// one sample (t0 == t1) that, or nothing.
    void parts(const glm::dvec3& base, const glm::dvec3& direction, double t0, double t1,
               std::vector<Part>& out) const;
    /// True if all cuts keep a point, or it is no further than the tolerance outside; voxels.
    bool keeps(const glm::dvec3& point, double tolerance) const;
    /// False only if a box certainly holds nothing that is kept. Voxels.
    bool mayKeep(const glm::dvec3& low, const glm::dvec3& high) const;

  private:
    struct Body {
        std::vector<RaySlab<double>> slabs;
        Keep keep;
    };
    /// The camera's picture as rows of a matrix: (x, y) = (row 0, row 1) / row 2, from 0 to 1, of a place in
    /// voxels. Row 2 is 1 of a parallel camera, depth of a perspective one.
    struct Outline {
        glm::dvec4 rows[3];
        std::vector<glm::dvec2> points;
        Keep keep;
    };
    void insideOf(const Outline& outline, const glm::dvec3& base, const glm::dvec3& direction, double t0,
                  double t1, std::vector<Part>& out) const;

    std::vector<Body> bodies_;
    std::vector<Outline> outlines_;
};

/// The intervals of an array of rays, one list after another.
struct CutRays {
    std::vector<std::size_t> first; // of ray n, in all; one more than rays
    std::vector<RayInterval> all;
    std::size_t most = 0; // of a ray

    std::size_t count(std::size_t ray) const { return first[ray + 1] - first[ray]; }
    const RayInterval& at(std::size_t ray, std::size_t number) const { return all[first[ray] + number]; }
    std::size_t bytes() const {
        return first.size() * sizeof(std::size_t) + all.size() * sizeof(RayInterval);
    }
};
/// Of rays through the middles of a frame's pixels or, where there are any, through places, between their
/// ends; in hulls, where the frame has some. The frame has cuts.
/// @param threads  0: all processors
CutRays cutRays(const RayFrame<double>& frame, std::span<const glm::vec2> places, int threads);

/// An interval of a ray as a ray of its own: its lattice begins where the interval does.
/// @param samples  segments of the interval, of equal length; 0: as many as the ray's own need
template <typename Real>
SegmentedRay<Real> partOf(const SegmentedRay<Real>& ray, const RayInterval& interval, Real segmentVoxels,
                          int samples) {
    SegmentedRay<Real> part = ray;
    if (ray.count == 0)
        return part;
    const Real from = static_cast<Real>(interval.from);
    const Real segments = (static_cast<Real>(interval.to) - from) / segmentVoxels;
    part.entry = leaf::placeAlong(ray.entry, ray.direction, from);
    if (samples > 0) {
        const Real longer = segments / static_cast<Real>(samples);
        part.step = longer * ray.step;
        part.segmentMm = longer * ray.segmentMm;
        part.count = samples;
        part.tail = 1;
        return part;
    }
    part.count = std::max(static_cast<int>(std::ceil(segments)), 1);
    part.tail = segments - static_cast<Real>(part.count - 1);
    return part;
}

} // namespace tessera
