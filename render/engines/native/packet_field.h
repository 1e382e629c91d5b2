// render/engines/native/packet_field.h: values and gradients of the field for all lanes of a packet: twin of
// render/contract/sampler.h where a brick needs no other; elsewhere values go to packet_points.h. For
// packet_*.cpp alone.
#pragma once

#include "render/contract/leaves.h"
#include "render/engines/native/lanes.h"
#include "render/engines/native/packet.h"
#include "render/engines/native/packet_points.h"

namespace tessera::TESSERA_LANES {

using native::PacketBrick;
using native::PacketField;
using native::PacketGradient;
using native::PacketHelp;
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

/// Takes the bricks that hold the cells of p.
template <bool Mixed> TESSERA_LANE void enter(const PacketField& f, Here<Mixed>& here, F3 p, M m) {
    I x, y, z;
    F perVoxel = here.perVoxel;
    if constexpr (Mixed) {
        const auto brick = [&](F at, int axis) {
            // As cells of level 0 lie: their bricks have aprons on the upper side.
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
        // Where bricks across two faces are coarser, the one across their edge has weight further in.
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
/// Lanes whose value needs no other brick. @param x  inBrick()
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

/// The rows along x that a cell's corners lie in, a sample longer at either end, by slice and row: what a
/// value and a central difference at one place share.
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

/// The value of lanes that need no other brick. @param x  inBrick()
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

/// Where a lane's cell needs other bricks too. Lanes that lack a brick are taken from m.
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
/// @param x  inBrick()  @param inside  lanes that need no other brick  @param rows  as valueHere()
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

/// The values that differences are made of: at sides of p as side() numbers them.
struct Sides {
    F value[6];
    M known[6];
};

/// Central differences' values of lanes whose own cell lies in their brick: all that lie there too, from one
/// neighbourhood of 4^3 samples. Where rounding says otherwise, or a value is another brick's, it is not
/// known. @param rows  null, or those of the lanes' cells
template <SampleKind K, bool Mixed>
TESSERA_LANE void centralHere(const PacketField& f, const Here<Mixed>& here, F3 p, F3 x, F h, M m, Sides& to,
                              const LongRows* rows) {
    using leaf::mix;
    const F one(1.0f);
    const F3 cell{floor(x.x), floor(x.y), floor(x.z)};
    const F3 part = x - cell;
    const F3 ahead = inBrick(here, F3{p.x + h, p.y + h, p.z + h});
    const F3 behind = inBrick(here, F3{p.x - h, p.y - h, p.z - h});
    const F3 up{floor(ahead.x), floor(ahead.y), floor(ahead.z)};
    const F3 down{floor(behind.x), floor(behind.y), floor(behind.z)};
    to.known[0] = m & (up.x == cell.x + one) & (ahead.x < here.high.x);
    to.known[1] = m & (down.x == cell.x - one) & (here.low.x <= behind.x);
    to.known[2] = m & (up.y == cell.y + one) & (ahead.y < here.high.y);
    to.known[3] = m & (down.y == cell.y - one) & (here.low.y <= behind.y);
    to.known[4] = m & (up.z == cell.z + one) & (ahead.z < here.high.z);
    to.known[5] = m & (down.z == cell.z - one) & (here.low.z <= behind.z);
    if constexpr (Mixed) {
        const Inner at = innerOf(here, x), above = innerOf(here, ahead), below = innerOf(here, behind);
        to.known[0] = to.known[0] & Inner{above.x, at.y, at.z}.enough();
        to.known[1] = to.known[1] & Inner{below.x, at.y, at.z}.enough();
        to.known[2] = to.known[2] & Inner{at.x, above.y, at.z}.enough();
        to.known[3] = to.known[3] & Inner{at.x, below.y, at.z}.enough();
        to.known[4] = to.known[4] & Inner{at.x, at.y, above.z}.enough();
        to.known[5] = to.known[5] & Inner{at.x, at.y, below.z}.enough();
    }
    const F3 partUp = ahead - up, partDown = behind - down;
    const I row = truncated(here.row), slice = truncated(here.slice);
    const I index = indexOf(here, cell);
    const auto [r00, r01, r10, r11] = rows ? *rows : longRows<K>(f, here, index - I(1), m);
    to.value[0] = mix(mix(mix(r00.c, r00.d, partUp.x), mix(r01.c, r01.d, partUp.x), part.y),
                      mix(mix(r10.c, r10.d, partUp.x), mix(r11.c, r11.d, partUp.x), part.y), part.z);
    to.value[1] = mix(mix(mix(r00.a, r00.b, partDown.x), mix(r01.a, r01.b, partDown.x), part.y),
                      mix(mix(r10.a, r10.b, partDown.x), mix(r11.a, r11.b, partDown.x), part.y), part.z);
    const F c00 = mix(r00.b, r00.c, part.x), c01 = mix(r01.b, r01.c, part.x);
    const F c10 = mix(r10.b, r10.c, part.x), c11 = mix(r11.b, r11.c, part.x);
    const auto along = [&](I at) {
        const Row2 r = row2<K>(f.samples, at, m);
        return mix(r.a, r.b, part.x);
    };
    const I row2nd = row + row, slice2nd = slice + slice;
    const F y0 = along(index - row), y1 = along(index + (slice - row));
    const F y2 = along(index + row2nd), y3 = along(index + (slice + row2nd));
    to.value[2] = mix(mix(c01, y2, partUp.y), mix(c11, y3, partUp.y), part.z);
    to.value[3] = mix(mix(y0, c00, partDown.y), mix(y1, c10, partDown.y), part.z);
    const F z0 = along(index - slice), z1 = along(index + (row - slice));
    const F z2 = along(index + slice2nd), z3 = along(index + (slice2nd + row));
    const F middle0 = mix(c00, c01, part.y), middle1 = mix(c10, c11, part.y);
    to.value[4] = mix(middle1, mix(z2, z3, part.y), partUp.z);
    to.value[5] = mix(mix(z0, z1, part.y), middle0, partDown.z);
}

/// Sobel's operator from the values at 27 sides, x fastest.
template <typename Value> TESSERA_LANE F3 sobel(const Value& value, F h) {
    const F now = value(13);
    F3 sum{F(0.0f), F(0.0f), F(0.0f)};
    for (int n = 0; n < 27; ++n) {
        const float side[3] = {static_cast<float>(n % 3 - 1), static_cast<float>(n / 3 % 3 - 1),
                               static_cast<float>(n / 9 - 1)};
        const float across[3] = {side[0] == 0 ? 2.0f : 1.0f, side[1] == 0 ? 2.0f : 1.0f,
                                 side[2] == 0 ? 2.0f : 1.0f};
        const F difference = value(n) - now; // exactly 0 where all are the same
        sum = {sum.x + F(side[0] * across[1] * across[2]) * difference,
               sum.y + F(side[1] * across[2] * across[0]) * difference,
               sum.z + F(side[2] * across[0] * across[1]) * difference};
    }
    const F all = F(32.0f) * h;
    return {sum.x / all, sum.y / all, sum.z / all};
}

/// Analytic gradients go one by one, by the scalar text. Lanes that lack a brick are taken from m.
inline __attribute__((noinline)) F3 slopeOf(const PacketHelp& help, F3 p, M& m) {
    alignas(64) float x[kWidth], y[kWidth], z[kWidth], gx[kWidth] = {}, gy[kWidth] = {}, gz[kWidth] = {};
    store(x, p.x), store(y, p.y), store(z, p.z);
    unsigned there = bits(m);
    for (unsigned left = there; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const float at[3] = {x[lane], y[lane], z[lane]};
        float g[3];
        bool missing = false;
        help.gradient(help.context, at, g, &missing);
        gx[lane] = g[0], gy[lane] = g[1], gz[lane] = g[2];
        if (missing)
            there &= ~(1u << lane);
    }
    m = fromBits(there);
    return {load(gx), load(gy), load(gz)};
}

/// Distance of samples at p, voxels, of lanes whose own cell needs other bricks than theirs.
template <bool Mixed> TESSERA_LANE F pitchElsewhere(const PacketField& f, F3 p, M m) {
    if constexpr (Mixed)
        return blendedPitch(f, p, m);
    else
        return F(1.0f) / samplesPerVoxel(I(f.level));
}

/// One of six sides, h ahead and behind along the axes.
TESSERA_LANE F3 side(int n, F3 p, F h) {
    const F by = n % 2 == 0 ? h : F(0.0f) - h; // p + -h is p - h
    return {n / 2 == 0 ? p.x + by : p.x, n / 2 == 1 ? p.y + by : p.y, n / 2 == 2 ? p.z + by : p.z};
}

/// The values that are not known, of lanes m; those that lack a brick are taken from m.
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) void valuesOfSides(const PacketField& f, F3 p, F h, Sides& sides, M& m) {
    Points points;
    const I lanes = laneNumbers();
    for (int n = 0; n < 6; ++n)
        points.add(side(n, p, h), lanes + I(n * kWidth), m & ~sides.known[n]);
    evaluate<K, Mixed>(f, points);
    alignas(64) float value[6][kWidth];
    for (int n = 0; n < 6; ++n)
        store(value[n], sides.value[n]);
    unsigned there = bits(m);
    for (int n = 0; n < points.count; ++n) {
        value[points.name[n] / kWidth][points.name[n] % kWidth] = points.value[n];
        if (points.lacks[n])
            there &= ~(1u << (points.name[n] % kWidth));
    }
    for (int n = 0; n < 6; ++n)
        sides.value[n] = load(value[n]);
    m = fromBits(there);
}

TESSERA_LANE F3 differencesOf(const Sides& s, F h) {
    const F both = F(2.0f) * h;
    return {(s.value[0] - s.value[1]) / both, (s.value[2] - s.value[3]) / both,
            (s.value[4] - s.value[5]) / both};
}

/// Differences of lanes whose neighbourhood needs other bricks; of the kinds but central and analytic.
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) F3 differencesElsewhere(const PacketField& f, PacketGradient kind, F3 p,
                                                         M& m) {
    const F half(0.5f);
    const F pitch = pitchElsewhere<Mixed>(f, p, m);
    if (kind == PacketGradient::centralHalf) {
        const F h = half * pitch;
        Sides sides;
        for (M& known : sides.known)
            known = none();
        for (F& value : sides.value)
            value = F(0.0f);
        valuesOfSides<K, Mixed>(f, p, h, sides, m);
        return differencesOf(sides, h);
    }
    const F h = kind == PacketGradient::forward ? half * pitch : min(pitch, F(16.0f));
    // All 27 sides of Sobel's; else here, and h ahead along the axes.
    const int values = kind == PacketGradient::sobel ? 27 : 4;
    Points points;
    const I lanes = laneNumbers();
    for (int n = 0; n < values; ++n) {
        F3 at;
        if (kind == PacketGradient::sobel)
            at = {p.x + h * F(static_cast<float>(n % 3 - 1)), p.y + h * F(static_cast<float>(n / 3 % 3 - 1)),
                  p.z + h * F(static_cast<float>(n / 9 - 1))};
        else
            at = {n == 1 ? p.x + h : p.x, n == 2 ? p.y + h : p.y, n == 3 ? p.z + h : p.z};
        points.add(at, lanes + I(n * kWidth), m);
    }
    evaluate<K, Mixed>(f, points);
    alignas(64) float value[27][kWidth] = {};
    unsigned there = bits(m);
    for (int n = 0; n < points.count; ++n) {
        value[points.name[n] / kWidth][points.name[n] % kWidth] = points.value[n];
        if (points.lacks[n])
            there &= ~(1u << (points.name[n] % kWidth));
    }
    m = fromBits(there);
    const auto v = [&](int n) { return load(value[n]); };
    if (kind == PacketGradient::forward)
        return {(v(1) - v(0)) / h, (v(2) - v(0)) / h, (v(3) - v(0)) / h};
    return sobel([&](int n) { return v(n); }, h);
}

/// Of the kinds but analytic, of lanes whose neighbourhood lies in their brick.
template <SampleKind K, bool Mixed>
TESSERA_LANE F3 differencesHere(const PacketField& f, const Here<Mixed>& here, PacketGradient kind, F3 p,
                                F pitch, M m) {
    const auto value = [&](F3 at) { return valueHere<K>(f, here, inBrick(here, at), m); };
    if (kind == PacketGradient::forward) {
        const F h = F(0.5f) * pitch, now = value(p);
        return {(value({p.x + h, p.y, p.z}) - now) / h, (value({p.x, p.y + h, p.z}) - now) / h,
                (value({p.x, p.y, p.z + h}) - now) / h};
    }
    if (kind == PacketGradient::sobel) {
        return sobel(
            [&](int n) {
                return value({p.x + pitch * F(static_cast<float>(n % 3 - 1)),
                              p.y + pitch * F(static_cast<float>(n / 3 % 3 - 1)),
                              p.z + pitch * F(static_cast<float>(n / 9 - 1))});
            },
            pitch);
    }
    const F h = F(0.5f) * pitch, both = F(2.0f) * h; // central-half
    return {(value({p.x + h, p.y, p.z}) - value({p.x - h, p.y, p.z})) / both,
            (value({p.x, p.y + h, p.z}) - value({p.x, p.y - h, p.z})) / both,
            (value({p.x, p.y, p.z + h}) - value({p.x, p.y, p.z - h})) / both};
}

/// The gradient at p. Lanes that lack a brick are taken from m.
/// @param rows  null, or what valueHere() took at p of lanes that were in the same bricks, all of m among
/// them
template <SampleKind K, bool Mixed>
TESSERA_LANE F3 gradientAt(const PacketField& f, const PacketHelp& help, const Here<Mixed>& here,
                           PacketGradient kind, F3 p, M& m, const LongRows* rows = nullptr) {
    if (kind == PacketGradient::analytic)
        return slopeOf(help, p, m);
    const F3 x = inBrick(here, p);
    const F one(1.0f);
    F pitch = one / here.perVoxel; // at most 16: bricks of one sample have no box
    if (kind == PacketGradient::central) {
        const M own = m & isHere(here, x);
        Sides sides;
        centralHere<K>(f, here, p, x, pitch, own, sides, rows);
        M known = own;
        for (const M& side : sides.known)
            known = known & side;
        M rest = m & ~known;
        if (any(rest)) [[unlikely]] {
            const M other = m & ~own;
            if (any(other))
                pitch = select(other, min(pitchElsewhere<Mixed>(f, p, other), F(16.0f)), pitch);
            valuesOfSides<K, Mixed>(f, p, pitch, sides, rest);
            m = known | rest;
        }
        return differencesOf(sides, pitch);
    }
    const F3 ones{one, one, one};
    M inside = m & within(x, here.low + ones, here.high - ones);
    if constexpr (Mixed)
        inside = inside & within(x, here.innerLow + ones, here.innerHigh - ones);
    F3 g = differencesHere<K>(f, here, kind, p, pitch, inside);
    M rest = m & ~inside;
    if (any(rest)) [[unlikely]] {
        g = select(rest, differencesElsewhere<K, Mixed>(f, kind, p, rest), g);
        m = inside | rest;
    }
    return g;
}

} // namespace tessera::TESSERA_LANES
