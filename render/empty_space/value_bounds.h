// render/empty_space/value_bounds.h: bounds of the field in boxes of the volume. Rays that keep the maximum
// or the minimum leap over boxes that cannot change it (docs/sampling.md, "Modes"). A cell of 8^3 voxels has
// one bound, and so has a brick. It is in units of entries of the value table, clamped to it.
#pragma once

#include "bricking/levels/selection.h"
#include "bricking/statistics/statistics.h"
#include "core/base/budget.h"
#include "core/scene/mode.h" // Reduction
#include "render/contract/optics.h"
#include "render/contract/strides.h"
#include "render/empty_space/occupancy.h" // EmptyBox, leaves

#include <optional>
#include <vector>

namespace tessera {

class ValueBounds {
  public:
    ValueBounds() = default;
    /// @param optics  of values: its reduction is maximum or minimum
    /// @param slack  relative to a box's range, by which filtered fetches may exceed it
    void fill(const Statistics& statistics, const Optics& optics, const VolumeInfo& info,
              const Selection& selection, MapScale scale, double slack, MemoryBudget& ram, int threads = 0);
    void clear() {
        const std::uint64_t version = version_;
        *this = {};
        version_ = version;
    }

    bool exists() const { return !brick_.empty(); }
    const glm::ivec3& cells() const { return cells_; } // 0 if only bricks have bounds
    const glm::ivec3& bricks() const { return bricks_; }
    const glm::ivec3& extentVoxels() const { return extentVoxels_; }
    /// [z][y][x]. No sample is above (maximum) or below (minimum).
    const std::vector<float>& cell() const { return cell_; }
    const std::vector<float>& brick() const { return brick_; }
    bool least() const { return least_; } // for minimum
    /// Incremented with every update.
    std::uint64_t version() const { return version_; }

    static std::size_t bytes(const glm::ivec3& extentVoxels, MapScale scale);

  private:
    glm::ivec3 cells_{0}, bricks_{0}, extentVoxels_{0};
    std::vector<float> cell_, brick_;
    bool least_ = false;
    std::uint64_t version_ = 0;
    Charge charge_;
};

/// The box around a point in which no sample can change a ray's value; none if one can.
/// @param most  the greatest value so far (the least), in units of entries
template <typename Real>
std::optional<EmptyBox> boundedBoxAt(const ValueBounds& b, const glm::vec<3, Real>& p, Real most) {
    const glm::ivec3 voxel = glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), b.extentVoxels() - 1);
    const auto tells = [&](float bound) {
        return b.least() ? static_cast<Real>(bound) < most : static_cast<Real>(bound) > most;
    };
    const auto boxOf = [&](int shift) {
        const glm::ivec3 box = voxel >> shift;
        return EmptyBox{box * (1 << shift), (box + 1) * (1 << shift)};
    };
    constexpr int kBrickShift = 5, kCellShift = 3;
    if (!tells(b.brick()[linearIndex(voxel >> kBrickShift, b.bricks())]))
        return boxOf(kBrickShift);
    if (!b.cell().empty() && !tells(b.cell()[linearIndex(voxel >> kCellShift, b.cells())]))
        return boxOf(kCellShift);
    return std::nullopt;
}

/// As nextOccupied(). Returns i if the stride of n segments from i, with middle p, can change the ray's
/// value. Otherwise it returns the start of the first stride whose middle may lie beyond the box that cannot.
template <typename Real>
int nextContributing(const ValueBounds& b, const Strides& strides, const SegmentedRay<Real>& ray, int i,
                     int n, const glm::vec<3, Real>& p, Real most) {
    const std::optional<EmptyBox> box = boundedBoxAt(b, p, most);
    if (!box)
        return i;
    const Real beyond = std::ceil(leaves(ray, *box) - Real(0.5));
    if (!(beyond < static_cast<Real>(ray.count)))
        return ray.count;
    return std::max(i + n, strideStart(strides, ray, std::max(static_cast<int>(beyond), 0)));
}

} // namespace tessera
