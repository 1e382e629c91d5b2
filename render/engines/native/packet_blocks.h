// render/engines/native/packet_blocks.h: the range of the field in every block of 2^3 voxels of a cell, rows
// of a cell side by side in lanes. The field is extreme at sample centres and at blocks' faces: 13 points an
// axis, five faces and eight samples. For packet_*.cpp alone.
#pragma once

#include "render/engines/native/lanes.h"
#include "render/engines/native/packet.h"

namespace tessera::TESSERA_LANES {

using native::CellRanges;
using native::CellSamples;

constexpr int kCellSamples = 10, kCellPoints = 13, kRowFloats = 16;
struct CellRow { // in registers one by one: a row fills sixteen lanes at most
    single::F v[kRowFloats / single::kWidth];
};
template <typename Take> TESSERA_LANE CellRow rowwise(const Take& take) {
    CellRow row;
    for (int n = 0; n < kRowFloats / single::kWidth; ++n)
        row.v[n] = take(n);
    return row;
}
TESSERA_LANE CellRow loadRow(const float* p) {
    return rowwise([&](int n) { return single::load(p + n * single::kWidth); });
}
TESSERA_LANE void storeRow(float* p, const CellRow& row) {
    for (int n = 0; n < kRowFloats / single::kWidth; ++n)
        single::store(p + n * single::kWidth, row.v[n]);
}
TESSERA_LANE CellRow halfway(const CellRow& a, const CellRow& b) {
    return rowwise([&](int n) { return single::F(0.5f) * (a.v[n] + b.v[n]); });
}
TESSERA_LANE CellRow least(const CellRow& a, const CellRow& b) {
    return rowwise([&](int n) { return min(a.v[n], b.v[n]); });
}
TESSERA_LANE CellRow most(const CellRow& a, const CellRow& b) {
    return rowwise([&](int n) { return max(a.v[n], b.v[n]); });
}

/// Ten rows, `pitch` apart, as thirteen.
TESSERA_LANE void pointsAcross(const CellRow* from, int pitch, CellRow (&to)[kCellPoints]) {
    for (int block = 0; block < 4; ++block) {
        to[3 * block] = halfway(from[2 * block * pitch], from[(2 * block + 1) * pitch]);
        to[3 * block + 1] = from[(2 * block + 1) * pitch];
        to[3 * block + 2] = from[(2 * block + 2) * pitch];
    }
    to[12] = halfway(from[8 * pitch], from[9 * pitch]);
}

inline void cellRanges(const CellSamples& samples, CellRanges& out) {
    // Along x: ten samples of a row become thirteen points.
    static thread_local CellRow alongX[kCellSamples * kCellSamples];
    alignas(64) float points[kRowFloats] = {};
    CellRow low = loadRow(samples.rows[0]), high = low;
    for (int r = 0; r < kCellSamples * kCellSamples; ++r) {
        const float* const s = samples.rows[r];
        const CellRow all = loadRow(s);
        low = least(low, all);
        high = most(high, all);
        for (int block = 0; block < 4; ++block) {
            points[3 * block] = 0.5f * (s[2 * block] + s[2 * block + 1]);
            points[3 * block + 1] = s[2 * block + 1];
            points[3 * block + 2] = s[2 * block + 2];
        }
        points[12] = 0.5f * (s[8] + s[9]);
        alongX[r] = loadRow(points);
    }
    alignas(64) float lows[kRowFloats], highs[kRowFloats];
    storeRow(lows, low);
    storeRow(highs, high);
    out.low = lows[0], out.high = highs[0];
    for (int x = 1; x < kCellSamples; ++x) {
        out.low = lows[x] < out.low ? lows[x] : out.low;
        out.high = highs[x] > out.high ? highs[x] : out.high;
    }
    static thread_local CellRow slices[kCellSamples][kCellPoints]; // points along x and y
    for (int z = 0; z < kCellSamples; ++z)
        pointsAcross(alongX + z * kCellSamples, 1, slices[z]);
    static thread_local CellRow lowest[kCellPoints][4],
        highest[kCellPoints][4]; // of points along z, blocks along y
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
    alignas(64) float lowLine[kRowFloats], highLine[kRowFloats];
    for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 4; ++j) {
            storeRow(lowLine, least(least(lowest[3 * k][j], lowest[3 * k + 1][j]),
                                    least(lowest[3 * k + 2][j], lowest[3 * k + 3][j])));
            storeRow(highLine, most(most(highest[3 * k][j], highest[3 * k + 1][j]),
                                    most(highest[3 * k + 2][j], highest[3 * k + 3][j])));
            for (int i = 0; i < 4; ++i) {
                float lowestHere = lowLine[3 * i], highestHere = highLine[3 * i];
                for (int n = 1; n < 4; ++n) {
                    lowestHere = lowLine[3 * i + n] < lowestHere ? lowLine[3 * i + n] : lowestHere;
                    highestHere = highLine[3 * i + n] > highestHere ? highLine[3 * i + n] : highestHere;
                }
                out.blockLow[i + 4 * j + 16 * k] = lowestHere;
                out.blockHigh[i + 4 * j + 16 * k] = highestHere;
            }
        }
}

} // namespace tessera::TESSERA_LANES
