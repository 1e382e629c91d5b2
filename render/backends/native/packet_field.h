// render/backends/native/packet_field.h: values of the field for all lanes of a packet: as
// render/contract/sampler.h has them where a brick needs no other; elsewhere values go to packet_points.h.
// For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"
#include "render/backends/native/packet_points.h"
#include "render/contract/leaves.h"

namespace tessera::TESSERA_LANES {

using native::PacketBrick;
using native::PacketField;
using native::SampleKind;

TESSERA_LANE F powerOfTwo(F n) {
    return asFloat(shl<23>(truncated(n) + I(127)));
}

/// Four samples beside one another.
struct Row4 {
    F a, b, c, d;
};
template <SampleKind K> TESSERA_LANE Row4 row4(const void* samples, I index, M m) {
    if constexpr (K == SampleKind::f32) {
        const Row2 low = row2<K>(samples, index, m), high = row2<K>(samples, index + I(2), m);
        return {low.a, low.b, high.a, high.b};
    } else {
        const Pair four = gatherPair<2>(samples, index, m);
        if constexpr (K == SampleKind::i16)
            return {number(sar<16>(shl<16>(four.low))), number(sar<16>(four.low)),
                    number(sar<16>(shl<16>(four.high))), number(sar<16>(four.high))};
        else
            return {number(four.low & I(0xffff)), number(shr<16>(four.low)), number(four.high & I(0xffff)),
                    number(shr<16>(four.high))};
    }
}

/// The brick that each lane is in; none at first.
template <bool Mixed> struct Here {
    static constexpr float kNowhere = Mixed ? 1e9f : 0.0f;
    F3 origin{F(kNowhere), F(kNowhere), F(kNowhere)}; // lattice coordinates of its first sample
    F3 low{F(1), F(1), F(1)}, high{F(0), F(0), F(0)}; // between them it needs no other brick; from origin on
    /// Mixed levels: beyond these, along two axes or three, it does, all the same.
    F3 innerLow{F(1), F(1), F(1)}, innerHigh{F(0), F(0), F(0)};
    I base{0};
    F perVoxel{1};      // samples
    F row{0}, slice{0}; // pitches
};

TESSERA_LANE F byteOf(I word, int shift) {
    return number((shr(word, I(shift)) & I(255)) - I(8));
}

/// Takes the bricks that hold the cells of p. Lanes that are not of m read an entry too: whatever their
/// places are, they become bricks of the grid.
template <bool Mixed> TESSERA_LANE void enter(const PacketField& f, Here<Mixed>& here, F3 p, M m) {
    I x, y, z;
    F perVoxel = here.perVoxel;
    if constexpr (Mixed) {
        const auto brick = [&](F at, int axis) {
            // As cells of level 0 lie: their bricks have ghost layers on the upper side.
            const F inside = min(max(at - F(0.5f), F(0.0f)), F(static_cast<float>(f.extentVoxels[axis])));
            return min(max(sar<5>(truncated(inside)), I(0)), I(f.grid[axis] - 1));
        };
        x = brick(p.x, 0), y = brick(p.y, 1), z = brick(p.z, 2);
    } else {
        const auto brick = [&](F at, int axis) {
            const F cell = at * perVoxel - F(0.5f);
            const F inside = min(max(cell, F(0.0f)), F(static_cast<float>(f.last[axis])));
            return max(sar(truncated(inside), I(5 - f.level)), I(0));
        };
        x = brick(p.x, 0), y = brick(p.y, 1), z = brick(p.z, 2);
    }
    const I number_ = (z * I(f.grid[1]) + y) * I(f.grid[0]) + x;
    static_assert(sizeof(PacketBrick) == 16 && offsetof(PacketBrick, low) == 4 &&
                  offsetof(PacketBrick, high) == 8);
    F entry[4]; // the words of a PacketBrick
    rows4(reinterpret_cast<const float*>(f.bricks), shl<2>(number_), entry);
    const I low = asInt(entry[1]), high = asInt(entry[2]);
    here.base = select(m, asInt(entry[0]), here.base);
    const F3 lowCell{byteOf(low, 0), byteOf(low, 8), byteOf(low, 16)};
    const F3 highCell{byteOf(high, 0), byteOf(high, 8), byteOf(high, 16)};
    here.low = select(m, lowCell, here.low);
    here.high = select(m, highCell, here.high);
    F3 first;
    if constexpr (Mixed) {
        const I level = min(shr<24>(low), I(4));
        perVoxel = asFloat(shl<23>(I(127) - level));
        const I shift = I(5) - level;
        first = {number(shl(x, shift)), number(shl(y, shift)), number(shl(z, shift))};
        here.perVoxel = select(m, perVoxel, here.perVoxel);
        const I row = rowPitch(f, level);
        here.row = select(m, number(row), here.row);
        here.slice = select(m, number(row * row), here.slice);
        // If bricks across two faces are coarser, the one across their edge has weight further in.
        const I facts = gather<4>(f.facts, number_, m);
        const F behind = F(32.0f) * perVoxel - F(0.5f);
        const auto inner = [&](int face, F outer) {
            const I code = shr(facts, I(3 + 3 * face)) & I(7);
            const F reach = halfSample(code) * perVoxel;
            return select((code > level) & (code < I(6)), face < 3 ? reach - F(0.5f) : behind - reach, outer);
        };
        const F3 innerLow{inner(0, lowCell.x), inner(1, lowCell.y), inner(2, lowCell.z)};
        const F3 innerHigh{inner(3, highCell.x), inner(4, highCell.y), inner(5, highCell.z)};
        here.innerLow = select(m, innerLow, here.innerLow);
        here.innerHigh = select(m, innerHigh, here.innerHigh);
    } else {
        const int shift = 5 - f.level;
        first = {number(shl(x, I(shift))), number(shl(y, I(shift))), number(shl(z, I(shift)))};
    }
    const F half(0.5f);
    here.origin = select(m, F3{first.x + half, first.y + half, first.z + half}, here.origin);
}

TESSERA_LANE M within(F3 x, F3 low, F3 high) {
    return (low.x <= x.x) & (low.y <= x.y) & (low.z <= x.z) & (x.x < high.x) & (x.y < high.y) &
           (x.z < high.z);
}

/// Along which axes a lane is not beyond its brick's inner box.
struct Inner {
    M x, y, z;
    /// But for one of them at most: then, inside low and high, no other brick has weight.
    __attribute__((always_inline)) M enough() const { return (x & y) | (z & (x | y)); }
};
template <bool Mixed> TESSERA_LANE Inner innerOf(const Here<Mixed>& here, F3 x) {
    return {(here.innerLow.x <= x.x) & (x.x < here.innerHigh.x),
            (here.innerLow.y <= x.y) & (x.y < here.innerHigh.y),
            (here.innerLow.z <= x.z) & (x.z < here.innerHigh.z)};
}
/// Lanes whose value needs no other brick.
/// @param x  inBrick()
template <bool Mixed> TESSERA_LANE M isHere(const Here<Mixed>& here, F3 x) {
    const M inside = within(x, here.low, here.high);
    if constexpr (Mixed)
        return inside & innerOf(here, x).enough();
    else
        return inside;
}

/// Samples of the lattice from the brick's first one: exact, whatever p is (the numbers below the point are
/// those of p, or fewer).
template <bool Mixed> TESSERA_LANE F3 inBrick(const Here<Mixed>& here, F3 p) {
    return here.perVoxel * p - here.origin;
}

template <bool Mixed> TESSERA_LANE I indexOf(const Here<Mixed>& here, F3 cell) {
    return here.base + truncated((cell.z * here.slice + cell.y * here.row) + cell.x);
}

/// The rows along x that hold a cell's corners, a sample longer at either end, by slice and row. A value and
/// a central difference at one place share them.
struct LongRows {
    Row4 r00, r01, r10, r11;
};
/// @param left  index of the sample before the cell's first
template <SampleKind K, bool Mixed>
TESSERA_LANE LongRows longRows(const PacketField& f, const Here<Mixed>& here, I left, M m) {
    const I row = truncated(here.row), slice = truncated(here.slice);
    const void* const s = f.samples; // HostPlane::kAround: no row leaves the memory, whoever's samples it has
    return {row4<K>(s, left, m), row4<K>(s, left + row, m), row4<K>(s, left + slice, m),
            row4<K>(s, left + (slice + row), m)};
}

/// The value of lanes that need no other brick.
/// @param x  inBrick()
/// @param rows  null, or takes the rows of these lanes' cells; those of other lanes are 0
template <SampleKind K, bool Mixed>
TESSERA_LANE F valueHere(const PacketField& f, const Here<Mixed>& here, F3 x, M m, LongRows* rows = nullptr) {
    const F3 cell{floor(x.x), floor(x.y), floor(x.z)};
    const F3 part = x - cell;
    const I index = indexOf(here, cell);
    if (rows) {
        *rows = longRows<K>(f, here, index - I(1), m);
        const LongRows& r = *rows;
        return leaf::trilinear(r.r00.b, r.r00.c, r.r01.b, r.r01.c, r.r10.b, r.r10.c, r.r11.b, r.r11.c, part.x,
                               part.y, part.z);
    }
    const I row = truncated(here.row), slice = truncated(here.slice);
    const Row2 r00 = row2<K>(f.samples, index, m), r01 = row2<K>(f.samples, index + row, m);
    const Row2 r10 = row2<K>(f.samples, index + slice, m), r11 = row2<K>(f.samples, index + (slice + row), m);
    return leaf::trilinear(r00.a, r00.b, r01.a, r01.b, r10.a, r10.b, r11.a, r11.b, part.x, part.y, part.z);
}

TESSERA_LANE I laneNumbers() {
    return {single::lanesFrom(0), single::lanesFrom(single::kWidth)};
}

/// For lanes whose cell needs other bricks too. Lanes that lack a brick are taken from m.
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) F valueElsewhere(const PacketField& f, F3 p, M& m) {
    Points points;
    points.add(p, laneNumbers(), m);
    evaluate<K, Mixed>(f, points);
    alignas(64) float value[kWidth] = {};
    unsigned there = bits(m);
    for (int n = 0; n < points.count; ++n) {
        value[points.name[n]] = points.value[n];
        if (points.lacks[n])
            there &= ~(1u << points.name[n]);
    }
    m = fromBits(there);
    return load(value);
}

/// The field at p. Lanes that lack a brick are taken from m.
/// @param x  inBrick()
/// @param inside  lanes that need no other brick
/// @param rows  as valueHere()
template <SampleKind K, bool Mixed>
TESSERA_LANE F valueAt(const PacketField& f, const Here<Mixed>& here, F3 p, F3 x, M inside, M& m,
                       LongRows* rows = nullptr) {
    F value = valueHere<K>(f, here, x, inside, rows);
    M rest = m & ~inside;
    if (any(rest)) [[unlikely]] {
        value = select(rest, valueElsewhere<K, Mixed>(f, p, rest), value);
        m = inside | rest;
    }
    return value;
}

} // namespace tessera::TESSERA_LANES
