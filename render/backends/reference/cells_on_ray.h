// render/backends/reference/cells_on_ray.h: the cells of the field along a ray, its empty cells, and the
// field in one cell. The part of a ray in one cell of the field, as a cubic, and the isosurfaces that it
// crosses.
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/base/brick.h"
#include "core/scene/scene.h"                    // Isosurface
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

// A cubic: the form of fields and gradients along a ray between two planes of samples.

/// A cubic in u in [0,1] through its values at 0, 1/3, 2/3, 1.
struct Cubic {
    double c0, c1, c2, c3;
    /// From differences, so that equal values give a constant.
    Cubic(double f0, double f1, double f2, double f3) : c0(f0) {
        const double d1 = f1 - f0, d2 = f2 - f0, d3 = f3 - f0;
        c1 = 9 * d1 - 4.5 * d2 + d3;
        c2 = -22.5 * d1 + 18 * d2 - 4.5 * d3;
        c3 = 13.5 * d1 - 13.5 * d2 + 4.5 * d3;
    }
    template <typename V> V operator()(V u) const { return V(c0) + u * (V(c1) + u * (V(c2) + u * V(c3))); }

    double slope(double u) const { return c1 + u * (2 * c2 + u * (3 * c3)); }

    /// Ends of the pieces on which it is monotone, 0 and 1 included, ascending.
    std::size_t monotonePieces(std::array<double, 4>& ends) const {
        std::size_t n = 0;
        ends[n++] = 0;
        const double a = 3 * c3, b = 2 * c2, d = b * b - 4 * a * c1;
        if (d > 0 || a == 0) {
            std::array<double, 2> roots = {-1, -1};
            if (a == 0) {
                if (b != 0)
                    roots[0] = -c1 / b;
            } else {
                const double q = -0.5 * (b + std::copysign(std::sqrt(d), b));
                roots = {q / a, q != 0 ? c1 / q : -1};
            }
            std::sort(roots.begin(), roots.end());
            for (const double r : roots)
                if (r > ends[n - 1] && r < 1)
                    ends[n++] = r;
        }
        ends[n++] = 1;
        return n;
    }
};

/// Finds where monotone f crosses value between a and b; f(a) and f(b) lie on different sides. Newton steps,
/// or bisection where a step leaves the interval.
inline double crossing(const Cubic& f, double value, double a, double b) {
    constexpr double kNear = 1e-15; // convergence: the next step would be its square
    const bool rising = f(a) < value;
    double u = 0.5 * (a + b);
    for (int turn = 0; turn < 100 && b - a > kNear; ++turn) {
        const double here = f(u);
        ((here < value) == rising ? a : b) = u;
        double next = u - (here - value) / f.slope(u);
        if (!(next >= a && next <= b))
            next = 0.5 * (a + b);
        if (std::abs(next - u) <= kNear)
            return next;
        u = next;
    }
    return u;
}

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
                empty_[i] =
                    (s->showsOfCell(i) & kShowsMedium) == 0 &&
                    (s->showsOfCell(i) == 0 || function.emptyOver(static_cast<double>(s->cellMin[i]),
                                                                  static_cast<double>(s->cellMax[i])));
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

struct CellStretch {
    /// @param first, atThird, atTwoThirds, last  stored values along it
    CellStretch(double first, double atThird, double atTwoThirds, double last)
        : cubic(first, atThird, atTwoThirds, last), first(first), last(last),
          count(cubic.monotonePieces(ends)) {}

    Cubic cubic;                  // stored value, by u from 0 to 1
    double first, last;           // stored values at its ends, as read
    std::array<double, 4> ends{}; // of the pieces on which the cubic is monotone, by u
    std::size_t count;            // of ends
};

/// The consecutive stretches of a ray. The field must have one value where two meet, or a surface there would
/// be crossed twice or never.
class StretchesOfRay {
  public:
    /// Begins another ray or part: the next stretch does not continue the last.
    void begin() { lastEnd_ = std::numeric_limits<double>::quiet_NaN(); }
    /// @param position  of parameter t of the ray, voxels
    template <typename Position>
    CellStretch through(const Cell& cell, const Position& position, double ta, double tb) {
        const auto stored = [&](double t) { return cell.at(position(t)); };
        const double length = tb - ta;
        const double first = ta == lastEnd_ ? lastValue_ : stored(ta), last = stored(tb);
        lastEnd_ = tb;
        lastValue_ = last;
        return {first, stored(ta + length / 3), stored(ta + 2 * length / 3), last};
    }

  private:
    double lastEnd_ = std::numeric_limits<double>::quiet_NaN(), lastValue_ = 0;
};

/// Calls visit(u, number of the surface) for each crossing, in order along the ray, until it returns true;
/// returns whether it did. Values below the isovalue are one side of the surface, all others the other.
/// @param surfaces  by ascending value
template <typename Visit>
bool crossSurfaces(const CellStretch& stretch, const std::vector<Isosurface>& surfaces, const Visit& visit) {
    for (std::size_t i = 0; i + 1 < stretch.count; ++i) {
        const double from = stretch.ends[i], to = stretch.ends[i + 1];
        const double a = i == 0 ? stretch.first : stretch.cubic(from);
        const double b = i + 2 == stretch.count ? stretch.last : stretch.cubic(to);
        for (std::size_t n = 0; n < surfaces.size(); ++n) {
            const std::size_t number = a < b ? n : surfaces.size() - 1 - n;
            const double value = surfaces[number].value;
            if ((a < value) != (b < value) && visit(crossing(stretch.cubic, value, from, to), number))
                return true;
        }
    }
    return false;
}

} // namespace tessera
