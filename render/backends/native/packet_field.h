// render/backends/native/packet_field.h: values of the field for all lanes of a packet: as
// render/contract/sampler.h has them where a brick needs no other; elsewhere values go to packet_points.h.
// For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"
#include "render/backends/native/packet_points.h"
#include "render/contract/leaves.h"

#include <type_traits>

namespace tessera::TESSERA_LANES {

using native::PacketBrick;
using native::PacketField;
using native::SampleKind;

/// Calls action(Samples<K>()) with the kind of a field's samples.
template <SampleKind K> struct Samples { static constexpr SampleKind kind = K; };
template <typename Action> TESSERA_LANE auto withSamples(const PacketField& f, const Action& action) {
    switch (f.kind) {
    case SampleKind::i16:
        return action(Samples<SampleKind::i16>());
    case SampleKind::u16:
        return action(Samples<SampleKind::u16>());
    case SampleKind::f32:
        break;
    }
    return action(Samples<SampleKind::f32>());
}

#include "render/backends/native/packet_cell.h"

namespace single {
#include "render/backends/native/packet_cell.h"
} // namespace single

template <bool Mixed> TESSERA_LANE single::Here<Mixed> lowerHalf(const Here<Mixed>& here) {
    return {lowerHalf(here.origin),
            lowerHalf(here.low),
            lowerHalf(here.high),
            lowerHalf(here.innerLow),
            lowerHalf(here.innerHigh),
            here.base.a,
            here.perVoxel.a,
            here.row.a,
            here.slice.a};
}
template <bool Mixed> TESSERA_LANE single::Here<Mixed> upperHalf(const Here<Mixed>& here) {
    return {upperHalf(here.origin),
            upperHalf(here.low),
            upperHalf(here.high),
            upperHalf(here.innerLow),
            upperHalf(here.innerHigh),
            here.base.b,
            here.perVoxel.b,
            here.row.b,
            here.slice.b};
}

/// Rows of the first register's lanes and of the second's. Who keeps them so takes samples and gradients of
/// one register after the other.
struct RowsApart {
    single::LongRows a, b;
};
template <SampleKind K, bool Mixed>
TESSERA_LANE F valueHere(const PacketField& f, const Here<Mixed>& here, F3 x, M m, RowsApart* rows) {
    const single::F a =
        single::valueHere<K>(f, lowerHalf(here), lowerHalf(x), m.a, rows ? &rows->a : nullptr);
    const single::F b =
        single::valueHere<K>(f, upperHalf(here), upperHalf(x), m.b, rows ? &rows->b : nullptr);
    return {a, b};
}
/// A gradient takes more numbers than sixteen registers hold for one register of lanes.
using PacketRows = std::conditional_t < kRegisters<32, RowsApart, LongRows>;
constexpr PacketRows* kNoRows = nullptr;

TESSERA_LANE F powerOfTwo(F n) {
    return asFloat(shl<23>(truncated(n) + I(127)));
}

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
                       PacketRows* rows = kNoRows) {
    F value = valueHere<K>(f, here, x, inside, rows);
    M rest = m & ~inside;
    if (any(rest)) [[unlikely]] {
        value = select(rest, valueElsewhere<K, Mixed>(f, p, rest), value);
        m = inside | rest;
    }
    return value;
}

} // namespace tessera::TESSERA_LANES
