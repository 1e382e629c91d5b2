// render/backends/native/packet_blend.h: bricks around a point, for one register of lanes: cells of one level
// across bricks, a brick's own samples, and the weights that blend bricks of unlike levels. As
// fieldValue() and interblockValue() in render/contract/sampler.h, whose sums packet_points.h makes. It also
// gives the strides that the levels around a point allow. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"
#include "render/contract/leaves.h"

namespace tessera::TESSERA_LANES {

using native::PacketBrick;
using native::PacketField;
using native::SampleKind;
#include "render/backends/native/packet_samples.h"

namespace single {
#include "render/backends/native/packet_samples.h"

using leaf::kEmptyCode, leaf::kOutsideCode;
constexpr int kCoarsestCode = 5, kNoReachCode = 15; // as BrickCorner's

template <SampleKind K> TESSERA_LANE F sampleAt(const void* samples, I index, M m) {
    if constexpr (K == SampleKind::f32)
        return asFloat(gather<4>(samples, index, m));
    else {
        const I pair = gather<2>(samples, index, m);
        return number(K == SampleKind::i16 ? sar<16>(shl<16>(pair)) : pair & I(0xffff));
    }
}

/// An entry of PacketField::bricks.
struct BrickEntries {
    I base, state;
};
TESSERA_LANE BrickEntries entriesOf(const PacketField& f, I brick, M m) {
    const Pair pair = gatherPair<4>(f.bricks, shl<2>(brick), m);
    return {pair.low, shr<24>(pair.high)};
}
TESSERA_LANE F meanOf(const PacketField& f, I brick, M m) {
    return asFloat(gather<4>(reinterpret_cast<const std::int32_t*>(f.bricks) + 3, shl<2>(brick), m));
}

/// The needs of a cell along one axis: brick and place in it, of its lower and its upper sample.
struct CellAxis {
    I brick[2], inside[2];
    F part;
};
TESSERA_LANE CellAxis cellAxis(F p, F perVoxel, I last, I shift) {
    const F at = min(max(p * perVoxel - F(0.5f), F(0.0f)), number(last));
    const I low = truncated(at), high = min(low + I(1), last); // not negative, so this is floor
    const I mask = shl(I(1), shift) - I(1);
    return {{sar(low, shift), sar(high, shift)}, {low & mask, high & mask}, at - number(low)};
}

/// Plain trilinear interpolation of one level's samples, whichever bricks have them; empty ones read as their
/// mean. Lanes that lack a brick are taken from m.
template <SampleKind K> TESSERA_LANE F latticeValue(const PacketField& f, F3 p, I level, M& m) {
    const F perVoxel = samplesPerVoxel(level);
    const I shift = I(5) - level, round = shl(I(1), level) - I(1);
    const auto last = [&](int axis) { return sar(I(f.extentVoxels[axis]) + round, level) - I(1); };
    const CellAxis x = cellAxis(p.x, perVoxel, last(0), shift), y = cellAxis(p.y, perVoxel, last(1), shift),
                   z = cellAxis(p.z, perVoxel, last(2), shift);
    const I row = rowPitch(f, level), slice = row * row;
    F v[8];
    for (int n = 0; n < 8; ++n) {
        const int i = n & 1, j = (n >> 1) & 1, k = n >> 2;
        const I brick = (z.brick[k] * I(f.grid[1]) + y.brick[j]) * I(f.grid[0]) + x.brick[i];
        const BrickEntries entry = entriesOf(f, brick, m);
        const M stored = m & (entry.state < I(static_cast<int>(PacketBrick::kValue)));
        v[n] = sampleAt<K>(f.samples, entry.base + z.inside[k] * slice + y.inside[j] * row + x.inside[i],
                           stored);
        const M value = m & (entry.state == I(static_cast<int>(PacketBrick::kValue)));
        if (any(value))
            v[n] = select(value, meanOf(f, brick, value), v[n]);
        m = stored | value;
    }
    return leaf::trilinear(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], x.part, y.part, z.part);
}

/// The eight bricks around the nearest brick corner.
struct Corner {
    I codes, facts;
    I x, y, z; // of the corner, in bricks
    F3 offset; // voxels from it
    I current; // number of the brick that the place lies in
};
TESSERA_LANE Corner cornerAt(const PacketField& f, F3 p, M m) {
    Corner c;
    const auto axis = [&](F at, int n, I& corner, F& offset) {
        const F inVolume = min(max(at, F(0.0f)), F(static_cast<float>(f.extentVoxels[n])));
        const I brick = min(sar<5>(truncated(inVolume)), I(f.grid[n] - 1));
        const F inside = at - number(shl<5>(brick));
        const M lower = inside < F(16.0f);
        corner = select(lower, brick, brick + I(1));
        offset = select(lower, inside, inside - F(32.0f));
        return select(lower, I(1 << n), I(0));
    };
    c.current = axis(p.x, 0, c.x, c.offset.x) | axis(p.y, 1, c.y, c.offset.y) | axis(p.z, 2, c.z, c.offset.z);
    const I index = (c.z * I(f.grid[1] + 1) + c.y) * I(f.grid[0] + 1) + c.x;
    const Pair pair = gatherPair<8>(f.corners, index, m);
    c.codes = pair.low, c.facts = pair.high;
    return c;
}
TESSERA_LANE I codeOf(const Corner& c, I brick) {
    return shr(c.codes, shl<2>(brick)) & I(15);
}
TESSERA_LANE F offsetAlong(const Corner& c, int axis) {
    return axis == 0 ? c.offset.x : axis == 1 ? c.offset.y : c.offset.z;
}

/// Axes, as bits, along which bricks of the other side have weight.
TESSERA_LANE I nearAxes(const Corner& c) {
    I near(0);
    for (int axis = 0; axis < 3; ++axis) {
        const I reach = shr(c.facts, I(4 * axis)) & I(15);
        const M isNear = (reach != I(kNoReachCode)) & (abs(offsetAlong(c, axis)) < halfSample(reach));
        near = near | select(isNear, I(1 << axis), I(0));
    }
    return near;
}

/// The bricks that have weight where bricks of `near` axes meet are numbered from the current one on: the
/// bits of n, lowest first, are those axes. Ascending numbers are ascending bricks, as the scalar text goes
/// through them.
struct NearBricks {
    I axis[3]; // the bit of the first near axis, of the second, of the third; 0 where there is none
    TESSERA_LANE NearBricks of(I near) {
        const I rest = near & (near - I(1)), last = rest & (rest - I(1));
        return {near ^ rest, rest ^ last, last};
    }
    /// Across which axes the n-th one lies; none in lanes that have fewer are taken from m.
    __attribute__((always_inline)) I across(int n, M& m) const {
        I all(0);
        for (int bit = 0; bit < 3; ++bit)
            if (n >> bit & 1) {
                all = all | axis[bit];
                m = m & (axis[bit] != I(0));
            }
        return all;
    }
};

TESSERA_LANE F edgeWeight(const PacketField& f, I own, I other, F into, M upper) {
    const I empty(kEmptyCode);
    const I level = leaf::edgeLevel(own, other, into >= F(0.0f), f.edgeFunction, I(f.finest));
    const F rising = leaf::edgeWeight(into, asFloat(shl<23>(I(128) - level)));
    if (f.edgeFunction != leaf::kNearestEdge)
        return rising;
    return select((own == empty) | (other == empty), rising, leaf::edgeStep(into, upper));
}

/// Weight of brick n of the corner, before normalisation.
TESSERA_LANE F cornerWeight(const PacketField& f, const Corner& c, I n, I near) {
    const I own = codeOf(c, n), outside(kOutsideCode);
    F weight(1.0f);
    for (int axis = 0; axis < 3; ++axis) {
        const I bit(1 << axis);
        const M isNear = (near & bit) != I(0);
        if (!any(isNear))
            continue;
        const I other = codeOf(c, n ^ bit);
        const M upper = (n & bit) != I(0);
        const M counts = isNear & (other != outside);
        const F offset = offsetAlong(c, axis);
        const F edge = edgeWeight(f, own, other, select(upper, offset, F(0.0f) - offset), upper);
        weight = select(counts, weight * edge, weight);
    }
    return select(own == outside, F(0.0f), weight);
}

/// A brick's own value: trilinear between its samples, clamped to them. Lanes that lack it are taken from m.
/// @param code  where levels are not mixed, the level of those that have samples
template <SampleKind K, bool Mixed>
TESSERA_LANE F brickValue(const PacketField& f, I x, I y, I z, I code, F3 p, M& m) {
    const I number_ = (z * I(f.grid[1]) + y) * I(f.grid[0]) + x;
    const I kept(static_cast<int>(PacketBrick::kValue));
    const BrickEntries entry = entriesOf(f, number_, m);
    const M isValue = m & (Mixed ? ~(code < I(kCoarsestCode)) : entry.state == kept);
    F value(0.0f);
    if (any(isValue))
        value = meanOf(f, number_, isValue);
    const M stored = m & ~isValue & (entry.state < kept);
    m = isValue | stored;
    const I level = select(stored, code, I(0)), shift = I(5) - level;
    const F perVoxel = samplesPerVoxel(level);
    const I edge = shl(I(1), shift), round = shl(I(1), level) - I(1);
    struct Axis {
        I low, high;
        F part;
    };
    const auto axis = [&](F at, I brick, int n) {
        const I first = shl(brick, shift);
        const I last = min(edge, sar(I(f.extentVoxels[n]) + round, level) - first) - I(1);
        const F inside = min(max(at * perVoxel - number(first) - F(0.5f), F(0.0f)), number(last));
        const I low = truncated(inside);
        return Axis{low, min(low + I(1), last), inside - number(low)};
    };
    const Axis ax = axis(p.x, x, 0), ay = axis(p.y, y, 1), az = axis(p.z, z, 2);
    const I row = rowPitch(f, level), slice = row * row;
    const I y0 = entry.base + ay.low * row, y1 = entry.base + ay.high * row;
    const I z0 = az.low * slice, z1 = az.high * slice;
    const M same = ax.low == ax.high; // the outermost sample: the one loaded beside it is another row's
    const auto pairAt = [&](I line, I plane) {
        const Row2 pair = row2<K>(f.samples, line + plane + ax.low, stored);
        return Row2{pair.a, select(same, pair.a, pair.b)};
    };
    const Row2 r00 = pairAt(y0, z0), r01 = pairAt(y1, z0), r10 = pairAt(y0, z1), r11 = pairAt(y1, z1);
    const F inside =
        leaf::trilinear(r00.a, r00.b, r01.a, r01.b, r10.a, r10.b, r11.a, r11.b, ax.part, ay.part, az.part);
    return select(stored, inside, value);
}

/// Distance of samples at p, voxels, with the weights of their values; empty bricks count as
/// the finest level.
TESSERA_LANE F blendedPitch(const PacketField& f, F3 p, M m) {
    const Corner c = cornerAt(f, p, m);
    const M agree = (shr<12>(c.facts) & I(1)) == I(1);
    const I near = select(agree, I(0), nearAxes(c));
    const NearBricks bricks = NearBricks::of(near);
    F sum(0.0f), weights(0.0f);
    for (int brick = 0; brick < 8; ++brick) {
        M lanes = m;
        const I n = c.current ^ bricks.across(brick, lanes);
        if (!any(lanes))
            break;
        const I code = codeOf(c, n);
        const F weight = cornerWeight(f, c, n, near);
        const F pitch = asFloat(shl<23>(I(127) + select(code == I(kEmptyCode), I(f.finest), code)));
        sum = select(lanes, sum + weight * pitch, sum);
        weights = select(lanes, weights + weight, weights);
    }
    return sum / weights;
}

/// Margin of a box of strides inside the places that have them, voxels: more than rounding.
constexpr float kStrideMargin = 1.0f / 64;

/// Strides that start in a box of places.
struct StrideBox {
    F3 low, high; // voxels
    I exponent;   // log2 of the segments of the largest stride, but for alignment
    I most;       // none that reaches into the box is above
};
/// Around a place: a brick of level 0; or of the part of a brick that is nearest to one corner, where the
/// same bricks are near.
TESSERA_LANE StrideBox strideBox(const PacketField& f, F3 p, M m) {
    const Corner c = cornerAt(f, p, m);
    const I current = codeOf(c, c.current);
    I k = min(current, I(f.mostStride)); // an empty brick counts as coarser than all
    StrideBox box;
    box.most = f.naive ? I(f.mostStride) : k; // a stride never reaches into a brick that is finer than itself
    const I finest = shr<16>(c.facts) & I(7);
    const M limited = f.naive ? none() : m & (k > finest);
    const F edge = select(current == I(0), F(32.0f), F(16.0f));
    const F reach = max(halfSample(min(current, I(5))), F(f.segmentVoxels) * number(shl(I(1), k)));
    I near(0);
    const auto along = [&](int axis, I corner, F offset, F& low, F& high) {
        const F far = abs(offset), at = number(shl<5>(corner));
        const M isNear = far < reach;
        near = near | select(isNear, I(1 << axis), I(0));
        const F from = select(limited & ~isNear, reach, F(0.0f)) + F(kStrideMargin);
        const F to = select(limited & isNear, min(reach, edge), edge) - F(kStrideMargin);
        const M below = offset < F(0.0f);
        low = select(below, at - to, at + from);
        high = select(below, at - from, at + to);
    };
    along(0, c.x, c.offset.x, box.low.x, box.high.x);
    along(1, c.y, c.offset.y, box.low.y, box.high.y);
    along(2, c.z, c.offset.z, box.low.z, box.high.z);
    const M all = limited & (near == I(7));
    k = select(all, finest, k);
    const M some = limited & ~all & ~(near == I(0));
    if (any(some))
        for (int other = 1; other < 8; ++other) {
            const M reaches = some & ((I(other) & ~near) == I(0));
            k = select(reaches, min(k, codeOf(c, c.current ^ I(other))), k);
        }
    box.exponent = k;
    return box;
}
TESSERA_LANE StrideBox noStrideBox() {
    const F one(1.0f), zero(0.0f);
    return {{one, one, one}, {zero, zero, zero}, I(0), I(0)};
}
TESSERA_LANE void updateStrideBox(const PacketField& f, StrideBox& box, F3 p, M m) {
    if (!any(m))
        return;
    const StrideBox now = strideBox(f, p, m);
    box.low = select(m, now.low, box.low);
    box.high = select(m, now.high, box.high);
    box.exponent = select(m, now.exponent, box.exponent);
    box.most = select(m, now.most, box.most);
}

/// Of the brick that p lies in.
TESSERA_LANE I codeAt(const PacketField& f, F3 p, M m) {
    const Corner c = cornerAt(f, p, m);
    return codeOf(c, c.current);
}

} // namespace single

