// render/engines/native/fine_blocks.cpp: see fine_blocks.h.
#include "render/engines/native/fine_blocks.h"

#include "core/error.h"
#include "core/threads.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

namespace tessera {
namespace {

using native::PacketBrick;
using native::SampleKind;

constexpr int kSamples = 10; // along a cell: its 8, and one on both sides
constexpr int kRow = 16;     // floats of a row of CellSamples

/// As places in the table.
template <typename Stored>
void load(const Stored* first, std::int64_t row, std::int64_t slice, float scale, float offset,
          native::CellSamples& out) {
    for (int z = 0; z < kSamples; ++z)
        for (int y = 0; y < kSamples; ++y) {
            const Stored* const from = first + z * slice + y * row;
            float* const to = out.rows[z * kSamples + y];
            for (int x = 0; x < kSamples; ++x)
                to[x] = static_cast<float>(from[x]) * scale + offset;
            std::fill(to + kSamples, to + kRow, to[0]);
        }
}

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

bool fineBlocksPay(const Occupancy& occupancy, std::size_t rays) {
    constexpr std::size_t kRaysPerCell = 2;
    return occupancy.scale() == MapScale::cells && rays >= kRaysPerCell * occupancy.plainCells();
}

std::size_t refineBlocks(const HostPlane& plane, const Occupancy& occupancy, const Statistics& statistics,
                         const TransferTable& table, const Optics& optics, const native::PacketTarget& target,
                         int threads, std::span<SkippingTexel> map) {
    TESSERA_CHECK(occupancy.scale() == MapScale::cells && map.size() == occupancy.map().size());
    TESSERA_CHECK(statistics.cellMin.size() == map.size());
    const glm::ivec3& grid = occupancy.grid();
    std::atomic<std::size_t> looked{0};
    parallelFor(
        static_cast<std::size_t>(grid.z) * static_cast<std::size_t>(grid.y), threads, [&](std::size_t line) {
            native::CellSamples samples;
            native::CellRanges ranges;
            std::size_t mine = 0;
            for (int x = 0; x < grid.x; ++x) {
                const glm::ivec3 cell(x, static_cast<int>(line) % grid.y, static_cast<int>(line) / grid.y);
                const std::size_t number = linearIndex(cell, grid);
                SkippingTexel& texel = map[number];
                if (!isOccupied(texel) || !occupancy.isPlain(cell))
                    continue;
                const PacketBrick& brick = plane.bricks()[linearIndex(cell / kCellsPerBrick, plane.grid())];
                if (brick.low != 0x070707u) // of level 0, its apron one sample before it
                    continue;
                const float a = statistics.cellMin[number] * optics.scale + optics.offset;
                const float b = statistics.cellMax[number] * optics.scale + optics.offset;
                if (showsThroughout(table, std::min(a, b), std::max(a, b)))
                    continue;
                const glm::ivec3 first = (cell % kCellsPerBrick) * kCellExtent - 1;
                const std::int64_t row = plane.rowPitch(0), slice = plane.slicePitch(0);
                const std::int64_t at = std::int64_t{brick.base} + first.z * slice + first.y * row + first.x;
                switch (plane.kind()) {
                case SampleKind::i16:
                    load(static_cast<const std::int16_t*>(plane.samples()) + at, row, slice, optics.scale,
                         optics.offset, samples);
                    break;
                case SampleKind::u16:
                    load(static_cast<const std::uint16_t*>(plane.samples()) + at, row, slice, optics.scale,
                         optics.offset, samples);
                    break;
                case SampleKind::f32:
                    load(static_cast<const float*>(plane.samples()) + at, row, slice, optics.scale,
                         optics.offset, samples);
                    break;
                }
                target.cellRanges(samples, ranges);
                // How far a value between samples can be computed from the true one: some thirty roundings of
                // 2^-24, here and where rays take it.
                const float slack =
                    (std::max(std::abs(ranges.low), std::abs(ranges.high)) + 2 * std::abs(optics.offset)) /
                    262144.0f;
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
