// render/labels/outline_band.h: the places of a region that are near its border, on a raster.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <vector>

namespace tessera {

/// The band along the border of a region, inside of it.
class OutlineBand {
  public:
    /// The share of places in the part of the region that is nearer than `width` to its border. Places are
    /// squares of size 1 inside or outside of it; a width is true to 0.2, whatever a border's direction.
    /// @param inside  [y][x] of size: 1 inside, else 0
    /// @param first, count  the places that are asked for; those around them up to reach(width) must be in
    /// the
    ///     raster
    /// Returns [y][x] of count: shares, [0,1]. Valid until the next call.
    const std::vector<float>& of(const std::vector<std::uint8_t>& inside, const glm::ivec2& size,
                                 const glm::ivec2& first, const glm::ivec2& count, double width);
    /// How far places can matter.
    static int reach(double width);

  private:
    std::vector<std::uint16_t> alongRow_; // squared distances to the nearest place outside in the row
    std::vector<std::uint16_t> nearest_;
    double width_ = -1;                 // that shareOf_ is of
    std::vector<float> shareOf_, band_; // shareOf_: by squared distances
};

} // namespace tessera
