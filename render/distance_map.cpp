// render/distance_map.cpp: see distance_map.h. Each octant is one pass from its far end: the largest empty
// cube at a box is one larger than the least of those at the seven boxes next to it in the octant.
#include "render/distance_map.h"

#include "core/threads.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace tessera {
namespace {

/// Where a row of boxes is occupied.
class Boxes {
  public:
    Boxes(const glm::ivec3& bricks, std::span<const std::uint64_t> masks, MapScale scale,
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

/// Distances of one octant over a slice, one row at a time from the octant's far end. A row has a margin of
/// one byte on both sides, and a slice one row on both sides, that stands for the outside: kFarthest.
class OctantSlices {
  public:
    OctantSlices(const glm::ivec3& grid, bool ascendsX, bool ascendsY)
        : width_(static_cast<std::size_t>(grid.x)), pitch_(width_ + 2), ascendsX_(ascendsX),
          ascendsY_(ascendsY), here_(pitch_ * static_cast<std::size_t>(grid.y + 2), kFarthest), last_(here_),
          scratch_(2 * pitch_) {}

    void nextSlice() { std::swap(here_, last_); }

    /// @param occupied  255 or 0, width bytes  Returns the row's distances, width bytes.
    const std::uint8_t* fillRow(int y, const std::uint8_t* occupied) {
        const std::size_t row = static_cast<std::size_t>(y + 1) * pitch_;
        const std::size_t before = ascendsY_ ? row + pitch_ : row - pitch_; // the row that was filled before
        const std::uint8_t *a = here_.data() + before, *b = last_.data() + before, *c = last_.data() + row;
        std::uint8_t *t = scratch_.data(), *d = t + pitch_, *out = here_.data() + row;
        for (std::size_t i = 0; i < pitch_; ++i)
            t[i] = std::min(std::min(a[i], b[i]), std::min(c[i], std::uint8_t{kFarthest - 1}));
        const std::size_t beside = ascendsX_ ? 2 : 0;
        for (std::size_t i = 0; i < width_; ++i)
            d[i] = static_cast<std::uint8_t>((std::min(t[i + 1], t[i + beside]) + 1) & ~occupied[i]);
        // Along the row: d(i) <= d(i beside) + 1, by doubling, because a chain of one after the other is
        // slow.
        for (std::size_t far = 1; far < width_ && far < kFarthest; far *= 2, std::swap(t, d)) {
            const std::uint8_t step = static_cast<std::uint8_t>(far);
            const std::size_t rest = width_ - far;
            if (ascendsX_) {
                relax(d, d + far, step, t, rest);
                std::copy_n(d + rest, far, t + rest);
            } else {
                std::copy_n(d, far, t);
                relax(d + far, d, step, t + far, rest);
            }
        }
        std::copy_n(d, width_, out + 1);
        return out + 1;
    }

  private:
    static void relax(const std::uint8_t* own, const std::uint8_t* other, std::uint8_t step,
                      std::uint8_t* __restrict out, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i)
            out[i] = std::min(own[i], static_cast<std::uint8_t>(other[i] + step));
    }

    std::size_t width_, pitch_;
    bool ascendsX_, ascendsY_;
    std::vector<std::uint8_t> here_, last_, scratch_;
};

/// The two octants that share their directions along y and z: two bytes side by side of every texel.
void fillPair(bool ascendsY, bool ascendsZ, const Boxes& boxes, const glm::ivec3& grid,
              std::span<SkippingTexel> map) {
    const std::size_t width = static_cast<std::size_t>(grid.x);
    OctantSlices down(grid, false, ascendsY), up(grid, true, ascendsY);
    std::vector<std::uint8_t> occupied(width);
    static_assert(std::endian::native == std::endian::little, "byte o of a texel is octant o's");
    const int pair = (ascendsY ? 1 : 0) + (ascendsZ ? 2 : 0);
    for (int k = 0; k < grid.z; ++k) {
        const int z = ascendsZ ? grid.z - 1 - k : k;
        for (int j = 0; j < grid.y; ++j) {
            const int y = ascendsY ? grid.y - 1 - j : j;
            boxes.row(y, z, occupied.data());
            const std::uint8_t* low = down.fillRow(y, occupied.data());
            const std::uint8_t* high = up.fillRow(y, occupied.data());
            char* out = reinterpret_cast<char*>(map.data() + linearIndex({0, y, z}, grid)) + 2 * pair;
            for (std::size_t x = 0; x < width; ++x) {
                const std::uint16_t both =
                    static_cast<std::uint16_t>((low[x] | high[x] << 8) | (occupied[x] != 0 ? 0xFFFF : 0));
                std::memcpy(out + sizeof(SkippingTexel) * x, &both, sizeof both);
            }
        }
        down.nextSlice();
        up.nextSlice();
    }
}

} // namespace

glm::ivec3 mapGrid(const glm::ivec3& extentVoxels, MapScale scale) {
    return scale == MapScale::cells ? cellGrid(extentVoxels) : brickGrid(extentVoxels);
}

void fillDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks, MapScale scale,
                     std::span<SkippingTexel> map, int threads) {
    const glm::ivec3 grid = mapGrid(extentVoxels, scale);
    const Boxes boxes(brickGrid(extentVoxels), masks, scale, grid);
    // Pairs of octants write bytes of their own, so they need not wait for each other.
    parallelFor(4, threads,
                [&](std::size_t pair) { fillPair((pair & 1) != 0, (pair & 2) != 0, boxes, grid, map); });
    if (scale == MapScale::bricks)
        for (std::size_t brick = 0; brick < map.size(); ++brick)
            if (masks[brick] != 0)
                map[brick] = occupiedTexel(masks[brick]);
}

} // namespace tessera
