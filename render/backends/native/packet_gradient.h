// render/backends/native/packet_gradient.h: gradients of the field for all lanes of a packet, by differences
// of its values, as render/contract/sampler.h has them. Analytic ones are left to the scalar
// text. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_field.h"

namespace tessera::TESSERA_LANES {

using native::PacketGradient;
using native::PacketHelp;

namespace single {
/// The values that differences are made of: at sides of p as side() numbers them.
struct Sides {
    F value[6];
    M known[6];
};

/// Values for central differences of lanes whose own cell lies in their brick: all that lie there too, from
/// one neighbourhood of 4^3 samples. If rounding says otherwise, or a value is another brick's, it is not
/// known.
/// @param rows  null, or those of the lanes' cells
template <SampleKind K, bool Mixed>
TESSERA_LANE void centralHere(const PacketField& f, const Here<Mixed>& here, F3 p, F3 x, F h, M m, Sides& to,
                              const LongRows* rows) {
    using leaf::partWay;
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
    const I index = indexOf(here, cell);
    const auto [r00, r01, r10, r11] = (rows ? *rows : longRows<K>(f, here, index - I(1), m)).row;
    to.value[0] =
        leaf::trilinear(r00.c, r00.d, r01.c, r01.d, r10.c, r10.d, r11.c, r11.d, partUp.x, part.y, part.z);
    to.value[1] =
        leaf::trilinear(r00.a, r00.b, r01.a, r01.b, r10.a, r10.b, r11.a, r11.b, partDown.x, part.y, part.z);
    const F c00 = partWay(r00.b, r00.c, part.x), c01 = partWay(r01.b, r01.c, part.x);
    const F c10 = partWay(r10.b, r10.c, part.x), c11 = partWay(r11.b, r11.c, part.x);
    const auto along = [&](const RowPlaces& places, F(&value)[4]) {
        Row2 r[4];
        rows2<K>(f, here, index, places, m, r);
        for (int n = 0; n < 4; ++n)
            value[n] = partWay(r[n].a, r[n].b, part.x);
    };
    F y[4], z[4];
    along(kBesideAlongY, y);
    to.value[2] = partWay(partWay(c01, y[2], partUp.y), partWay(c11, y[3], partUp.y), part.z);
    to.value[3] = partWay(partWay(y[0], c00, partDown.y), partWay(y[1], c10, partDown.y), part.z);
    along(kBesideAlongZ, z);
    const F middle0 = partWay(c00, c01, part.y), middle1 = partWay(c10, c11, part.y);
    to.value[4] = partWay(middle1, partWay(z[2], z[3], part.y), partUp.z);
    to.value[5] = partWay(partWay(z[0], z[1], part.y), middle0, partDown.z);
}
} // namespace single

struct Sides {
    F value[6];
    M known[6];
};
template <SampleKind K, bool Mixed>
TESSERA_LANE void centralHere(const PacketField& f, const Here<Mixed>& here, F3 p, F3 x, F h, M m, Sides& to,
                              const LongRows* rows) {
    single::Sides a, b;
    single::centralHere<K>(f, lowerHalf(here), lowerHalf(p), lowerHalf(x), h.a, m.a, a,
                           rows ? &rows->a : nullptr);
    for (int n = 0; n < 6; ++n)
        to.value[n].a = a.value[n], to.known[n].a = a.known[n];
    single::centralHere<K>(f, upperHalf(here), upperHalf(p), upperHalf(x), h.b, m.b, b,
                           rows ? &rows->b : nullptr);
    for (int n = 0; n < 6; ++n)
        to.value[n].b = b.value[n], to.known[n].b = b.known[n];
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

/// Gradients one by one, by the scalar text. Lanes that lack a brick are taken from m.
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

/// Differences of lanes whose neighbourhood needs other bricks; of the kinds but central, cubic and analytic.
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

/// Of the kinds but central, cubic and analytic, of lanes whose neighbourhood lies in their brick.
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

/// Of the kinds but central, cubic and analytic. Lanes that lack a brick are taken from m. One text for every
/// loop that asks: 27 values of Sobel's in each are minutes of the compiler.
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) F3 otherDifferences(const PacketField& f, const Here<Mixed>& here,
                                                     PacketGradient kind, const F3& p, M& m) {
    const F one(1.0f);
    const F3 ones{one, one, one}, x = inBrick(here, p);
    M inside = m & within(x, here.low + ones, here.high - ones);
    if constexpr (Mixed)
        inside = inside & within(x, here.innerLow + ones, here.innerHigh - ones);
    F3 g = differencesHere<K>(f, here, kind, p, one / here.perVoxel, inside);
    M rest = m & ~inside;
    if (any(rest)) [[unlikely]] {
        g = select(rest, differencesElsewhere<K, Mixed>(f, kind, p, rest), g);
        m = inside | rest;
    }
    return g;
}

/// Cubic gradients: of lanes whose 4^3 samples are all of their brick or its ghost layer. Others go one by
/// one.
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) F3 cubicAt(const PacketField& f, const PacketHelp& help,
                                            const Here<Mixed>& here, const F3& p, M& m) {
    const F one(1.0f), two(2.0f);
    const F3 x = inBrick(here, p);
    const F3 cell{floor(x.x), floor(x.y), floor(x.z)}, part = x - cell;
    const F3 first = cell - F3{one, one, one}, last = cell + F3{two, two, two};
    const auto between = [&](const F3& low, const F3& high) {
        return (low.x <= first.x) & (low.y <= first.y) & (low.z <= first.z) & (last.x <= high.x) &
               (last.y <= high.y) & (last.z <= high.z);
    };
    M inside = m & between(here.low, here.high);
    if constexpr (Mixed)
        inside = inside & between(here.innerLow, here.innerHigh);
    const I row = truncated(here.row), slice = truncated(here.slice), index = indexOf(here, first);
    I ofSlice = index, ofRow = index;
    F3 g = leaf::cubicGradient<F, F3>(part.x, part.y, part.z, [&](int y, int, F(&r)[4]) {
        const Row4 four = row4<K>(f.samples, ofRow, inside);
        r[0] = four.a, r[1] = four.b, r[2] = four.c, r[3] = four.d;
        ofRow = ofRow + row;
        if (y == 3)
            ofSlice = ofSlice + slice, ofRow = ofSlice;
    });
    g = {g.x * here.perVoxel, g.y * here.perVoxel, g.z * here.perVoxel};
    M rest = m & ~inside;
    if (any(rest)) [[unlikely]] {
        g = select(rest, slopeOf(help, p, rest), g);
        m = inside | rest;
    }
    return g;
}

/// The gradient at p. Lanes that lack a brick are taken from m.
/// @param rows  null, or the samples that valueHere() took at p of lanes that were in the same bricks, all of
///     m among them
template <SampleKind K, bool Mixed>
TESSERA_LANE F3 gradientAt(const PacketField& f, const PacketHelp& help, const Here<Mixed>& here,
                           PacketGradient kind, F3 p, M& m, const LongRows* rows = nullptr) {
    if (kind == PacketGradient::analytic)
        return slopeOf(help, p, m);
    if (kind == PacketGradient::cubic)
        return cubicAt<K>(f, help, here, p, m);
    if (kind != PacketGradient::central)
        return otherDifferences<K>(f, here, kind, p, m);
    const F3 x = inBrick(here, p);
    F pitch = F(1.0f) / here.perVoxel; // at most 16: bricks of one sample have no box
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
        return differencesOf(sides, pitch);
    }
    const F perBoth = F(0.5f) * here.perVoxel; // a power of two: as to divide by two pitches
    return {perBoth * (sides.value[0] - sides.value[1]), perBoth * (sides.value[2] - sides.value[3]),
            perBoth * (sides.value[4] - sides.value[5])};
}

} // namespace tessera::TESSERA_LANES
