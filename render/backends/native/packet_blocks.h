// render/backends/native/packet_blocks.h: the range of the field in every block of 2^3 voxels of a cell. The
// field is extreme at sample centres and at blocks' faces: 13 points an axis, five faces and eight samples.
// Sixteen numbers side by side whatever the lanes of rays, because a cell has as many in a row. For
// packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"

#include <cstring>

namespace tessera::TESSERA_LANES {

using native::CellRanges;
using native::CellRows;
using native::CellSamples;
using native::SampleKind;

constexpr int kCellSamples = 10, kCellPoints = 13, kRowFloats = 16;
using CellRow = float __attribute__((vector_size(kRowFloats * sizeof(float))));
using CellNumbers = std::int32_t __attribute__((vector_size(kRowFloats * sizeof(std::int32_t))));
constexpr CellNumbers kNumbers = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

TESSERA_LANE CellRow loadRow(const float (&from)[kRowFloats]) {
    CellRow row;
    std::memcpy(&row, from, sizeof row);
    return row;
}
TESSERA_LANE CellRow halfway(CellRow a, CellRow b) {
    return 0.5f * (a + b);
}
TESSERA_LANE CellRow least(CellRow a, CellRow b) {
    return a < b ? a : b;
}
TESSERA_LANE CellRow most(CellRow a, CellRow b) {
    return a > b ? a : b;
}

/// The samples of one brick, rows along x. Lanes that a row reads beyond them have no meaning
/// (HostPlane::kAround), and are overwritten.
template <typename Stored> void takeRows(const void* brick, const CellRows& rows, CellSamples& out) {
    constexpr std::size_t kSampleBytes = sizeof(Stored) / kRowFloats;
    const CellNumbers others = (kNumbers < rows.first) | (kNumbers > rows.last);
    for (int z = rows.firstZ; z < rows.endZ; ++z)
        for (int y = rows.firstY; y < rows.endY; ++y) {
            Stored stored;
            std::memcpy(&stored,
                        static_cast<const char*>(brick) +
                            (rows.alongZ[z] + rows.alongY[y]) * std::int64_t{kSampleBytes},
                        sizeof stored);
            CellRow values = __builtin_convertvector(stored, CellRow) * rows.scale + rows.offset;
            auto& row = out.rows[z * kCellSamples + y];
            if (!rows.alone)
                values = others ? loadRow(row) : values;
            std::memcpy(&row, &values, sizeof values);
            if (!rows.alone)
                continue;
            for (int x = 0; x < rows.first; ++x)
                row[x] = row[rows.first];
            for (int x = rows.last + 1; x < kRowFloats; ++x)
                row[x] = row[rows.last];
        }
}
inline void cellSamples(const void* brick, SampleKind kind, const CellRows& rows, CellSamples& out) {
    using Signed = std::int16_t __attribute__((vector_size(kRowFloats * sizeof(std::int16_t))));
    using Unsigned = std::uint16_t __attribute__((vector_size(kRowFloats * sizeof(std::uint16_t))));
    switch (kind) {
    case SampleKind::i16:
        return takeRows<Signed>(brick, rows, out);
    case SampleKind::u16:
        return takeRows<Unsigned>(brick, rows, out);
    case SampleKind::f32:
        break;
    }
    takeRows<CellRow>(brick, rows, out);
}

/// Ten samples as thirteen points: the faces between blocks, then of every block its first sample,
/// then its second.
TESSERA_LANE CellRow pointsAlong(CellRow s) {
    return halfway(__builtin_shufflevector(s, s, 0, 2, 4, 6, 8, 1, 3, 5, 7, 2, 4, 6, 8, 8, 8, 8),
                   __builtin_shufflevector(s, s, 1, 3, 5, 7, 9, 1, 3, 5, 7, 2, 4, 6, 8, 8, 8, 8));
}
/// Of a block, from its points along x: in the first four numbers.
template <typename Of> TESSERA_LANE CellRow overBlocks(CellRow p, const Of& of) {
    const CellRow next = __builtin_shufflevector(p, p, 1, 2, 3, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
    const CellRow first = __builtin_shufflevector(p, p, 5, 6, 7, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
    const CellRow second = __builtin_shufflevector(p, p, 9, 10, 11, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
    return of(of(p, next), of(first, second));
}

/// Ten rows as thirteen.
TESSERA_LANE void pointsAcross(const CellRow* from, CellRow (&to)[kCellPoints]) {
    for (int block = 0; block < 4; ++block) {
        to[3 * block] = halfway(from[2 * block], from[2 * block + 1]);
        to[3 * block + 1] = from[2 * block + 1];
        to[3 * block + 2] = from[2 * block + 2];
    }
    to[12] = halfway(from[8], from[9]);
}

inline void cellRanges(const CellSamples& samples, CellRanges& out) {
    CellRow low = loadRow(samples.rows[0]), high = low;
    CellRow slices[kCellSamples][kCellPoints]; // points along x and y
    for (int z = 0; z < kCellSamples; ++z) {
        CellRow alongX[kCellSamples];
        for (int y = 0; y < kCellSamples; ++y) {
            const CellRow row = loadRow(samples.rows[z * kCellSamples + y]);
            low = least(low, row);
            high = most(high, row);
            alongX[y] = pointsAlong(row);
        }
        pointsAcross(alongX, slices[z]);
    }
    out.low = low[0], out.high = high[0];
    for (int x = 1; x < kCellSamples; ++x) {
        out.low = low[x] < out.low ? low[x] : out.low;
        out.high = high[x] > out.high ? high[x] : out.high;
    }
    CellRow lowest[kCellPoints][4], highest[kCellPoints][4]; // of points along z, blocks along y
    for (int z = 0; z < kCellPoints; ++z) {
        const int block = z / 3, part = z % 3;
        const int a = 2 * block + part, b = part == 0 ? 2 * block + 1 : a;
        CellRow line[kCellPoints];
        for (int y = 0; y < kCellPoints; ++y)
            line[y] = halfway(slices[a][y], slices[b][y]);
        for (int j = 0; j < 4; ++j) {
            const CellRow* const four = line + 3 * j;
            lowest[z][j] = least(least(four[0], four[1]), least(four[2], four[3]));
            highest[z][j] = most(most(four[0], four[1]), most(four[2], four[3]));
        }
    }
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j) {
            const int z = 3 * k;
            const CellRow lows = overBlocks(
                least(least(lowest[z][j], lowest[z + 1][j]), least(lowest[z + 2][j], lowest[z + 3][j])),
                [](CellRow a, CellRow b) { return least(a, b); });
            const CellRow highs = overBlocks(
                most(most(highest[z][j], highest[z + 1][j]), most(highest[z + 2][j], highest[z + 3][j])),
                [](CellRow a, CellRow b) { return most(a, b); });
            std::memcpy(out.blockLow + 4 * j + 16 * k, &lows, 4 * sizeof(float));
            std::memcpy(out.blockHigh + 4 * j + 16 * k, &highs, 4 * sizeof(float));
        }
}

} // namespace tessera::TESSERA_LANES
