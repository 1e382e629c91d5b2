// render/occupancy.h: which cells can show anything under a transfer function, and how far the next such cell
// is (Chebyshev distance in cells), for empty-space skipping. The rule of skipping is proof: a cell counts as
// empty only if extinction is 0 over the hull of every sample that a point in it can reach at the levels that
// the bricks around it have.
#pragma once

#include "bricking/selection.h"
#include "bricking/statistics.h"
#include "core/brick.h"
#include "core/budget.h"
#include "core/transfer_function.h"
#include "render/ray.h"
#include "render/strides.h"

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <vector>

namespace tessera {

struct Occupancy {
    glm::ivec3 cells{0};
    std::vector<std::uint8_t>
        distance; // [z][y][x]: 0 occupied, else distance to the nearest occupied, <= 255
    std::size_t occupiedCells = 0;
    Charge charge;
};

Occupancy makeOccupancy(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
                        const Selection& selection, Ledger& ram);

/// Twin of nextOccupied() in shaders/march_skipping.glsl: i itself where p, the middle of the stride of n
/// segments from i, lies in an occupied cell; else where the first stride starts whose middle may lie beyond
/// the box of cells that is empty.
template <typename Real>
int nextOccupied(const Occupancy& o, const Strides& strides, const SegmentedRay<Real>& ray, int i, int n,
                 const glm::vec<3, Real>& p) {
    const glm::ivec3 cell = glm::clamp(glm::ivec3(glm::floor(p)) >> 3, glm::ivec3(0), o.cells - 1);
    const int reach = o.distance[linearIndex(cell, o.cells)];
    if (reach == 0)
        return i;
    Real leave = std::numeric_limits<Real>::max(); // in segments from the entry
    for (int axis = 0; axis < 3; ++axis) {
        const Real d = ray.step[axis];
        const Real low = static_cast<Real>((cell[axis] - (reach - 1)) * kCellExtent);
        const Real high = static_cast<Real>((cell[axis] + reach) * kCellExtent);
        if (d > Real(0))
            leave = std::min(leave, (high - ray.entry[axis]) / d);
        if (d < Real(0))
            leave = std::min(leave, (low - ray.entry[axis]) / d);
    }
    const int beyond = static_cast<int>(std::min(std::ceil(leave - Real(0.5)), static_cast<Real>(ray.count)));
    if (beyond >= ray.count)
        return ray.count;
    return std::max(i + n, strideStart(strides, ray, beyond));
}

} // namespace tessera
