// render/contract/ray.h: one pixel's ray and its lattice of segments, in voxel space (docs/sampling.md,
// "Ray"). By the leaves of leaf_ray.h, as in shaders/common_ray.glsl: so float here repeats the GPU.
#pragma once

#include "core/base/volume.h"
#include "core/scene/camera.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <span>

namespace tessera {

/// The space between two planes: low <= dot(normal, p) <= high, p in voxels. low == high: one plane.
template <typename Real> struct RaySlab {
    glm::vec<3, Real> normal{0};
    Real low = 0, high = 0;
};
/// Of a picture's rays: scenes with more are cut by intervals (ray_cuts.h).
constexpr int kMostSlabs = 8;
class RayCuts;

/// A part of a ray: of its line, from one parameter to the other.
struct RayPart {
    double from = 0, to = 0;
};

/// Parts of all rays between planes parallel to the picture, of one thickness each (docs/sampling.md,
/// "Sampling hulls").
struct RayHulls {
    int count = 0;   // 0: rays have segments of one length
    int samples = 1; // segments of a ray in each part
    /// Depth of a place in voxels: dot(normal, place) + offset, mm along the view.
    glm::dvec3 normal{0};
    double offset = 0, nearest = 0, farthest = 0; // of the first plane and the last
    /// Plane n, from 0 to count.
    double plane(int n) const { return nearest + (farthest - nearest) * n / count; }
};
/// From the nearest corner of the volume that is before the eye to its farthest.
RayHulls rayHulls(const Camera& camera, const VolumeInfo& info, int count, int samples);

/// All that turns a pixel into a ray, in voxel space. Computed in double once a frame; Real is the number
/// type of rays.
template <typename Real> struct RayFrame {
    using Vec = glm::vec<3, Real>;
    Vec centre{0}, right{0}, up{0}; // voxels: the plane near the volume that rays pass through
    Vec toCentre{0};                // voxels: perspective: from the eye to the centre; parallel: forward
    glm::mat<3, 3, Real> patientFromVoxel{1}; // linear part, mm per voxel
    Vec extent{0};                            // voxels
    glm::vec<2, Real> imageSize{1};
    Real segmentVoxels = 1; // q: length of a segment in voxel space
    bool phased = false;    // rays have phases by where they stand in their array (phaseOf())
    bool perspective = true;
    /// Rays are drawn inside of all of them. flat: one of them is a plane, at which a ray has one sample.
    std::array<RaySlab<Real>, kMostSlabs> slabs = {};
    int slabCount = 0;
    bool flat = false;
    /// Further cuts; null: none. Outlives the frame.
    const RayCuts* cuts = nullptr;
    /// The part of each ray of the array behind and before which nothing of the volume is drawn, for example
    /// because it meets a mesh there; voxels along its line (pixelLine()). Empty: there are none. With cuts.
    std::span<const RayPart> ends = {};
    RayHulls hulls = {}; // with cuts
    /// Of a ray in each hull; 0: there are none.
    int hullSamples() const { return hulls.count > 0 ? hulls.samples : 0; }
};

/// A ray cut into segments, from its entry into the drawn part of the volume. Segment i spans [entry +
/// i*step, entry + (i+1)*step], the last one only its part `tail`. Voxel space; segmentMm is the length of a
/// whole segment in patient space.
template <typename Real> struct SegmentedRay {
    using Vec = glm::vec<3, Real>;
    Vec entry{0}, step{0};
    Vec direction{0}; // unit
    Real segmentMm = 0;
    Real tail = 1; // (0,1]; 0 of a plane's one sample, which has no length
    int count = 0; // 0: misses the drawn part
};

inline RayFrame<double> rayFrame(const Camera& camera, const VolumeInfo& info, const glm::ivec2& imageSize,
                                 double segmentVoxels) {
    const RayPlane plane = rayPlane(camera, info, imageSize);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    const glm::dmat3 linear(voxelFromPatient);
    RayFrame<double> frame;
    frame.centre = glm::dvec3(voxelFromPatient * glm::dvec4(plane.centre, 1));
    frame.right = linear * plane.right;
    frame.up = linear * plane.up;
    frame.toCentre = linear * (plane.perspective ? plane.toCentre : plane.forward);
    frame.patientFromVoxel = glm::dmat3(info.patientFromVoxel);
    frame.extent = glm::dvec3(info.extentVoxels);
    frame.imageSize = glm::dvec2(imageSize);
    frame.segmentVoxels = segmentVoxels;
    frame.perspective = plane.perspective;
    return frame;
}

template <typename Real> RayFrame<Real> cast(const RayFrame<double>& f) {
    RayFrame<Real> out;
    out.centre = typename RayFrame<Real>::Vec(f.centre);
    out.right = typename RayFrame<Real>::Vec(f.right);
    out.up = typename RayFrame<Real>::Vec(f.up);
    out.toCentre = typename RayFrame<Real>::Vec(f.toCentre);
    out.patientFromVoxel = glm::mat<3, 3, Real>(f.patientFromVoxel);
    out.extent = typename RayFrame<Real>::Vec(f.extent);
    out.imageSize = glm::vec<2, Real>(f.imageSize);
    out.segmentVoxels = static_cast<Real>(f.segmentVoxels);
    out.phased = f.phased;
    out.perspective = f.perspective;
    for (int n = 0; n < f.slabCount; ++n) {
        const RaySlab<double>& slab = f.slabs[static_cast<std::size_t>(n)];
        out.slabs[static_cast<std::size_t>(n)] = {typename RayFrame<Real>::Vec(slab.normal),
                                                  static_cast<Real>(slab.low), static_cast<Real>(slab.high)};
    }
    out.slabCount = f.slabCount;
    out.flat = f.flat;
    out.cuts = f.cuts;
    out.ends = f.ends;
    out.hulls = f.hulls;
    return out;
}

/// Unit direction in voxel space and its length in mm.
template <typename Real> struct RayLine {
    glm::vec<3, Real> base{0}, direction{0}; // voxels
    Real nearest = 0;                        // smallest parameter (voxels along direction)
    Real mmPerVoxel = 0;
};

template <typename Real> RayLine<Real> pixelLine(const RayFrame<Real>& f, const glm::vec<2, Real>& pixel) {
    RayLine<Real> line;
    Real distance(0);
    leaf::lineThrough(pixel.x, pixel.y, f.imageSize.x, f.imageSize.y, f.centre, f.right, f.up, f.toCentre,
                      f.perspective, line.base, line.direction, distance);
    line.nearest = f.perspective ? -distance : -std::numeric_limits<Real>::max();
    line.mmPerVoxel = leaf::length3(leaf::transformed(f.patientFromVoxel, line.direction));
    return line;
}

/// Intersects the closed box [0,extent]: a ray that lies in a face meets it.
template <typename Real>
bool clipToBox(const RayLine<Real>& line, const glm::vec<3, Real>& extent, Real& t0, Real& t1) {
    t0 = line.nearest;
    t1 = std::numeric_limits<Real>::max();
    for (int axis = 0; axis < 3; ++axis)
        if (leaf::clip(line.base[axis], line.direction[axis], Real(0), extent[axis], t0, t1))
            return false;
    return t1 > t0;
}

/// The part of [t0, t1] inside of a slab; as clipToBox() along an axis. False where there is none; a ray that
/// runs along a plane meets it nowhere.
template <typename Real>
bool clipToSlab(const RayLine<Real>& line, const RaySlab<Real>& s, Real& t0, Real& t1) {
    return !leaf::clip(leaf::dot3(s.normal, line.base), leaf::dot3(s.normal, line.direction), s.low, s.high,
                       t0, t1) &&
           !(t1 < t0);
}

/// The part inside of the volume's box and of all slabs.
template <typename Real>
bool drawnPartOf(const RayFrame<Real>& f, const RayLine<Real>& line, Real& t0, Real& t1) {
    if (!clipToBox(line, f.extent, t0, t1))
        return false;
    for (int n = 0; n < f.slabCount; ++n)
        if (!clipToSlab(line, f.slabs[static_cast<std::size_t>(n)], t0, t1))
            return false;
    return t1 > t0 || (f.flat && t1 == t0);
}

/// Rays of a pixel that are drawn side by side, eight of them, take samples between one another's, by phases.
constexpr int kPhases = 8;
template <typename Real> Real phaseOf(int column, int row) {
    return static_cast<Real>(leaf::phaseOf(column, row));
}

/// Of the frame's box and slabs; its cuts are taken by partOf() (ray_cuts.h).
/// @param phase  of phaseOf(), or 0
template <typename Real>
SegmentedRay<Real> segmentedRay(const RayFrame<Real>& f, const glm::vec<2, Real>& pixel, Real phase = 0) {
    const RayLine<Real> line = pixelLine(f, pixel);
    SegmentedRay<Real> ray;
    Real t0 = 0, t1 = 0;
    if (!drawnPartOf(f, line, t0, t1))
        return ray;
    const Real first = t0 + phase * f.segmentVoxels;
    const Real segments = (t1 - first) / f.segmentVoxels;
    if (!(segments < Real(1 << 24)))
        return ray; // NaN, or more than float can count: draws nothing
    ray.count = f.flat ? 1 : static_cast<int>(std::ceil(segments));
    ray.tail = segments - static_cast<Real>(ray.count - 1);
    ray.entry = leaf::placeAlong(line.base, line.direction, first);
    ray.step = f.segmentVoxels * line.direction;
    ray.direction = line.direction;
    ray.segmentMm = f.segmentVoxels * line.mmPerVoxel;
    return ray;
}

/// Segments in the stride of n that starts at segment i: n, or the remainder before the exit.
template <typename Real> Real strideLength(const SegmentedRay<Real>& ray, int i, int n) {
    return i + n >= ray.count ? static_cast<Real>(ray.count - 1 - i) + ray.tail : static_cast<Real>(n);
}
/// The middle of a stride, voxels.
template <typename Real> glm::vec<3, Real> stridePosition(const SegmentedRay<Real>& ray, int i, Real length) {
    return leaf::placeAlong(ray.entry, ray.step, leaf::strideMiddle(static_cast<Real>(i), length));
}
/// The end of a stride, voxels; the start of the next.
template <typename Real> glm::vec<3, Real> strideEnd(const SegmentedRay<Real>& ray, int i, Real length) {
    return leaf::placeAlong(ray.entry, ray.step, static_cast<Real>(i) + length);
}
/// The start of segment i, voxels.
template <typename Real> glm::vec<3, Real> segmentStart(const SegmentedRay<Real>& ray, int i) {
    return leaf::placeAlong(ray.entry, ray.step, static_cast<Real>(i));
}

} // namespace tessera
