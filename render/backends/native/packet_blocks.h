// render/backends/native/packet_blocks.h: the range of the field in every block of 2^3 voxels of a cell. The
// field is extreme at sample centres and at blocks' faces: 13 points an axis, five faces and eight samples.
// Sixteen numbers side by side whatever the lanes of rays, as many registers as that takes: along x a block
// has four points, and a cell four blocks. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"

#include <cstring>

namespace tessera::TESSERA_LANES {

using native::CellRanges;
using native::CellRows;
using native::CellSamples;
using native::SampleKind;

constexpr int kCellSamples = 10, kCellPoints = 13, kCellBlocks = 4, kRowFloats = 16;

// Compilers take vectors that are wider than a register apart, number by number: a row is an array of them.
constexpr int kRowParts = kRowFloats / single::kWidth;
struct CellRow {
    single::F part[kRowParts];
};
template <typename Of> TESSERA_LANE CellRow partByPart(const CellRow& a, const CellRow& b, const Of& of) {
    CellRow row;
    for (int n = 0; n < kRowParts; ++n)
        row.part[n] = of(a.part[n], b.part[n]);
    return row;
}
TESSERA_LANE single::F halfway(single::F a, single::F b) {
    return single::F(0.5f) * (a + b);
}
TESSERA_LANE CellRow halfway(const CellRow& a, const CellRow& b) {
    return partByPart(a, b, [](single::F x, single::F y) { return halfway(x, y); });
}
TESSERA_LANE CellRow least(const CellRow& a, const CellRow& b) {
    return partByPart(a, b, [](single::F x, single::F y) { return single::min(x, y); });
}
TESSERA_LANE CellRow most(const CellRow& a, const CellRow& b) {
    return partByPart(a, b, [](single::F x, single::F y) { return single::max(x, y); });
}

/// Samples as they are stored, as numbers.
template <typename Stored> TESSERA_LANE single::F numbersFrom(const Stored* from) {
    if constexpr (sizeof(Stored) == sizeof(float)) {
        return single::load(from);
    } else {
        typedef Stored Some __attribute__((vector_size(single::kWidth * sizeof(Stored))));
        typedef std::int32_t Whole __attribute__((vector_size(single::kWidth * sizeof(std::int32_t))));
        Some stored;
        std::memcpy(&stored, from, sizeof stored);
        const Whole whole = __builtin_convertvector(stored, Whole);
        single::I numbers;
        std::memcpy(&numbers, &whole, sizeof whole);
        return single::number(numbers);
    }
}

/// The samples of one brick, rows along x. Those that a row reads beyond them have no meaning
/// (HostPlane::kAround), and are overwritten.
template <typename Stored> void takeRows(const Stored* brick, const CellRows& rows, CellSamples& out) {
    const single::F scale(rows.scale), offset(rows.offset);
    for (int z = rows.firstZ; z < rows.endZ; ++z)
        for (int y = rows.firstY; y < rows.endY; ++y) {
            const Stored* const from = brick + rows.alongZ[z] + rows.alongY[y];
            alignas(64) float values[kRowFloats];
            for (int x = 0; x < kRowFloats; x += single::kWidth)
                single::store(values + x, numbersFrom(from + x) * scale + offset);
            auto& row = out.rows[z * kCellSamples + y];
            if (rows.alone) {
                for (int x = 0; x < rows.first; ++x)
                    values[x] = values[rows.first];
                for (int x = rows.last + 1; x < kCellSamples; ++x)
                    values[x] = values[rows.last];
                std::memcpy(row, values, sizeof values);
            } else {
                std::memcpy(row + rows.first, values + rows.first,
                            static_cast<std::size_t>(rows.last + 1 - rows.first) * sizeof(float));
            }
        }
}
inline void cellSamples(const void* brick, SampleKind kind, const CellRows& rows, CellSamples& out) {
    switch (kind) {
    case SampleKind::i16:
        return takeRows(static_cast<const std::int16_t*>(brick), rows, out);
    case SampleKind::u16:
        return takeRows(static_cast<const std::uint16_t*>(brick), rows, out);
    case SampleKind::f32:
        break;
    }
    takeRows(static_cast<const float*>(brick), rows, out);
}

/// Four numbers side by side, which every set of instructions has.
using Four = float __attribute__((vector_size(16)));
TESSERA_LANE Four load4(const float* from) {
    Four four;
    std::memcpy(&four, from, sizeof four);
    return four;
}

template <typename... Part> TESSERA_LANE CellRow rowOf(Part... part) {
    CellRow row;
    static_assert(sizeof row == (sizeof part + ...));
    char* to = reinterpret_cast<char*>(&row);
    ((std::memcpy(to, &part, sizeof part), to += sizeof part), ...);
    return row;
}

/// Points along x: of the four blocks the first face, the other face, and two samples.
TESSERA_LANE CellRow pointsAlong(const float (&row)[kRowFloats]) {
    const Four a = load4(row), b = load4(row + 4), c = load4(row + 2), d = load4(row + 6);
    if constexpr (single::kWidth == 4) {
        const Four before = __builtin_shufflevector(a, b, 0, 2, 4, 6);
        const Four first = __builtin_shufflevector(a, b, 1, 3, 5, 7);
        const Four second = __builtin_shufflevector(c, d, 0, 2, 4, 6);
        const Four behind = __builtin_shufflevector(c, d, 1, 3, 5, 7);
        return rowOf(0.5f * (before + first), 0.5f * (second + behind), first, second);
    } else {
        const auto low = __builtin_shufflevector(a, c, 0, 1, 2, 3, 4, 5, 6, 7);
        const auto high = __builtin_shufflevector(b, d, 0, 1, 2, 3, 4, 5, 6, 7);
        const auto even = __builtin_shufflevector(low, high, 0, 2, 8, 10, 4, 6, 12, 14);
        const auto odd = __builtin_shufflevector(low, high, 1, 3, 9, 11, 5, 7, 13, 15);
        return rowOf(0.5f * (even + odd), __builtin_shufflevector(odd, even, 0, 1, 2, 3, 12, 13, 14, 15));
    }
}
/// Over the four points of a block each.
template <typename Of> TESSERA_LANE void overBlocks(const CellRow& points, float* blocks, const Of& of) {
    alignas(64) float p[kRowFloats];
    for (int n = 0; n < kRowParts; ++n)
        single::store(p + n * single::kWidth, points.part[n]);
    const Four all = of(of(load4(p), load4(p + 4)), of(load4(p + 8), load4(p + 12)));
    std::memcpy(blocks, &all, sizeof all);
}

/// Least and largest of all ten samples of rows.
struct RowRange {
    static constexpr int kLoads = (kCellSamples + single::kWidth - 1) / single::kWidth;
    single::F low[kLoads], high[kLoads];
    static constexpr int first(int load) {
        return load == 0 || load + 1 < kLoads ? load * single::kWidth : kCellSamples - single::kWidth;
    }
    __attribute__((always_inline)) explicit RowRange(const float* row) {
        for (int n = 0; n < kLoads; ++n)
            low[n] = high[n] = single::load(row + first(n));
    }
    __attribute__((always_inline)) void add(const float* row) {
        for (int n = 0; n < kLoads; ++n) {
            const single::F some = single::load(row + first(n));
            low[n] = single::min(low[n], some);
            high[n] = single::max(high[n], some);
        }
    }
    void tell(CellRanges& out) const {
        alignas(64) float lows[single::kWidth], highs[single::kWidth];
        out.low = kMostFloat, out.high = -kMostFloat;
        for (int n = 0; n < kLoads; ++n) {
            single::store(lows, low[n]), single::store(highs, high[n]);
            for (int lane = 0; lane < single::kWidth && first(n) + lane < kCellSamples; ++lane) {
                out.low = lows[lane] < out.low ? lows[lane] : out.low;
                out.high = highs[lane] > out.high ? highs[lane] : out.high;
            }
        }
    }
};

inline void cellRanges(const CellSamples& samples, CellRanges& out) {
    // From slice to slice: samples along z; along y first the five faces, then the eight samples; along x
    // points.
    RowRange range(samples.rows[0]);
    CellRow slices[kCellSamples][kCellPoints];
    for (int z = 0; z < kCellSamples; ++z) {
        CellRow alongX[kCellSamples];
        for (int y = 0; y < kCellSamples; ++y) {
            range.add(samples.rows[z * kCellSamples + y]);
            alongX[y] = pointsAlong(samples.rows[z * kCellSamples + y]);
        }
        for (int face = 0; face <= kCellBlocks; ++face)
            slices[z][face] = halfway(alongX[2 * face], alongX[2 * face + 1]);
        for (int y = 1; y + 1 < kCellSamples; ++y)
            slices[z][kCellBlocks + y] = alongX[y];
    }
    range.tell(out);
    // Of planes across z: faces, then samples; blocks along y.
    CellRow low[kCellPoints][kCellBlocks], high[kCellPoints][kCellBlocks];
    const auto reduce = [&](int plane, const auto& at) {
        CellRow before = at(0);
        for (int block = 0; block < kCellBlocks; ++block) {
            const CellRow behind = at(block + 1);
            const CellRow a = at(kCellBlocks + 1 + 2 * block), b = at(kCellBlocks + 2 + 2 * block);
            low[plane][block] = least(least(before, behind), least(a, b));
            high[plane][block] = most(most(before, behind), most(a, b));
            before = behind;
        }
    };
    for (int face = 0; face <= kCellBlocks; ++face)
        reduce(face,
               [&](int point) { return halfway(slices[2 * face][point], slices[2 * face + 1][point]); });
    for (int z = 1; z + 1 < kCellSamples; ++z)
        reduce(kCellBlocks + z, [&](int point) { return slices[z][point]; });
    for (int k = 0; k < kCellBlocks; ++k) {
        const int a = kCellBlocks + 1 + 2 * k;
        for (int j = 0; j < kCellBlocks; ++j) {
            const int first = kCellBlocks * (j + kCellBlocks * k);
            overBlocks(least(least(low[k][j], low[k + 1][j]), least(low[a][j], low[a + 1][j])),
                       out.blockLow + first, [](Four x, Four y) { return x < y ? x : y; });
            overBlocks(most(most(high[k][j], high[k + 1][j]), most(high[a][j], high[a + 1][j])),
                       out.blockHigh + first, [](Four x, Four y) { return x > y ? x : y; });
        }
    }
}

} // namespace tessera::TESSERA_LANES
