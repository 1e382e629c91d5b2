// render/empty_space/distance_map.cpp: see distance_map.h. Each octant is one pass from its far end, slice by
// slice. The four octants that share their direction along z go together, because they write neighbouring
// bytes of a texel.
#include "render/empty_space/distance_map.h"

#include "core/base/threads.h"
#include "render/empty_space/distance_rows.h"

#include <bit>
#include <cstring>

namespace tessera {
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

} // namespace tessera
