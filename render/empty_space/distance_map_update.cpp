// render/empty_space/distance_map_update.cpp: updates a map of cells after changes of some bricks' cells
// (distance_map.h). A row of an octant depends on three others. From the octant's far end on, a row is
// computed again only if its own cells or one of those three rows changed. That is exact, and ends where a
// nearer box decides the distances.
#include "core/base/threads.h"
#include "render/empty_space/distance_map.h"
#include "render/empty_space/distance_rows.h"

#include <array>
#include <bit>

namespace tessera {
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
