// render/empty_space/occupancy.h: occupancy under a transfer function at the levels that bricks have, and the
// distance map that follows from it (distance_map.h). The rule of skipping is proof: a cell counts as empty
// only if extinction is 0 over the hull of every sample that a point in it can reach. These are its own
// brick's samples, clamped to that brick, and those of neighbours that have weight there (brick_corner.h).
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/empty_space/brick_proof.h"
#include "render/empty_space/distance_map.h"
#include "render/empty_space/shown_ranges.h"

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace tessera {

class Occupancy {
  public:
    Occupancy() = default;
    /// Proves every brick and fills the map.
    /// @param threads  0: all processors
    Occupancy(const OccupancyInput& input, MapScale scale, MemoryBudget& ram, int threads = 0);

    /// The function is another, and perhaps levels are: proves bricks anew that hold values which one
    /// function shows and the other does not. True where map or plain cells changed.
    bool functionChanged(const OccupancyInput& input, int threads = 0);
    /// Levels of some bricks are others, the function is the same: proves those bricks and their neighbours
    /// anew, which it finds itself. True where the map or plain cells changed. Both mend the map where it
    /// changes, and leave what a new Occupancy would hold.
    bool levelsChanged(const OccupancyInput& input, int threads = 0);

    /// Grows with every change.
    std::uint64_t version() const { return version_; }
    /// Slices of the map that a copy of an earlier version lacks, bits included that a device added
    /// to it (fine_mask.h).
    ChangedSlices changedSince(std::uint64_t version) const;

    MapScale scale() const { return scale_; }
    const glm::ivec3& extentVoxels() const { return extentVoxels_; }
    const glm::ivec3& grid() const { return grid_; }               // of the map
    const std::vector<SkippingTexel>& map() const { return map_; } // [z][y][x]
    /// Per brick, [z][y][x]: bit x + 4y + 16z of a cell that can show something.
    const std::vector<std::uint64_t>& masks() const { return masks_; }
    std::size_t occupiedCells() const;
    bool isEmpty(const glm::ivec3& cell) const;
    /// In an occupied cell: the field is plain interpolation of level 0, empty bricks reading as their mean.
    bool isPlain(const glm::ivec3& cell) const;
    std::size_t plainCells() const; // occupied ones
    /// The same with one distance for all octants, the least: a plain Chebyshev map, to compare with.
    Occupancy plainChebyshev(MemoryBudget& ram) const;
    bool exists() const { return !map_.empty(); }

    /// RAM that one takes.
    static std::size_t bytes(const glm::ivec3& extentVoxels, MapScale scale);

  private:
    bool follow(const OccupancyInput& input, bool functionChanged, int threads);
    std::vector<std::size_t> staleBricks(const OccupancyInput& input, bool functionChanged) const;
    std::vector<std::size_t> prove(const OccupancyInput& input, const std::vector<std::size_t>& bricks,
                                   int threads);

    MapScale scale_ = MapScale::cells;
    glm::ivec3 extentVoxels_{0}, grid_{0}, bricks_{0};
    std::vector<glm::vec2> wide_; // per brick: range of its voxels and of those of the bricks that touch it
    std::vector<std::uint8_t> levels_;
    std::uint32_t finest_ = 0;
    EdgeFunction edgeFunction_ = EdgeFunction::minimum;
    std::vector<std::uint64_t> masks_, plain_; // plain_: of bricks with occupied cells
    std::vector<SkippingTexel> map_;
    ShownRanges shown_;
    std::uint64_t version_ = 0;
    ChangedSlices changed_; // by the last change
    Charge charge_;
};

/// How far a leap stays inside the box it was proven for, voxels: more than positions are rounded by, so that
/// no stride is leapt over whose middle lies outside.
constexpr double kLeapMargin = 1.0 / 64;

/// A box, in voxels, that is proven empty.
struct EmptyBox {
    glm::ivec3 low, high;
    bool touches(const EmptyBox& other) const {
        return glm::all(glm::lessThanEqual(low, other.high)) && glm::all(glm::lessThanEqual(other.low, high));
    }
};

/// The empty box around a place, as far as a ray in the direction of step may leap; none where
/// something can show.
template <typename Real>
std::optional<EmptyBox> emptyBoxAt(const Occupancy& o, const glm::vec<3, Real>& step,
                                   const glm::vec<3, Real>& p) {
    const glm::ivec3 voxel = glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), o.extentVoxels() - 1);
    int shift = boxShift(o.scale());
    const SkippingTexel texel = o.map()[linearIndex(voxel >> shift, o.grid())];
    glm::ivec3 ascends(0);
    int reach = 1;
    for (int axis = 0; axis < 3; ++axis)
        ascends[axis] = step[axis] > Real(0) ? 1 : 0;
    if (isOccupied(texel)) {
        shift -= 2;
        if ((texel >> blockBit((voxel >> shift) & 3)) & 1u)
            return std::nullopt;
    } else {
        reach = octantDistance(texel, ascends.x | ascends.y << 1 | ascends.z << 2);
    }
    const glm::ivec3 box = voxel >> shift, ahead = (reach - 1) * ascends, behind = (reach - 1) - ahead;
    return EmptyBox{(box - behind) * (1 << shift), (box + 1 + ahead) * (1 << shift)};
}

