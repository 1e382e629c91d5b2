// render/backends/native/packet_points.h: values of the field at a list of points, which need other bricks
// than the ray's own: as fieldValue() and interblockValue() in render/contract/sampler.h. The points of
// one turn are few and unlike, so a lane is not a point. First the bricks that have weight at each point are
// found. Then a lane computes one brick's value, for all points together. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_blend.h"

namespace tessera::TESSERA_LANES {

/// Room for all values that Sobel's operator takes of a packet, and for a register beyond.
constexpr int kMostPoints = 27 * kWidth;

/// Points at which values are wanted, and the values.
struct Points {
    int count = 0;
    alignas(64) float x[kMostPoints + kWidth], y[kMostPoints + kWidth], z[kMostPoints + kWidth];
    alignas(64) std::int32_t name[kMostPoints + kWidth]; // as the caller likes
    alignas(64) float value[kMostPoints + kWidth];
    bool lacks[kMostPoints + kWidth]; // a brick that the value needs

    /// Those of lanes m, the first lane first.
    __attribute__((always_inline)) void add(F3 p, I names, M m) {
        addHalf(lowerHalf(p), names.a, m.a);
        addHalf(upperHalf(p), names.b, m.b);
    }

  private:
    __attribute__((always_inline)) void addHalf(single::F3 p, single::I names, single::M m) {
        single::store(x + count, single::compress(p.x, m));
        single::store(y + count, single::compress(p.y, m));
        single::store(z + count, single::compress(p.z, m));
        single::store(name + count, single::compress(names, m));
        count += single::count(m);
    }
};

namespace single {

/// Points that are done at once, and the bricks of all of them.
constexpr int kRun = 64, kMostShares = 8 * kRun + kWidth;

/// Bricks that have weight at points of a run.
struct Shares {
    int count = 0;
    alignas(64) std::int32_t point[kMostShares], x[kMostShares], y[kMostShares], z[kMostShares],
        code[kMostShares];
    alignas(64) float px[kMostShares], py[kMostShares], pz[kMostShares]; // place of the point
    alignas(64) float weight[kMostShares], value[kMostShares];

