// render/labels/outline_band.h: the places of a region that are near its border, on a raster.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// The band along the border of a region, inside of it.
class OutlineBand {
  public:
    /// Of places inside those that lie nearer than `width` to a place outside; widths count from the edges of
    /// places, which are squares of size 1.
    /// @param inside  [y][x] of size: 1 inside, else 0
    /// @param first, count  the places that are asked for; others nearer than width + 1 must be in the raster
    /// Returns [y][x] of count: 1 in the band. Valid until the next call.
    const std::vector<std::uint8_t>& of(const std::vector<std::uint8_t>& inside, const glm::ivec2& size,
                                        const glm::ivec2& first, const glm::ivec2& count, double width);
    /// How far places can matter.
    static int reach(double width);

  private:
    std::vector<std::uint16_t> alongRow_; // squared distances to the nearest place outside in the row
    std::vector<std::uint16_t> nearest_;
    std::vector<std::uint8_t> band_;
};

} // namespace tessera
