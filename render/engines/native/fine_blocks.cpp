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
constexpr int kPoints = 13;  // along a cell: five faces of blocks, and its samples
constexpr int kRow = 16;     // floats of a row of either

/// A cell's samples as places in the table: rows along x, y fastest.
struct CellSamples {
    alignas(64) float rows[kSamples * kSamples][kRow];
};

template <typename Stored>
void load(const Stored* first, std::int64_t row, std::int64_t slice, float scale, float offset,
          CellSamples& out) {
    for (int z = 0; z < kSamples; ++z)
        for (int y = 0; y < kSamples; ++y) {
            const Stored* const from = first + z * slice + y * row;
            float* const to = out.rows[z * kSamples + y];
            for (int x = 0; x < kSamples; ++x)
                to[x] = static_cast<float>(from[x]) * scale + offset;
        }
}

struct Extremes {
    float low, high;
};
struct BlockRanges {
    Extremes blocks[64]; // x + 4y + 16z
    float low, high;     // of all samples
};

/// One row of samples as the values at faces and samples: f s s f s s f s s f s s f.
void pointsAlong(const float* s, float* p) {
    for (int block = 0; block < 4; ++block) {
        p[3 * block] = 0.5f * (s[2 * block] + s[2 * block + 1]);
        p[3 * block + 1] = s[2 * block + 1];
        p[3 * block + 2] = s[2 * block + 2];
    }
    p[12] = 0.5f * (s[8] + s[9]);
}

/// Rows a, b halfway between which the point lies; the same where it is a sample's.
struct Between {
    int a, b;
};
constexpr Between between(int point) {
    const int block = point / 3, part = point % 3;
    return part == 0 ? Between{2 * block, 2 * block + 1} : Between{2 * block + part, 2 * block + part};
}

void rangesOf(const CellSamples& samples, BlockRanges& out) {
    alignas(64) static thread_local float alongX[kSamples * kSamples][kRow];
    for (int r = 0; r < kSamples * kSamples; ++r) {
        pointsAlong(samples.rows[r], alongX[r]);
        alongX[r][13] = alongX[r][14] = alongX[r][15] = alongX[r][12];
    }
    out.low = out.high = samples.rows[0][0];
    for (int r = 0; r < kSamples * kSamples; ++r)
        for (int x = 0; x < kSamples; ++x) {
            out.low = std::min(out.low, samples.rows[r][x]);
            out.high = std::max(out.high, samples.rows[r][x]);
        }
    alignas(64) float low[4][4][kRow], high[4][4][kRow]; // z, y of blocks; points along x
    for (auto& slice : low)
        for (auto& row : slice)
            std::fill(row, row + kRow, std::numeric_limits<float>::max());
    for (auto& slice : high)
        for (auto& row : slice)
            std::fill(row, row + kRow, std::numeric_limits<float>::lowest());
    for (int z = 0; z < kPoints; ++z) {
        const Between bz = between(z);
        for (int y = 0; y < kPoints; ++y) {
            const Between by = between(y);
            const float* const r00 = alongX[bz.a * kSamples + by.a];
            const float* const r01 = alongX[bz.a * kSamples + by.b];
            const float* const r10 = alongX[bz.b * kSamples + by.a];
            const float* const r11 = alongX[bz.b * kSamples + by.b];
            alignas(64) float value[kRow];
            for (int x = 0; x < kRow; ++x)
                value[x] = 0.5f * (0.5f * (r00[x] + r01[x]) + 0.5f * (r10[x] + r11[x]));
            // A face belongs to the blocks on both sides.
            const int lastZ = std::min(z / 3, 3), firstZ = z % 3 == 0 && z > 0 ? z / 3 - 1 : lastZ;
            const int lastY = std::min(y / 3, 3), firstY = y % 3 == 0 && y > 0 ? y / 3 - 1 : lastY;
            for (int k = firstZ; k <= lastZ; ++k)
                for (int j = firstY; j <= lastY; ++j)
                    for (int x = 0; x < kRow; ++x) {
                        low[k][j][x] = std::min(low[k][j][x], value[x]);
                        high[k][j][x] = std::max(high[k][j][x], value[x]);
                    }
        }
    }
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) {
                const float *a = low[k][j] + 3 * i, *b = high[k][j] + 3 * i;
                out.blocks[i + 4 * j + 16 * k] = {std::min(std::min(a[0], a[1]), std::min(a[2], a[3])),
                                                  std::max(std::max(b[0], b[1]), std::max(b[2], b[3]))};
            }
}

/// Whether any value of the range shows. Entry i shows from i - 1 to i + 1, because entries are interpolated
/// between.
bool showsWithin(const TransferTable& table, float low, float high) {
    const float end = static_cast<float>(table.entries.size() - 1);
    const auto from = static_cast<std::size_t>(std::clamp(std::floor(low), 0.0f, end));
    const auto to = static_cast<std::size_t>(std::clamp(std::ceil(high), 0.0f, end));
    return table.nonZeroUpTo[to] > (from == 0 ? 0 : table.nonZeroUpTo[from - 1]);
}

} // namespace

bool fineBlocksPay(const Occupancy& occupancy, std::size_t rays) {
    constexpr std::size_t kRaysPerCell = 2;
    return occupancy.scale() == MapScale::cells && rays >= kRaysPerCell * occupancy.plainCells();
}

std::size_t refineBlocks(const HostPlane& plane, const Occupancy& occupancy, const TransferTable& table,
                         const Optics& optics, int threads, std::span<SkippingTexel> map) {
    TESSERA_CHECK(occupancy.scale() == MapScale::cells && map.size() == occupancy.map().size());
    const glm::ivec3& grid = occupancy.grid();
    std::atomic<std::size_t> looked{0};
    parallelFor(
        static_cast<std::size_t>(grid.z) * static_cast<std::size_t>(grid.y), threads, [&](std::size_t line) {
            CellSamples samples;
            BlockRanges ranges;
            std::size_t mine = 0;
            for (int x = 0; x < grid.x; ++x) {
                const glm::ivec3 cell(x, static_cast<int>(line) % grid.y, static_cast<int>(line) / grid.y);
                SkippingTexel& texel = map[linearIndex(cell, grid)];
                if (!isOccupied(texel) || !occupancy.isPlain(cell))
                    continue;
                const PacketBrick& brick = plane.bricks()[linearIndex(cell / kCellsPerBrick, plane.grid())];
                if ((brick.low & 0xffffffu) != 0x070707u) // its apron begins one sample before it
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
                rangesOf(samples, ranges);
                // How far a value between samples can be computed from the true one: some thirty roundings of
                // 2^-24, here and where rays take it.
                const float slack =
                    (std::max(std::abs(ranges.low), std::abs(ranges.high)) + 2 * std::abs(optics.offset)) /
                    262144.0f;
                std::uint64_t blocks = 0;
                for (int n = 0; n < 64; ++n)
                    if (showsWithin(table, ranges.blocks[n].low - slack, ranges.blocks[n].high + slack))
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