/// Where a ray leaves a box, less a margin, in segments from its entry.
template <typename Real> Real leaves(const SegmentedRay<Real>& ray, const EmptyBox& box) {
    Real leave = std::numeric_limits<Real>::max();
    const Real margin = static_cast<Real>(kLeapMargin);
    for (int axis = 0; axis < 3; ++axis) {
        const Real d = ray.step[axis];
        if (d > Real(0))
            leave = std::min(leave, (static_cast<Real>(box.high[axis]) - margin - ray.entry[axis]) / d);
        if (d < Real(0))
            leave = std::min(leave, (static_cast<Real>(box.low[axis]) + margin - ray.entry[axis]) / d);
    }
    return leave;
}

/// Twin of nextOccupied() in shaders/march_skipping.glsl. Returns i itself where p, the middle of the stride
/// of n segments from i, lies where something can show. Else it returns where the first stride starts whose
/// middle may lie beyond the box that is empty. Leaps differ from the shader's by rounding; which strides are
/// taken does not.
template <typename Real>
int nextOccupied(const Occupancy& o, const Strides& strides, const SegmentedRay<Real>& ray, int i, int n,
                 const glm::vec<3, Real>& p) {
    const std::optional<EmptyBox> box = emptyBoxAt(o, ray.step, p);
    if (!box)
        return i;
    const Real beyond = std::ceil(leaves(ray, *box) - Real(0.5));
    if (!(beyond < static_cast<Real>(ray.count)))
        return ray.count;
    return std::max(i + n, strideStart(strides, ray, std::max(static_cast<int>(beyond), 0)));
}

/// The same for segments that are given by the field at their ends. Returns i itself where the stride from i
/// can show something, else where the first stride starts that can. A stride cannot where both its ends lie
/// in empty boxes that touch. Values at its ends lie in the ranges of these, which share the value at a point
/// where they touch. So nothing between the two values shows either.
template <typename Real>
int nextShown(const Occupancy& o, const Strides& strides, const SegmentedRay<Real>& ray, int i) {
    std::optional<EmptyBox> box = emptyBoxAt(o, ray.step, segmentStart(ray, i));
    while (box) {
        const Real beyond = std::floor(leaves(ray, *box));
        if (!(beyond < static_cast<Real>(ray.count)))
            return ray.count;
        i = std::max(i, strideStart(strides, ray, std::max(static_cast<int>(beyond), 0)));
        const int n = strideAt(strides, ray, i);
        const std::optional<EmptyBox> next =
            emptyBoxAt(o, ray.step, strideEnd(ray, i, strideLength(ray, i, n)));
        if (!next || !box->touches(*next))
            return i;
        i += n;
        if (i >= ray.count)
            return ray.count;
        box = next;
    }
    return i;
}

/// Whether everything between two places is proven empty: all of the smallest boxes that the box around both
/// meets. False also where these are more than two along an axis.
template <typename Real>
bool isClear(const Occupancy& o, const glm::vec<3, Real>& a, const glm::vec<3, Real>& b) {
    const glm::ivec3 last = o.extentVoxels() - 1;
    const glm::ivec3 from = glm::clamp(glm::ivec3(glm::floor(a)), glm::ivec3(0), last);
    const glm::ivec3 to = glm::clamp(glm::ivec3(glm::floor(b)), glm::ivec3(0), last);
    const int shift = boxShift(o.scale()), fine = shift - 2;
    const glm::ivec3 first = glm::min(from, to) >> fine, span = (glm::max(from, to) >> fine) - first;
    if (std::max(span.x, std::max(span.y, span.z)) > 1)
        return false;
    const int mask = span.x | span.y << 1 | span.z << 2;
    int corner = 0;
    do {
        const glm::ivec3 block = first + glm::ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        const SkippingTexel texel = o.map()[linearIndex(block >> 2, o.grid())];
        if (isOccupied(texel) && ((texel >> blockBit(block & 3)) & 1u))
            return false;
        corner = (corner - mask) & mask;
    } while (corner != 0);
    return true;
}

/// The same for rays that look for surfaces, which can lie anywhere in a stride. Returns i itself where the
/// stride from i is not proven empty all along, else where the first such stride starts.
template <typename Real>
int nextNotClear(const Occupancy& o, const Strides& strides, const SegmentedRay<Real>& ray, int i) {
    while (const std::optional<EmptyBox> box = emptyBoxAt(o, ray.step, segmentStart(ray, i))) {
        const Real beyond = std::floor(leaves(ray, *box));
        if (!(beyond < static_cast<Real>(ray.count)))
            return ray.count;
        i = std::max(i, strideStart(strides, ray, std::max(static_cast<int>(beyond), 0)));
        const int n = strideAt(strides, ray, i);
        if (!isClear(o, segmentStart(ray, i), strideEnd(ray, i, strideLength(ray, i, n))))
            return i;
        i += n;
        if (i >= ray.count)
            return ray.count;
    }
    return i;
}

} // namespace tessera
