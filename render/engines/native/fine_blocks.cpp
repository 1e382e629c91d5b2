// render/engines/native/fine_blocks.cpp: see fine_blocks.h.
#include "render/engines/native/fine_blocks.h"

#include "core/error.h"
#include "core/threads.h"
#include "render/engines/native/block_ranges.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

namespace tessera {
namespace {

/// Entries of the table around a range of places, and those of them that show something.
struct Entries {
    int showing = 0, all = 0;
};
Entries entriesWithin(const TransferTable& table, float low, float high) {
    const float end = static_cast<float>(table.entries.size() - 1);
    const float first = std::clamp(low, 0.0f, end), last = std::clamp(high, 0.0f, end);
    const auto from = static_cast<std::size_t>(static_cast<int>(first)); // not negative, so this is floor
    const int whole = static_cast<int>(last);
    const auto to = static_cast<std::size_t>(whole + (static_cast<float>(whole) < last ? 1 : 0));
    return {table.nonZeroUpTo[to] - (from == 0 ? 0 : table.nonZeroUpTo[from - 1]),
            static_cast<int>(to - from) + 1};
}

/// Whether any value of the range shows. Entry i shows from i - 1 to i + 1, because entries are interpolated
/// between.
bool showsWithin(const TransferTable& table, float low, float high) {
    const Entries e = entriesWithin(table, low, high);
    return e.showing > 0;
}
/// Whether every value of the range does.
bool showsThroughout(const TransferTable& table, float low, float high) {
    const Entries e = entriesWithin(table, low, high);
    return e.showing == e.all;
}

} // namespace

bool fineBlocksPay(const Occupancy& occupancy, bool mixed, std::size_t rays) {
    // Where levels mix a value takes so much longer that a fourth of the rays gain as much.
    constexpr std::size_t kRaysPerTwoCells = 4, kRaysPerTwoMixedCells = 1;
    const std::size_t perTwo = mixed ? kRaysPerTwoMixedCells : kRaysPerTwoCells;
    return occupancy.scale() == MapScale::cells && 2 * rays >= perTwo * occupancy.occupiedCells();
}

std::size_t refineBlocks(const HostPlane& plane, const Occupancy& occupancy, const Statistics& statistics,
                         const LevelMap* levels, int level, const TransferTable& table, const Optics& optics,
                         const native::PacketTarget& target, int threads, std::span<SkippingTexel> map) {
    TESSERA_CHECK(occupancy.scale() == MapScale::cells && map.size() == occupancy.map().size());
    TESSERA_CHECK(statistics.cellMin.size() == map.size());
    const glm::ivec3& grid = occupancy.grid();
    std::atomic<std::size_t> looked{0};
    parallelFor(
        static_cast<std::size_t>(grid.z) * static_cast<std::size_t>(grid.y), threads, [&](std::size_t line) {
            BlockRanges field(plane, levels, level, optics.scale, optics.offset, target);
            std::size_t mine = 0;
            for (int x = 0; x < grid.x; ++x) {
                const glm::ivec3 cell(x, static_cast<int>(line) % grid.y, static_cast<int>(line) / grid.y);
                const std::size_t number = linearIndex(cell, grid);
                SkippingTexel& texel = map[number];
                if (!isOccupied(texel))
                    continue;
                const float a = statistics.cellMin[number] * optics.scale + optics.offset;
                const float b = statistics.cellMax[number] * optics.scale + optics.offset;
                if (showsThroughout(table, std::min(a, b), std::max(a, b)))
                    continue;
                const native::CellRanges& ranges = field.of(cell);
                // How far a value between samples can be computed from the true one: some sixty roundings of
                // 2^-24, here and where rays take it and blend it.
                const float slack =
                    (std::max(std::abs(ranges.low), std::abs(ranges.high)) + 2 * std::abs(optics.offset)) /
                    131072.0f;
                std::uint64_t blocks = 0;
                for (int n = 0; n < 64; ++n)
                    if (showsWithin(table, ranges.blockLow[n] - slack, ranges.blockHigh[n] + slack))
                        blocks |= std::uint64_t{1} << n;
                texel = blocks != 0 ? occupiedTexel(blocks)
                                    : 0x0101010101010101u; // empty after all, and no further
                ++mine;
            }
            looked += mine;
        });
    return looked;
}

} // namespace tessera
