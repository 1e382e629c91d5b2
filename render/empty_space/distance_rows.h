// render/empty_space/distance_rows.h: distances of one octant, a row of boxes at a time, for computing a map
// (distance_map.cpp) and updating it (distance_map_update.cpp). Distances are bytes, so the compiler
// vectorises by sixteen.
#pragma once

#include "core/base/brick.h"
#include "render/empty_space/distance_map.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tessera {

/// The occupancy of a row of boxes.
class OccupiedRows {
  public:
    OccupiedRows(const glm::ivec3& bricks, std::span<const std::uint64_t> masks, MapScale scale,
                 const glm::ivec3& grid)
        : bricks_(bricks), masks_(masks), scale_(scale), grid_(grid) {}

    /// 255 where occupied, else 0; grid.x bytes.
    void row(int y, int z, std::uint8_t* out) const {
        const bool cells = scale_ == MapScale::cells;
        const glm::ivec3 first =
            cells ? glm::ivec3(0, y / kCellsPerBrick, z / kCellsPerBrick) : glm::ivec3(0, y, z);
        const std::uint64_t* masks = masks_.data() + linearIndex(first, bricks_);
        for (int x = 0; !cells && x < grid_.x; ++x)
            out[x] = masks[x] != 0 ? 255 : 0;
        if (!cells)
            return;
        const int shift = kCellsPerBrick * (y % kCellsPerBrick) + 16 * (z % kCellsPerBrick);
        for (int x = 0; x < grid_.x; ++x)
            out[x] = (masks[x / kCellsPerBrick] >> (shift + x % kCellsPerBrick) & 1u) != 0 ? 255 : 0;
    }

  private:
    glm::ivec3 bricks_;
    std::span<const std::uint64_t> masks_;
    MapScale scale_;
    glm::ivec3 grid_;
};

/// The recurrence along a row. A box's distance is 0 where it is occupied. Else it is one larger than the
/// minimum of the seven adjacent boxes in the octant.
class DistanceRow {
  public:
    /// Bytes of a row of distances: one before it and one behind it stand for the outside, kFarthest.
    static std::size_t pitch(int width) { return static_cast<std::size_t>(width) + 2; }

    explicit DistanceRow(int width)
        : width_(static_cast<std::size_t>(width)), here_(pitch(width)), there_(pitch(width)) {}

    /// @param a, b, c  distances of the three adjacent rows in the octant, pitch() bytes each
    /// @param occupied  255 or 0, width bytes
    /// @param out  width bytes, without those for the outside
    void fill(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* c,
              const std::uint8_t* occupied, bool ascendsX, std::uint8_t* out) {
        std::uint8_t *t = here_.data(), *d = there_.data();
        for (std::size_t i = 0; i < width_ + 2; ++i)
            t[i] = std::min(std::min(a[i], b[i]), std::min(c[i], std::uint8_t{kFarthest - 1}));
        const std::size_t beside = ascendsX ? 2 : 0;
        for (std::size_t i = 0; i < width_; ++i)
            d[i] = static_cast<std::uint8_t>((std::min(t[i + 1], t[i + beside]) + 1) & ~occupied[i]);
        // Along the row: d(i) <= d(neighbour) + 1, by doubling, because a sequential chain is slow.
        for (std::size_t far = 1; far < width_ && far < kFarthest; far *= 2, std::swap(t, d)) {
            const std::uint8_t step = static_cast<std::uint8_t>(far);
            const std::size_t rest = width_ - far;
            if (ascendsX) {
                relax(d, d + far, step, t, rest);
                std::copy_n(d + rest, far, t + rest);
            } else {
                std::copy_n(d, far, t);
                relax(d + far, d, step, t + far, rest);
            }
        }
        std::copy_n(d, width_, out);
    }

  private:
    static void relax(const std::uint8_t* own, const std::uint8_t* other, std::uint8_t step,
                      std::uint8_t* __restrict out, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i)
            out[i] = std::min(own[i], static_cast<std::uint8_t>(other[i] + step));
    }

    std::size_t width_;
    std::vector<std::uint8_t> here_, there_;
};

} // namespace tessera
