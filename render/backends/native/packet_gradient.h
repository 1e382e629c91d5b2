// render/backends/native/packet_gradient.h: gradients of the field for all lanes of a packet, by differences
// of its values, as render/contract/sampler.h has them. Analytic ones are left to the scalar
// text. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_field.h"

namespace tessera::TESSERA_LANES {

using native::PacketGradient;
using native::PacketHelp;

namespace single {
#include "render/backends/native/packet_sides.h"
}
#include "render/backends/native/packet_sides.h"

template <SampleKind K, bool Mixed>
TESSERA_LANE void centralHere(const PacketField& f, const Here<Mixed>& here, F3 p, F3 x, F h, M m, Sides& to,
                              const RowsApart* rows) {
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
/// @param reach  pitches, of Sobel's
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) F3 differencesElsewhere(const PacketField& f, PacketGradient kind, F3 p,
                                                         M& m, F reach) {
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
    const F h = kind == PacketGradient::forward ? half * pitch : min(reach * pitch, F(16.0f));
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
/// @param reach  pitches, of Sobel's
template <SampleKind K, bool Mixed>
TESSERA_LANE F3 differencesHere(const PacketField& f, const Here<Mixed>& here, PacketGradient kind, F3 p,
                                F pitch, M m, F reach) {
    const auto value = [&](F3 at) { return valueHere<K>(f, here, inBrick(here, at), m, kNoRows); };
    if (kind == PacketGradient::forward) {
        const F h = F(0.5f) * pitch, now = value(p);
        return {(value({p.x + h, p.y, p.z}) - now) / h, (value({p.x, p.y + h, p.z}) - now) / h,
                (value({p.x, p.y, p.z + h}) - now) / h};
    }
    if (kind == PacketGradient::sobel) {
        const F apart = min(reach * pitch, F(16.0f));
        return sobel(
            [&](int n) {
                return value({p.x + apart * F(static_cast<float>(n % 3 - 1)),
                              p.y + apart * F(static_cast<float>(n / 3 % 3 - 1)),
                              p.z + apart * F(static_cast<float>(n / 9 - 1))});
            },
            apart);
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
                                                     PacketGradient kind, const F3& p, M& m, float pitches) {
    const F reach(pitches);
    const F3 around{reach, reach, reach}, x = inBrick(here, p);
    M inside = m & within(x, here.low + around, here.high - around);
    if constexpr (Mixed)
        inside = inside & within(x, here.innerLow + around, here.innerHigh - around);
    F3 g = differencesHere<K>(f, here, kind, p, F(1.0f) / here.perVoxel, inside, reach);
    M rest = m & ~inside;
    if (any(rest)) [[unlikely]] {
        g = select(rest, differencesElsewhere<K, Mixed>(f, kind, p, rest, reach), g);
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
                           PacketGradient kind, F3 p, M& m, const PacketRows* rows = kNoRows) {
    if (kind == PacketGradient::analytic)
        return slopeOf(help, p, m);
    if (kind == PacketGradient::cubic)
        return cubicAt<K>(f, help, here, p, m);
    if (kind != PacketGradient::central)
        return otherDifferences<K>(f, here, kind, p, m, 1.0f);
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
    }
    return differencesOf(sides, pitch);
}

} // namespace tessera::TESSERA_LANES
