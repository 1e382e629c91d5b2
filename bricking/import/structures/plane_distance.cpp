// bricking/import/structures/plane_distance.cpp: see plane_distance.h.
#include "bricking/import/structures/plane_distance.h"

#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <limits>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint32_t kNoSide = std::numeric_limits<std::uint32_t>::max();
constexpr float kLeast = 1e-4F;

/// A side of a ring, in steps of the grid.
struct RingSide {
    glm::dvec2 from{0}, to{0};
    double distance2(const glm::dvec2& p) const {
        const glm::dvec2 along = to - from, off = p - from;
        const double length2 = glm::dot(along, along);
        const double t = length2 > 0 ? std::clamp(glm::dot(off, along) / length2, 0.0, 1.0) : 0;
        const glm::dvec2 rest = off - t * along;
        return glm::dot(rest, rest);
    }
};

/// Sides that are there twice bound nothing: the two ways of a keyhole to a hole in its ring.
void cancelTwins(std::vector<RingSide>& sides) {
    const auto key = [](const RingSide& side) {
        const std::array<double, 2> a = {side.from.x, side.from.y}, b = {side.to.x, side.to.y};
        return std::pair(std::min(a, b), std::max(a, b));
    };
    std::sort(sides.begin(), sides.end(),
              [&](const RingSide& a, const RingSide& b) { return key(a) < key(b); });
    std::vector<RingSide> left;
    for (const RingSide& side : sides) {
        if (!left.empty() && key(left.back()) == key(side))
            left.pop_back();
        else
            left.push_back(side);
    }
    sides = std::move(left);
}

std::vector<RingSide> sidesOf(const StructurePlane& plane, const PlaneGrid& grid) {
    std::vector<RingSide> sides;
    for (const auto& ring : plane.rings)
        for (std::size_t i = 0; i < ring.size(); ++i)
            sides.push_back({(ring[i] - grid.origin) / grid.step,
                             (ring[(i + 1) % ring.size()] - grid.origin) / grid.step});
    cancelTwins(sides);
    return sides;
}

class NearestSides {
  public:
    NearestSides(const std::vector<RingSide>& sides, const PlaneGrid& grid)
        : sides_(sides), grid_(grid), side_(grid.points(), kNoSide),
          distance2_(grid.points(), std::numeric_limits<float>::max()) {}

    /// The points around every side.
    void begin() {
        for (std::uint32_t s = 0; s < sides_.size(); ++s) {
            const RingSide& side = sides_[s];
            // Along the side in pieces of a step, so that a long one has no wide box.
            const double length = glm::distance(side.from, side.to);
            const int pieces = static_cast<int>(std::min(length, 1e6)) + 1;
            for (int i = 0; i <= pieces; ++i) {
                const glm::dvec2 at = glm::mix(side.from, side.to, static_cast<double>(i) / pieces);
                const glm::ivec2 low = glm::ivec2(glm::floor(at)) - 1;
                for (int y = std::max(low.y, 0); y <= std::min(low.y + 3, grid_.ny - 1); ++y)
                    for (int x = std::max(low.x, 0); x <= std::min(low.x + 3, grid_.nx - 1); ++x)
                        offer(x, y, s);
            }
        }
    }
    /// From point to point: forth and back, and once more for what comes around corners.
    void spread() {
        for (int pass = 0; pass < 2; ++pass) {
            for (int y = 0; y < grid_.ny; ++y) {
                for (int x = 0; x < grid_.nx; ++x)
                    take(x, y, {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}});
                for (int x = grid_.nx - 1; x >= 0; --x)
                    take(x, y, {{1, 0}, {1, -1}, {0, -1}, {-1, -1}});
            }
            for (int y = grid_.ny - 1; y >= 0; --y) {
                for (int x = grid_.nx - 1; x >= 0; --x)
                    take(x, y, {{1, 0}, {1, 1}, {0, 1}, {-1, 1}});
                for (int x = 0; x < grid_.nx; ++x)
                    take(x, y, {{-1, 0}, {-1, 1}, {0, 1}, {1, 1}});
            }
        }
    }
    float distance(std::size_t at) const { return std::max(std::sqrt(distance2_[at]), kLeast); }

  private:
    std::size_t indexOf(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.nx) + static_cast<std::size_t>(x);
    }
    void offer(int x, int y, std::uint32_t side) {
        const std::size_t at = indexOf(x, y);
        if (side_[at] == side)
            return;
        const auto found = static_cast<float>(sides_[side].distance2(glm::dvec2(x, y)));
        if (found < distance2_[at]) {
            distance2_[at] = found;
            side_[at] = side;
        }
    }
    void take(int x, int y, std::initializer_list<glm::ivec2> from) {
        for (const glm::ivec2& step : from) {
            const int ox = x + step.x, oy = y + step.y;
            if (ox >= 0 && oy >= 0 && ox < grid_.nx && oy < grid_.ny && side_[indexOf(ox, oy)] != kNoSide)
                offer(x, y, side_[indexOf(ox, oy)]);
        }
    }

    const std::vector<RingSide>& sides_;
    const PlaneGrid& grid_;
    std::vector<std::uint32_t> side_;
    std::vector<float> distance2_;
};

} // namespace

void distancesTo(const StructurePlane& plane, const PlaneGrid& grid, std::span<float> out) {
    TESSERA_CHECK(out.size() == grid.points());
    const std::vector<RingSide> sides = sidesOf(plane, grid);
    NearestSides nearest(sides, grid);
    nearest.begin();
    nearest.spread();
    // Where rows of the grid cross rings: a row that meets a corner counts as just below it.
    std::vector<std::vector<double>> crossings(static_cast<std::size_t>(grid.ny));
    for (const RingSide& side : sides) {
        const double low = std::min(side.from.y, side.to.y), high = std::max(side.from.y, side.to.y);
        const int first = std::max(0, static_cast<int>(std::ceil(low)));
        for (int y = first; y < grid.ny && y < high; ++y)
            crossings[static_cast<std::size_t>(y)].push_back(
                side.from.x + (y - side.from.y) / (side.to.y - side.from.y) * (side.to.x - side.from.x));
    }
    for (int y = 0; y < grid.ny; ++y) {
        std::vector<double>& row = crossings[static_cast<std::size_t>(y)];
        std::sort(row.begin(), row.end());
        std::size_t passed = 0;
        for (int x = 0; x < grid.nx; ++x) {
            while (passed < row.size() && row[passed] < x)
                ++passed;
            const std::size_t at =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.nx) + static_cast<std::size_t>(x);
            out[at] = (passed % 2 == 1 ? -1.0F : 1.0F) * nearest.distance(at);
        }
    }
}

} // namespace tessera
