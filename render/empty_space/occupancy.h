// render/empty_space/occupancy.h: occupancy under a transfer function at the bricks' levels, and its distance
// map (distance_map.h). Skipping is conservative: a cell is empty only if extinction is 0 over the range of
// every sample that a point in it can reach. These are its own brick's samples, clamped to that brick, and
// those of neighbours with weight there (level_map.h).
#pragma once

#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/scene/transfer_function.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/empty_space/brick_proof.h"
#include "render/empty_space/distance_map.h"

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace tessera {

// The visible values of a transfer function, and the values in which two functions can differ. After an edit
// only cells with such values need a new test.

/// Physical units, both ends included; ends may be infinite.
struct ValueRange {
    double lowest = 0, highest = 0;
    bool meets(const ValueRange& other) const { return lowest <= other.highest && other.lowest <= highest; }
};

class ShownRanges {
  public:
    ShownRanges() = default;
    explicit ShownRanges(const TransferTable& table);

    /// Ranges of values such that TransferTable::emptyOver() is equal for both tables on every range that
    /// meets none of them.
    std::vector<ValueRange> differences(const ShownRanges& other) const;

  private:
    bool shows(double value) const;
    std::vector<double> ends() const; // of shown_, finite ones

    double firstValue_ = 0, entriesPerValue_ = 1;
    std::size_t entries_ = 0;
    std::vector<ValueRange> shown_; // ascending, half an entry beyond the outermost entries that are not 0
    bool tooMany_ = false;          // more ranges: then everything counts as different
};

class Occupancy {
  public:
    Occupancy() = default;
    /// Tests every brick and computes the map.
    /// @param threads  0: all processors
    Occupancy(const OccupancyInput& input, MapScale scale, MemoryBudget& ram, int threads = 0);

    /// For a new function, and perhaps new levels: tests bricks again that hold values visible under only one
    /// of the functions. True if map or plain cells changed.
    bool functionChanged(const OccupancyInput& input, int threads = 0);
    /// For new levels of some bricks and the same function: finds and tests those bricks and their
    /// neighbours. True if the map or plain cells changed. Both functions update the map; the result equals
    /// that of a new Occupancy.
    bool levelsChanged(const OccupancyInput& input, int threads = 0);

    /// Incremented with every change.
    std::uint64_t version() const { return version_; }
    /// Slices of the map that are new for a copy of an earlier version, including bits that a device added
    /// (skipping_binding.h).
    ChangedSlices changedSince(std::uint64_t version) const;

    MapScale scale() const { return scale_; }
    const glm::ivec3& extentVoxels() const { return extentVoxels_; }
    const glm::ivec3& grid() const { return grid_; }               // of the map
    const std::vector<SkippingTexel>& map() const { return map_; } // [z][y][x]
    /// Per brick, [z][y][x]: bit x + 4y + 16z for an occupied cell.
    const std::vector<std::uint64_t>& masks() const { return masks_; }
    std::size_t occupiedCells() const;
    bool isEmpty(const glm::ivec3& cell) const;
    /// True in an occupied cell where the field is plain interpolation of level 0, with empty bricks as their
    /// mean.
    bool isPlain(const glm::ivec3& cell) const;
    std::size_t plainCells() const; // occupied ones
    /// The same with the minimum over octants: a plain Chebyshev map, for comparisons.
    Occupancy plainChebyshev(MemoryBudget& ram) const;
    bool exists() const { return !map_.empty(); }

    /// RAM of one.
    static std::size_t bytes(const glm::ivec3& extentVoxels, MapScale scale);

  private:
    bool follow(const OccupancyInput& input, bool functionChanged, int threads);
    std::vector<std::size_t> staleBricks(const OccupancyInput& input, bool functionChanged) const;
    std::vector<std::size_t> prove(const OccupancyInput& input, const std::vector<std::size_t>& bricks,
                                   int threads);

    MapScale scale_ = MapScale::cells;
    glm::ivec3 extentVoxels_{0}, grid_{0}, bricks_{0};
    std::vector<glm::vec2> wide_; // per brick: range over it and the bricks that touch it
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

/// Margin of a leap inside its empty box, voxels: larger than rounding of positions, so that no stride with
/// its middle outside is skipped.
constexpr double kLeapMargin = 1.0 / 64;

/// An empty box, in voxels.
struct EmptyBox {
    glm::ivec3 low, high;
    bool touches(const EmptyBox& other) const {
        return glm::all(glm::lessThanEqual(low, other.high)) && glm::all(glm::lessThanEqual(other.low, high));
    }
};

/// The empty box around a point, for a ray in the direction of step; none in occupied space.
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

/// The exit of a ray from a box, less a margin, in segments from its entry.
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

/// Counterpart of nextOccupied() in shaders/march_skipping.glsl. Returns i if p, the middle of the stride of
/// n segments from i, is in occupied space. Otherwise it returns the start of the first stride whose middle
/// may lie beyond the empty box. Leaps differ from the shader's by rounding; the strides taken do not.
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

/// The same for segments by the field at their ends. Returns i if the stride from i can be visible, else the
/// start of the first stride that can. A stride is invisible if both its ends lie in touching empty boxes.
/// The values at its ends are in the ranges of these boxes, which overlap because the boxes touch. So values
/// between them are invisible too.
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

/// True if everything between two points is empty: all of the smallest boxes that their bounding box meets.
/// False also if these are more than two along an axis.
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

/// The same for surfaces, which can lie anywhere in a stride. Returns i if the stride from i is not entirely
/// empty, else the start of the first such stride.
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