TESSERA_LANE single::F3 lowerHalf(F3 p) {
    return {p.x.a, p.y.a, p.z.a};
}
TESSERA_LANE single::F3 upperHalf(F3 p) {
    return {p.x.b, p.y.b, p.z.b};
}
/// Of two registers, those that have lanes to search.
template <typename Result, typename Of> TESSERA_LANE Result halves(F3 p, M m, const Of& of) {
    Result result(0);
    if (single::any(m.a))
        result.a = of(lowerHalf(p), m.a);
    if (single::any(m.b))
        result.b = of(upperHalf(p), m.b);
    return result;
}
inline __attribute__((noinline)) F blendedPitch(const PacketField& f, F3 p, M m) {
    return halves<F>(p, m, [&](single::F3 q, single::M n) { return single::blendedPitch(f, q, n); });
}
TESSERA_LANE I strideExponent(const PacketField& f, F3 p, M m) {
    return halves<I>(p, m, [&](single::F3 q, single::M n) { return single::strideBox(f, q, n).exponent; });
}
TESSERA_LANE I codeAt(const PacketField& f, F3 p, M m) {
    return halves<I>(p, m, [&](single::F3 q, single::M n) { return single::codeAt(f, q, n); });
}

} // namespace tessera::TESSERA_LANES
