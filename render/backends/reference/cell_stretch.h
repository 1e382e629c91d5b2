// render/backends/reference/cell_stretch.h: the part of a ray in one cell of the field, as a cubic, and the
// isosurfaces that it crosses.
#pragma once

#include "core/scene/scene.h" // Isosurface
#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/cubic.h"

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

namespace tessera {

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
