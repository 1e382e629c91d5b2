// render/backends/native/packet_space.h: leaps over proven empty space: the same as nextOccupied() and
// nextShown() in render/empty_space/occupancy.h, for all lanes of a packet. Leaps differ from theirs by
// rounding; the strides that are taken do not. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"

namespace tessera::TESSERA_LANES {

using native::PacketEmptySpace;
using native::PacketField;
using native::PacketJob;

/// Margin of a leap inside its box, voxels (kLeapMargin of occupancy.h).
constexpr float kMargin = 1.0f / 64;
/// A ray whose step is below this along an axis counts as running along the boxes there.
constexpr float kLeastStep = 1e-18f;

/// The data of a packet's rays that leaps need.
struct LeapingRays {
    F3 perStep;   // 1 / step; 0 along the boxes
    F3 toLeave;   // from a box's side to where a leap ends, less the entry
    I ascends[3]; // 1 where it does
    I octantBit;  // of its byte in a word of an empty box's texel
    M upperWord;
};

TESSERA_LANE LeapingRays leapingRays(F3 entry, F3 step) {
    LeapingRays rays;
    const auto axis = [&](F at, F along, F& perStep, F& toLeave, I& ascends) {
        const M up = along > F(0.0f);
        perStep = select(abs(along) > F(kLeastStep), F(1.0f) / along, F(0.0f));
        toLeave = select(up, F(-kMargin), F(kMargin)) - at;
        ascends = select(up, I(1), I(0));
    };
    axis(entry.x, step.x, rays.perStep.x, rays.toLeave.x, rays.ascends[0]);
    axis(entry.y, step.y, rays.perStep.y, rays.toLeave.y, rays.ascends[1]);
    axis(entry.z, step.z, rays.perStep.z, rays.toLeave.z, rays.ascends[2]);
    rays.octantBit = shl<3>(rays.ascends[0] | shl<1>(rays.ascends[1]));
    rays.upperWord = rays.ascends[2] == I(1);
    return rays;
}

/// The box of the map around a place.
struct BoxAt {
    I voxel[3];
    Pair texel;
    M isOccupied; // its box: then of some blocks
    M shows;      // its block
};

/// Tests cells that no ray got to before.
inline __attribute__((noinline)) void lookAt(const PacketEmptySpace& space, const I& numbers, M m) {
    alignas(64) std::int32_t number[kWidth];
    store(number, numbers);
    const auto lanes = bits(m);
    for (int lane = 0; lane < kWidth; ++lane)
        if (lanes >> lane & 1u)
            space.look(space.finer, number[lane]);
}

/// Texels of boxes, by their places in the map.
TESSERA_LANE Pair texelsAt(const PacketEmptySpace& space, I number, M m) {
    Pair texel = gatherPair<8>(space.map, number, m);
    if (space.finer) {
        const M unknown = m & ((texel.low | texel.high) == I(0));
        if (any(unknown)) [[unlikely]] {
            lookAt(space, number, unknown);
            texel = gatherPair<8>(space.map, number, m);
        }
    }
    return texel;
}

/// Of an occupied box.
TESSERA_LANE M blockShows(const Pair& texel, I x, I y, I z) {
    const I bit = min(x | shl<2>(y) | shl<4>(z), I(62));
    const I word = select(bit < I(32), texel.low, texel.high);
    return (shr(word, bit & I(31)) & I(1)) == I(1);
}

TESSERA_LANE BoxAt boxAt(const PacketEmptySpace& space, const PacketField& f, F3 p, M m) {
    BoxAt box;
    const auto voxel = [&](F at, int axis) { return min(max(truncated(at), I(0)), I(f.lastVoxel[axis])); };
    box.voxel[0] = voxel(p.x, 0), box.voxel[1] = voxel(p.y, 1), box.voxel[2] = voxel(p.z, 2);
    const I shift(space.shift), blockShift(space.shift - 2);
    const I index =
        (sar(box.voxel[2], shift) * I(space.grid[1]) + sar(box.voxel[1], shift)) * I(space.grid[0]) +
        sar(box.voxel[0], shift);
    box.texel = texelsAt(space, index, m);
    box.isOccupied = box.texel.high < I(0);
    const auto block = [&](int axis) { return sar(box.voxel[axis], blockShift) & I(3); };
    box.shows = m & box.isOccupied & blockShows(box.texel, block(0), block(1), block(2));
    return box;
}

/// The extent of empty space around a place: of an empty box as far as a ray may leap, of a block itself.
struct EmptyReach {
    I boxes, shift; // along each axis; log2 of a box's edge, voxels
};
TESSERA_LANE EmptyReach emptyReach(const PacketEmptySpace& space, const LeapingRays& rays, const BoxAt& box) {
    const I word = select(rays.upperWord, box.texel.high, box.texel.low);
    return {select(box.isOccupied, I(1), shr(word, rays.octantBit) & I(127)),
            select(box.isOccupied, I(space.shift - 2), I(space.shift))};
}

/// True if the empty space around one place touches, or holds, the smallest box around another.
TESSERA_LANE M touches(const PacketEmptySpace& space, const LeapingRays& rays, const BoxAt& from,
                       const BoxAt& to) {
    const EmptyReach reach = emptyReach(space, rays, from);
    const I other = select(to.isOccupied, I(space.shift - 2), I(space.shift));
    M all = every();
    for (int axis = 0; axis < 3; ++axis) {
        const I box = sar(from.voxel[axis], reach.shift), ahead = reach.boxes - I(1);
        const M up = rays.ascends[axis] == I(1);
        const I low = shl(select(up, box, box - ahead), reach.shift);
        const I high = shl(select(up, box + ahead, box) + I(1), reach.shift);
        const I there = sar(to.voxel[axis], other);
        all = all & ~(shl(there, other) > high) & ~(low > shl(there + I(1), other));
    }
    return all;
}

/// The rays' exits from the empty box, less a margin, in segments from their entry.
TESSERA_LANE F leaves(const PacketEmptySpace& space, const LeapingRays& rays, const BoxAt& box) {
    const auto [reach, shift] = emptyReach(space, rays, box);
    const auto leave = [&, reach = reach, shift = shift](int axis, F perStep, F toLeave) {
        const I far = select(rays.ascends[axis] == I(1), reach, I(1) - reach);
        const F side = number(shl(sar(box.voxel[axis], shift) + far, shift));
        return select(perStep == F(0.0f), F(kMostFloat), (side + toLeave) * perStep);
    };
    return min(min(leave(0, rays.perStep.x, rays.toLeave.x), leave(1, rays.perStep.y, rays.toLeave.y)),
               leave(2, rays.perStep.z, rays.toLeave.z));
}

} // namespace tessera::TESSERA_LANES