    __attribute__((always_inline)) void add(I points, F3 p, I bx, I by, I bz, I codes, F weights, M m) {
        store(point + count, compress(points, m));
        store(px + count, compress(p.x, m));
        store(py + count, compress(p.y, m));
        store(pz + count, compress(p.z, m));
        store(x + count, compress(bx, m));
        store(y + count, compress(by, m));
        store(z + count, compress(bz, m));
        store(code + count, compress(codes, m));
        store(weight + count, compress(weights, m));
        count += single::count(m);
    }
};

/// Values of cells of one level that lie in several bricks.
struct Straddling {
    int count = 0;
    alignas(64) std::int32_t point[kRun + kWidth], level[kRun + kWidth];
};

TESSERA_LANE M firstLanes(int n) {
    return fromBits(n >= kWidth ? (1u << kWidth) - 1u : (1u << n) - 1u);
}
TESSERA_LANE I lanesFrom(int first) {
    alignas(64) static constexpr std::int32_t numbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                             8, 9, 10, 11, 12, 13, 14, 15};
    static_assert(kWidth <= 16);
    return load(numbers) + I(first);
}

/// Of cells of one level the brick that holds them whole, else the lanes of `several`.
template <bool Mixed>
TESSERA_LANE void shareOfLattice(const PacketField& f, const Corner& c, F3 p, I level, I points, M m,
                                 Shares& shares, Straddling& straddling) {
    const M fine = m & (level < I(kCoarsestCode)); // else every sample is a brick
    const I used = select(fine, level, I(0)), shift = I(5) - used, round = shl(I(1), used) - I(1);
    const F perVoxel = samplesPerVoxel(used);
    M one = fine;
    const auto axis = [&](F at, int n) {
        const I last = sar(I(f.extentVoxels[n]) + round, used) - I(1);
        const CellAxis a = cellAxis(at, perVoxel, last, shift);
        one = one & (a.brick[0] == a.brick[1]);
        return a.brick[0];
    };
    const I x = axis(p.x, 0), y = axis(p.y, 1), z = axis(p.z, 2);
    I code = used;
    if constexpr (Mixed) { // it may be an empty one
        const I n = (x - c.x + I(1)) | shl<1>(y - c.y + I(1)) | shl<2>(z - c.z + I(1));
        code = codeOf(c, n);
    }
    shares.add(points, p, x, y, z, code, F(1.0f), one);
    const M several = m & ~one;
    store(straddling.point + straddling.count, compress(points, several));
    store(straddling.level + straddling.count, compress(level, several));
    straddling.count += count(several);
}

/// Of points from `first` on, as many as a run has at most.
template <SampleKind K, bool Mixed>
inline void valuesOfRun(const PacketField& f, Points& points, int first, int count_) {
    Shares shares;
    Straddling straddling;
    alignas(64) float sum[kRun + kWidth], weights[kRun + kWidth];
    for (int n = 0; n < count_; n += kWidth) {
        const M m = firstLanes(count_ - n);
        const F3 p{load(points.x + first + n), load(points.y + first + n), load(points.z + first + n)};
        const I numbers = lanesFrom(n);
        store(weights + n, F(0.0f));
        if constexpr (!Mixed) {
            store(sum + n, F(-0.0f)); // to which the one value is added as it is
            shareOfLattice<Mixed>(f, {}, p, I(f.level), numbers, m, shares, straddling);
        } else {
            const Corner c = cornerAt(f, p, m);
            const M agree = m & ((shr<12>(c.facts) & I(1)) == I(1));
            store(sum + n, select(agree, F(-0.0f), F(0.0f)));
            if (any(agree))
                shareOfLattice<Mixed>(f, c, p, shr<13>(c.facts) & I(7), numbers, agree, shares, straddling);
            const M mixes = m & ~agree;
            if (!any(mixes))
                continue;
            const I near = nearAxes(c);
            const NearBricks bricks = NearBricks::of(near);
            for (int brick = 0; brick < 8; ++brick) {
                M lanes = mixes;
                const I b = c.current ^ bricks.across(brick, lanes);
                if (!any(lanes))
                    break;
                const F weight = cornerWeight(f, c, b, near);
                shares.add(numbers, p, c.x - I(1) + (b & I(1)), c.y - I(1) + (shr<1>(b) & I(1)),
                           c.z - I(1) + shr<2>(b), codeOf(c, b), weight, lanes & (weight > F(0.0f)));
            }
        }
    }
    bool* const lacks = points.lacks + first;
    for (int n = 0; n < count_; ++n)
        lacks[n] = false;
    for (int n = 0; n < shares.count; n += kWidth) {
        const M asked = firstLanes(shares.count - n);
        M m = asked;
        const F3 p{load(shares.px + n), load(shares.py + n), load(shares.pz + n)};
        store(shares.value + n, brickValue<K, Mixed>(f, load(shares.x + n), load(shares.y + n),
                                                     load(shares.z + n), load(shares.code + n), p, m));
        for (unsigned lacking = bits(asked & ~m); lacking != 0; lacking &= lacking - 1)
            lacks[shares.point[n + __builtin_ctz(lacking)]] = true;
    }
    for (int n = 0; n < shares.count; ++n) { // of a point in the order of its bricks
        const int at = shares.point[n];
        sum[at] += shares.weight[n] * shares.value[n];
        weights[at] += shares.weight[n];
    }
    for (int n = 0; n < straddling.count; n += kWidth) {
        const M asked = firstLanes(straddling.count - n);
        M m = asked;
        const I at = load(straddling.point + n);
        const auto along = [&](const float* p) { return asFloat(gather<4>(p + first, at, asked)); };
        const F3 p{along(points.x), along(points.y), along(points.z)};
        alignas(64) float value[kWidth];
        store(value, latticeValue<K>(f, p, load(straddling.level + n), m));
        for (unsigned left = bits(asked); left != 0; left &= left - 1) {
            const int lane = __builtin_ctz(left), to = straddling.point[n + lane];
            sum[to] = value[lane];
            weights[to] = 1;
            lacks[to] = (bits(m) >> lane & 1u) == 0;
        }
    }
    for (int n = 0; n < count_; n += kWidth)
        store(points.value + first + n, load(sum + n) / load(weights + n));
}

} // namespace single

/// The field at all points.
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) void evaluate(const PacketField& f, Points& points) {
    for (int first = 0; first < points.count; first += single::kRun) {
        const int rest = points.count - first;
        single::valuesOfRun<K, Mixed>(f, points, first, rest < single::kRun ? rest : single::kRun);
    }
}

} // namespace tessera::TESSERA_LANES
