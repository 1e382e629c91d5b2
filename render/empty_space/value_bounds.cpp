// render/empty_space/value_bounds.cpp: see value_bounds.h.
#include "render/empty_space/value_bounds.h"

#include "core/base/error.h"
#include "core/base/threads.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tessera {
namespace {

/// A range of stored values.
struct Range {
    float low = std::numeric_limits<float>::infinity(), high = -std::numeric_limits<float>::infinity();
    void add(float a, float b) {
        low = std::min(low, a);
        high = std::max(high, b);
    }
};

/// Bounds of neighbouring bricks.
struct Surroundings {
    int coarsest = 0; // of non-empty ones, itself included
    Range means;      // of the empty ones
    Range voxels;     // of all of them
};

/// Levels whose samples and their reach lie within the cells around a point's cell.
constexpr int kWithinCells = 2;

} // namespace

std::size_t ValueBounds::bytes(const glm::ivec3& extentVoxels, MapScale scale) {
    const std::size_t cells = scale == MapScale::cells ? cellCount(cellGrid(extentVoxels)) : 0;
    return sizeof(float) * (cells + cellCount(brickGrid(extentVoxels)));
}

void ValueBounds::fill(const Statistics& s, const Optics& optics, const VolumeInfo& info,
                       const Selection& selection, MapScale scale, double slack, MemoryBudget& ram,
                       int threads) {
    TESSERA_CHECK(optics.reduction == Reduction::maximum || optics.reduction == Reduction::minimum);
    const std::size_t bytes = ValueBounds::bytes(info.extentVoxels, scale);
    if (charge_.bytes() != bytes) {
        charge_ = {};
        charge_ = ram.charge(bytes, "the value bounds");
    }
    least_ = optics.reduction == Reduction::minimum;
    extentVoxels_ = info.extentVoxels;
    bricks_ = s.bricks;
    cells_ = scale == MapScale::cells ? s.cells : glm::ivec3(0);
    brick_.resize(cellCount(bricks_));
    cell_.resize(cellCount(cells_));
    ++version_;
    const float last = static_cast<float>(optics.table.size() - 1);
    // Interpolation in float goes beyond its samples by a few units in the last place.
    const auto bound = [&](const Range& range) {
        const double rounding =
            1e-6 * std::max(std::abs(double{range.low}), std::abs(double{range.high})) + 1e-30;
        const double more = rounding + slack * (double{range.high} - double{range.low});
        const float a = placeOf(optics, static_cast<float>(double{range.low} - more));
        const float b = placeOf(optics, static_cast<float>(double{range.high} + more));
        return std::clamp(least_ ? std::min(a, b) : std::max(a, b), 0.0f, last);
    };
    const auto around = [&](const glm::ivec3& brick) {
        Surroundings out;
        const glm::ivec3 from = glm::max(brick - 1, glm::ivec3(0)), to = glm::min(brick + 1, bricks_ - 1);
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) {
                    const std::size_t n = linearIndex({x, y, z}, bricks_);
                    const int level = selection.levels[n];
                    out.voxels.add(s.brickMin[n], s.brickMax[n]);
                    if (level == Selection::kEmpty)
                        out.means.add(selection.means[n], selection.means[n]);
                    else
                        out.coarsest = std::max(out.coarsest, level);
                }
        return out;
    };
    const auto cellsOf = [&](const glm::ivec3& brick, const Surroundings& near) {
        const glm::ivec3 first = 4 * brick, end = glm::min(first + 4, cells_);
        const int reach = near.coarsest == 0 ? 0 : 1;
        const bool wide = near.coarsest > kWithinCells;
        const float all = wide ? bound(near.voxels) : 0;
        for (int z = first.z; z < end.z; ++z)
            for (int y = first.y; y < end.y; ++y)
                for (int x = first.x; x < end.x; ++x) {
                    const glm::ivec3 at(x, y, z);
                    if (wide) {
                        cell_[linearIndex(at, cells_)] = all;
                        continue;
                    }
                    Range range = near.means;
                    const glm::ivec3 low = glm::max(at - reach, glm::ivec3(0));
                    const glm::ivec3 high = glm::min(at + reach, cells_ - 1);
                    for (int k = low.z; k <= high.z; ++k)
                        for (int j = low.y; j <= high.y; ++j)
                            for (int i = low.x; i <= high.x; ++i) {
                                const std::size_t c = linearIndex({i, j, k}, cells_);
                                range.add(s.cellMin[c], s.cellMax[c]);
                            }
                    cell_[linearIndex(at, cells_)] = bound(range);
                }
    };
    parallelFor(static_cast<std::size_t>(bricks_.z), threads, [&](std::size_t z) {
        for (int y = 0; y < bricks_.y; ++y)
            for (int x = 0; x < bricks_.x; ++x) {
                const glm::ivec3 brick(x, y, static_cast<int>(z));
                const Surroundings near = around(brick);
                const std::size_t n = linearIndex(brick, bricks_);
                Range range = near.means;
                if (near.coarsest == 0)
                    range.add(s.brickMin[n], s.brickMax[n]);
                else
                    range = near.voxels;
                brick_[n] = bound(range);
                if (!cell_.empty())
                    cellsOf(brick, near);
            }
    });
}

} // namespace tessera
