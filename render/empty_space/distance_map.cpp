// render/empty_space/distance_map.cpp: see distance_map.h. It is computed, and updated after changes.
#include "render/empty_space/distance_map.h"

#include "core/base/brick.h"
#include "core/base/threads.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace tessera {

// Distances of one octant, a row of boxes at a time, for computing a map and updating it. Distances are
// bytes, so the compiler vectorises by sixteen.

namespace {

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

} // namespace

// Each octant is one pass from its far end, slice by slice. The four octants that share their direction along
// z go together, because they write neighbouring bytes of a texel.

namespace {

/// One octant's distances over a slice and over the one before. A slice has a row on both sides for the
/// outside.
struct OctantSlices {
    explicit OctantSlices(const glm::ivec3& grid)
        : here(DistanceRow::pitch(grid.x) * static_cast<std::size_t>(grid.y + 2), kFarthest), last(here) {}
    std::vector<std::uint8_t> here, last;
};

void fillHalf(bool ascendsZ, const OccupiedRows& boxes, const glm::ivec3& grid,
              std::span<SkippingTexel> map) {
    static_assert(std::endian::native == std::endian::little, "byte o of a texel is octant o's");
    const std::size_t width = static_cast<std::size_t>(grid.x), pitch = DistanceRow::pitch(grid.x);
    std::vector<OctantSlices> octants(4, OctantSlices(grid));
    std::vector<std::uint8_t> occupied(width * static_cast<std::size_t>(grid.y));
    DistanceRow row(grid.x);
    for (int k = 0; k < grid.z; ++k) {
        const int z = ascendsZ ? grid.z - 1 - k : k;
        for (int y = 0; y < grid.y; ++y)
            boxes.row(y, z, occupied.data() + width * static_cast<std::size_t>(y));
        for (int octant = 0; octant < 4; ++octant) {
            auto& [here, last] = octants[static_cast<std::size_t>(octant)];
            std::swap(here, last);
            const bool ascendsY = (octant & 2) != 0;
            for (int j = 0; j < grid.y; ++j) {
                const int y = ascendsY ? grid.y - 1 - j : j;
                const std::size_t own = static_cast<std::size_t>(y + 1) * pitch;
                const std::size_t before = ascendsY ? own + pitch : own - pitch;
                row.fill(here.data() + before, last.data() + before, last.data() + own,
                         occupied.data() + width * static_cast<std::size_t>(y), (octant & 1) != 0,
                         here.data() + own + 1);
            }
        }
        char* out = reinterpret_cast<char*>(map.data() + linearIndex({0, 0, z}, grid)) + (ascendsZ ? 4 : 0);
        for (int y = 0; y < grid.y; ++y) {
            const std::size_t own = static_cast<std::size_t>(y + 1) * pitch + 1;
            const std::uint8_t *a = octants[0].here.data() + own, *b = octants[1].here.data() + own,
                               *c = octants[2].here.data() + own, *d = octants[3].here.data() + own,
                               *full = occupied.data() + width * static_cast<std::size_t>(y);
            for (std::size_t x = 0; x < width; ++x, out += sizeof(SkippingTexel)) {
                const std::uint32_t all = std::uint32_t{full[x]} * 0x01010101u;
                const std::uint32_t four =
                    static_cast<std::uint32_t>(a[x]) | static_cast<std::uint32_t>(b[x]) << 8 |
                    static_cast<std::uint32_t>(c[x]) << 16 | static_cast<std::uint32_t>(d[x]) << 24 | all;
                std::memcpy(out, &four, sizeof four);
            }
        }
    }
}

} // namespace

glm::ivec3 mapGrid(const glm::ivec3& extentVoxels, MapScale scale) {
    return scale == MapScale::cells ? cellGrid(extentVoxels) : brickGrid(extentVoxels);
}

void fillDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks, MapScale scale,
                     std::span<SkippingTexel> map, int threads) {
    const glm::ivec3 grid = mapGrid(extentVoxels, scale);
    const OccupiedRows boxes(brickGrid(extentVoxels), masks, scale, grid);
    // Both halves write separate bytes, so they run in parallel.
    parallelFor(2, threads, [&](std::size_t half) { fillHalf(half != 0, boxes, grid, map); });
    if (scale == MapScale::bricks)
        for (std::size_t brick = 0; brick < map.size(); ++brick)
            if (masks[brick] != 0)
                map[brick] = occupiedTexel(masks[brick]);
}

// Updates a map of cells after changes of some bricks' cells (distance_map.h). A row of an octant depends on
// three others. From the octant's far end on, a row is computed again only if its own cells or one of those
// three rows changed. That is exact, and ends where a nearer box decides the distances.

namespace {

using Row = std::vector<std::uint8_t>;

/// The two octants that share their directions along y and z: two bytes side by side of every texel.
class Pair {
  public:
    Pair(bool ascendsY, bool ascendsZ, const OccupiedRows& boxes, const glm::ivec3& grid,
         std::span<SkippingTexel> map)
        : ascendsY_(ascendsY), ascendsZ_(ascendsZ), boxes_(boxes), grid_(grid),
          bytes_(reinterpret_cast<std::uint8_t*>(map.data()) + 2 * ((ascendsY ? 1 : 0) + (ascendsZ ? 2 : 0))),
          fill_(grid.x), occupied_(static_cast<std::size_t>(grid.x)) {
        static_assert(std::endian::native == std::endian::little, "byte o of a texel is octant o's");
        for (auto& rows : near_)
            for (Row& row : rows)
                row.assign(DistanceRow::pitch(grid.x), kFarthest);
        for (Row& row : found_)
            row.resize(static_cast<std::size_t>(grid.x));
    }

