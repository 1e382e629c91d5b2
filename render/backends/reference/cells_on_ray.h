// render/backends/reference/cells_on_ray.h: the cells of the field along a ray, its empty cells, and the
// field in one cell.
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "render/backends/reference/reference.h" // ReferenceRay
#include "render/contract/lattice.h"
#include "render/contract/leaves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

namespace tessera {

/// Calls visit(ta, tb) for each interval of [t0,t1] between crossings of the planes offset + k * spacing.
template <typename Visit>
void forEachInterval(const ReferenceRay& ray, double t0, double t1, double spacing, double offset,
                     const Visit& visit) {
    std::array<double, 3> plane{}, advance{}, next{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double d = ray.direction[axis];
        next[a] = std::numeric_limits<double>::infinity();
        if (d == 0)
            continue;
        const double at = (ray.base[axis] + t0 * d - offset) / spacing;
        plane[a] = d > 0 ? std::floor(at) + 1 : std::ceil(at) - 1;
        advance[a] = d > 0 ? 1 : -1;
        next[a] = (offset + plane[a] * spacing - ray.base[axis]) / d;
    }
    for (double t = t0; t < t1;) {
        const std::size_t a =
            static_cast<std::size_t>(std::min_element(next.begin(), next.end()) - next.begin());
        const double end = std::min(next[a], t1);
        if (end > t) {
            visit(t, end);
            t = end;
        }
        if (!(next[a] < t1))
            break;
        plane[a] += advance[a];
        next[a] = (offset + plane[a] * spacing - ray.base[static_cast<int>(a)]) /
                  ray.direction[static_cast<int>(a)];
    }
}

/// Invisible cells of 8^3 voxels, by their ranges; none if the input has no ranges.
class EmptyCells {
  public:
    EmptyCells() = default; // none
    /// @param function  emptyOver(lowest, highest): stored values between these are invisible
    template <typename Function> EmptyCells(const ReferenceInput& input, const Function& function) {
        if (const Statistics* s = input.statistics) {
            grid_ = cellGrid(input.info->extentVoxels);
            empty_.resize(s->cellMin.size());
            for (std::size_t i = 0; i < empty_.size(); ++i)
                empty_[i] = function.emptyOver(static_cast<double>(s->cellMin[i]),
                                               static_cast<double>(s->cellMax[i]));
        }
    }
    /// True if [ta,tb] of a ray, which crosses no border of such cells, is in one of them.
    bool hold(const ReferenceRay& ray, double ta, double tb) const {
        if (empty_.empty())
            return false;
        const glm::dvec3 middle = ray.base + 0.5 * (ta + tb) * ray.direction;
        const glm::ivec3 cell =
            glm::clamp(glm::ivec3(glm::floor(middle)) / kCellExtent, glm::ivec3(0), grid_ - 1);
        return empty_[linearIndex(cell, grid_)];
    }

  private:
    std::vector<bool> empty_;
    glm::ivec3 grid_{0};
};

/// The eight samples of a cell of the field. Beyond the outermost sample centres both samples of an axis are
/// the same one.
class Cell {
  public:
    Cell(LatticeReader& reader, const glm::ivec3& low) : low_(low) { reader.cube<2>(low, values_.data()); }
    double lowest() const { return *std::min_element(values_.begin(), values_.end()); }
    double highest() const { return *std::max_element(values_.begin(), values_.end()); }
    /// Trilinear also slightly outside of the cell (rounding), so that the cubic is exact.
    double at(const glm::dvec3& p) const {
        const glm::dvec3 f = p - 0.5 - glm::dvec3(low_);
        return leaf::trilinear(values_[0], values_[1], values_[2], values_[3], values_[4], values_[5],
                               values_[6], values_[7], f.x, f.y, f.z);
    }

  private:
    glm::ivec3 low_;
    std::array<double, 8> values_;
};

} // namespace tessera