    /// @param stale  per row, [z][y]: whether its own cells changed
    ChangedSlices mend(std::vector<std::uint8_t> stale) {
        ChangedSlices changed;
        const int stepY = ascendsY_ ? 1 : -1, stepZ = ascendsZ_ ? 1 : -1;
        for (int k = 0; k < grid_.z; ++k) {
            const int z = ascendsZ_ ? grid_.z - 1 - k : k;
            for (int j = 0; j < grid_.y; ++j) {
                const int y = ascendsY_ ? grid_.y - 1 - j : j;
                if (!stale[flag(y, z)] || !mendRow(y, z, stepY, stepZ))
                    continue;
                changed.add({z, z + 1});
                // Three rows depend on it.
                const bool moreY = y - stepY >= 0 && y - stepY < grid_.y;
                const bool moreZ = z - stepZ >= 0 && z - stepZ < grid_.z;
                if (moreY)
                    stale[flag(y - stepY, z)] = 1;
                if (moreZ)
                    stale[flag(y, z - stepZ)] = 1;
                if (moreY && moreZ)
                    stale[flag(y - stepY, z - stepZ)] = 1;
            }
        }
        return changed;
    }

  private:
    std::size_t flag(int y, int z) const {
        return static_cast<std::size_t>(z) * static_cast<std::size_t>(grid_.y) + static_cast<std::size_t>(y);
    }
    std::uint8_t* rowOf(int y, int z) const {
        return bytes_ + sizeof(SkippingTexel) * linearIndex({0, y, z}, grid_);
    }
    /// Distances of both octants; an occupied texel's bytes are all 255, which is read as 0.
    void read(int y, int z, std::array<Row, 2>& out) const {
        const std::size_t width = static_cast<std::size_t>(grid_.x);
        if (y < 0 || y >= grid_.y || z < 0 || z >= grid_.z) {
            for (Row& row : out)
                std::fill(row.begin(), row.end(), std::uint8_t{kFarthest});
            return;
        }
        const std::uint8_t* from = rowOf(y, z);
        std::uint8_t *down = out[0].data() + 1, *up = out[1].data() + 1;
        for (std::size_t x = 0; x < width; ++x, from += sizeof(SkippingTexel)) {
            down[x] = from[0] > kFarthest ? std::uint8_t{0} : from[0];
            up[x] = from[1] > kFarthest ? std::uint8_t{0} : from[1];
        }
    }
    /// Returns true if it changed.
    bool mendRow(int y, int z, int stepY, int stepZ) {
        const std::size_t width = static_cast<std::size_t>(grid_.x);
        read(y + stepY, z, near_[0]);
        read(y + stepY, z + stepZ, near_[1]);
        read(y, z + stepZ, near_[2]);
        boxes_.row(y, z, occupied_.data());
        for (std::size_t way = 0; way < 2; ++way)
            fill_.fill(near_[0][way].data(), near_[1][way].data(), near_[2][way].data(), occupied_.data(),
                       way == 1, found_[way].data());
        std::uint8_t* to = rowOf(y, z);
        unsigned different = 0;
        for (std::size_t x = 0; x < width; ++x, to += sizeof(SkippingTexel)) {
            const auto down = static_cast<std::uint8_t>(found_[0][x] | occupied_[x]);
            const auto up = static_cast<std::uint8_t>(found_[1][x] | occupied_[x]);
            different |= static_cast<unsigned>(to[0] ^ down) | static_cast<unsigned>(to[1] ^ up);
            to[0] = down;
            to[1] = up;
        }
        return different != 0;
    }

    bool ascendsY_, ascendsZ_;
    const OccupiedRows& boxes_;
    glm::ivec3 grid_;
    std::uint8_t* bytes_;
    DistanceRow fill_;
    std::array<std::array<Row, 2>, 3> near_;
    std::array<Row, 2> found_;
    Row occupied_;
};

} // namespace

ChangedSlices updateDistanceMap(const glm::ivec3& extentVoxels, std::span<const std::uint64_t> masks,
                                MapScale scale, std::span<const std::size_t> changedBricks,
                                std::span<SkippingTexel> map, int threads) {
    const glm::ivec3 grid = mapGrid(extentVoxels, scale), bricks = brickGrid(extentVoxels);
    if (changedBricks.empty())
        return {};
    std::vector<std::uint8_t> stale(static_cast<std::size_t>(grid.y) * static_cast<std::size_t>(grid.z), 0);
    std::size_t rows = 0;
    for (const std::size_t brick : changedBricks) {
        const glm::ivec3 first = gridPosition(brick, bricks) * kCellsPerBrick;
        for (int z = first.z; z < std::min(first.z + kCellsPerBrick, grid.z); ++z)
            for (int y = first.y; y < std::min(first.y + kCellsPerBrick, grid.y); ++y) {
                std::uint8_t& row = stale[static_cast<std::size_t>(z) * static_cast<std::size_t>(grid.y) +
                                          static_cast<std::size_t>(y)];
                rows += row == 0 ? 1 : 0;
                row = 1;
            }
    }
    // Updating a row takes some three times as long as computing one of a whole map, and makes more rows
    // stale.
    constexpr std::size_t kShareToMend = 6;
    if (scale == MapScale::bricks || kShareToMend * rows > stale.size()) {
        fillDistanceMap(extentVoxels, masks, scale, map, threads);
        return {0, grid.z};
    }
    const OccupiedRows boxes(bricks, masks, scale, grid);
    std::array<ChangedSlices, 4> changed;
    parallelFor(4, threads, [&](std::size_t pair) {
        changed[pair] = Pair((pair & 1) != 0, (pair & 2) != 0, boxes, grid, map).mend(stale);
    });
    ChangedSlices all;
    for (const ChangedSlices& slices : changed)
        all.add(slices);
    return all;
}

} // namespace tessera
