// render/backends/native/packet_ways.h: ways of light, a lane each: freePath() and transmittance() of
// render/transport/tracking.h, number for number. Ways are of very different lengths, so lanes whose way has
// ended take the next one. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_march.h"
#include "render/backends/native/packet_numbers.h"
#include "render/backends/native/packet_tissue.h"

namespace tessera::TESSERA_LANES {

using native::PacketExtinction;
using native::PacketWays;
using native::PacketWaysMarch;

/// What lanes know of their ways while these go on, in memory: only lanes that take another way write there.
struct WayLanes {
    alignas(64) float from[3][kWidth] = {}, perMm[3][kWidth] = {}, mmPer[3][kWidth] = {};
    alignas(64) float mm[kWidth] = {}, least[kWidth] = {}, begin[kWidth] = {}, end[kWidth] = {};
    alignas(64) float low[kWidth] = {}, high[kWidth] = {}; // bounds of the box at hand
    alignas(64) float at[kWidth] = {}, depth[kWidth] = {}, left[kWidth] = {}, sure[kWidth] = {};
    alignas(64) std::int32_t first[kWidth] = {}, second[kWidth] = {}, draws[kWidth] = {};
    std::int32_t way[kWidth] = {};

    /// A lane takes a way, as BoundedWay begins it.
    void begins(int lane, const PacketWays& ways, int number_) {
        way[lane] = number_;
        float fastest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            from[axis][lane] = ways.from[axis][number_];
            const float along = ways.perMm[axis][number_];
            perMm[axis][lane] = along;
            mmPer[axis][lane] = along != 0.0f ? 1.0f / along : 0.0f;
            const float size = along < 0.0f ? -along : along;
            fastest = fastest < size ? size : fastest;
        }
        mm[lane] = ways.mm[number_];
        least[lane] = leaf::kWayOverlap / fastest;
        begin[lane] = end[lane] = 0;
        low[lane] = high[lane] = at[lane] = sure[lane] = 0;
        left[lane] = 1;
        first[lane] = static_cast<std::int32_t>(ways.first[number_]);
        second[lane] = static_cast<std::int32_t>(ways.second[number_]);
        draws[lane] = static_cast<std::int32_t>(ways.draws[number_]);
    }
};

/// The bounds around a place, packed (ExtinctionBounds), and log2 of their box's edge.
struct BoundsAt {
    I packed, shift;
};
TESSERA_LANE BoundsAt boundsAt(const PacketExtinction& e, const I (&voxel)[3], M m) {
    const auto box = [&](int axis) { return sar<3>(voxel[axis]); };
    const I cell = (box(2) * I(e.grid[1]) + box(1)) * I(e.grid[0]) + box(0);
    BoundsAt at{I(0), I(3)};
    if (!e.parts)
        return {gather<4>(e.cells, cell, m), I(3)};
    const I part = gather<4>(e.parts, cell, m);
    const M fine = m & ~(part < I(0));
    const auto in = [&](int axis) { return sar<2>(voxel[axis]) & I(1); };
    at.packed = gather<4>(e.cells, cell, m & ~fine);
    const I index = shl<3>(part) + (in(0) | shl<1>(in(1)) | shl<2>(in(2)));
    at.packed = select(fine, gather<4>(e.partRanges, index, fine), at.packed);
    at.shift = select(fine, I(2), I(3));
    return at;
}

/// Where ways leave a box, mm.
/// @param low, high  its sides, voxels: where a lane descends, and where it ascends
TESSERA_LANE F leavesBox(const F3& from, const F3& perMm, const F3& mmPer, const F3& low, const F3& high) {
    const F zero(0.0f), most(kMostFloat);
    const auto along = [&](F at, F per, F mm, F a, F b) {
        const F side = select(per > zero, b, a);
        return select(per == zero, most, (side - at) * mm);
    };
    return min(
        min(along(from.x, perMm.x, mmPer.x, low.x, high.x), along(from.y, perMm.y, mmPer.y, low.y, high.y)),
        along(from.z, perMm.z, mmPer.z, low.z, high.z));
}

/// @tparam Free  free paths; else transmittances
template <SampleKind K, bool Mixed, bool Free>
void followWays(const PacketScene& s, const PacketExtinction& e, PacketWays& ways) {
    const PacketField& f = s.field;
    const PacketOptics& o = s.optics;
    const bool graded = isGraded(o);
    WayLanes lanes;
    int next = 0;
    unsigned active_ = 0;
    Here<Mixed> here = hereAtFirst<Mixed>(f);
    std::uint64_t lookUps = 0, nullCollisions = 0, cells = 0, exceeded = 0;
    const F zero(0.0f), one(1.0f);
    // Lanes that have a box with something in it; of these, those at whose next place extinction is read.
    unsigned inBox_ = 0;
    for (;;) {
        // Lanes without a way take one.
        unsigned fresh = 0;
        for (int lane = 0; lane < kWidth && next < ways.count; ++lane)
            if ((active_ >> lane & 1u) == 0) {
                lanes.begins(lane, ways, next++);
                active_ |= 1u << lane;
                inBox_ &= ~(1u << lane);
                fresh |= 1u << lane;
            }
        if (active_ == 0)
            break;
        const F3 from = {load(lanes.from[0]), load(lanes.from[1]), load(lanes.from[2])};
        const F3 perMm = {load(lanes.perMm[0]), load(lanes.perMm[1]), load(lanes.perMm[2])};
        const F3 mmPer = {load(lanes.mmPer[0]), load(lanes.mmPer[1]), load(lanes.mmPer[2])};
        const F mm = load(lanes.mm), least = load(lanes.least);
        F begin = load(lanes.begin), end = load(lanes.end), low = load(lanes.low), high = load(lanes.high);
        F at = load(lanes.at), depth = load(lanes.depth), left = load(lanes.left), sure = load(lanes.sure);
        LaneNumbers numbers{load(lanes.first), load(lanes.second), load(lanes.draws)};
        const LeapingRays leaping = leapingRays(from, perMm);
        M active = fromBits(active_), inBox = fromBits(inBox_);
        if (fresh != 0)
            depth = select(fromBits(fresh), exponential(nextNumber(numbers, fromBits(fresh))), depth);
        M done = tessera::TESSERA_LANES::none();
        F result = zero;
        const auto ends = [&](M m, F with) {
            result = select(m, with, result);
            done = done | m;
            active = active & ~m;
            inBox = inBox & ~m;
        };
        const int wanted = next < ways.count ? kWidth * 3 / 4 : 1; // lanes that go on before others are taken
        M ready = tessera::TESSERA_LANES::none();
        while (count(active) >= wanted) {
            // The next box of lanes that have none.
            const M seeking = active & ~inBox;
            if (any(seeking)) {
                const M over = seeking & ~(end < mm);
                if (any(over)) {
                    if constexpr (Free)
                        ends(over, F(-1.0f));
                    else
                        ends(over, select(sure > zero, left * (one - leaf::oneMinusExp(sure)), left));
                }
                const M goes = seeking & ~over;
                cells += static_cast<unsigned>(count(goes));
                begin = select(goes, end, begin);
                const F3 p = from + begin * perMm;
                I voxel[3];
                const auto voxelOf = [&](F x, int axis) {
                    return min(max(truncated(x), I(0)), I(f.lastVoxel[axis]));
                };
                voxel[0] = voxelOf(p.x, 0), voxel[1] = voxelOf(p.y, 1), voxel[2] = voxelOf(p.z, 2);
                const BoundsAt bounds = boundsAt(e, voxel, goes);
                low = select(goes, asFloat(shl<16>(bounds.packed)), low);
                high = select(goes, asFloat(bounds.packed & I(static_cast<std::int32_t>(0xffff0000u))), high);
                const F overlap(leaf::kWayOverlap);
                F3 boxLow, boxHigh;
                const auto sides = [&](int axis, F& a, F& b) {
                    const I box = sar(voxel[axis], bounds.shift);
                    a = number(shl(box, bounds.shift)) - overlap;
                    b = number(shl(box + I(1), bounds.shift)) + overlap;
                };
                sides(0, boxLow.x, boxHigh.x), sides(1, boxLow.y, boxHigh.y), sides(2, boxLow.z, boxHigh.z);
                F to = leavesBox(from, perMm, mmPer, boxLow, boxHigh);
                const M empty = goes & ~(high > zero);
                if (s.space.map && any(empty)) {
                    const BoxAt box = boxAt(s.space, f, p, empty);
                    const M leaps = empty & ~box.shows;
                    const EmptyReach reach = emptyReach(s.space, leaping, box);
                    const F margin(kMargin);
                    const auto far = [&](int axis, F& a, F& b) {
                        const I at_ = sar(box.voxel[axis], reach.shift);
                        a = number(shl(at_ - (reach.boxes - I(1)), reach.shift)) + margin;
                        b = number(shl(at_ + reach.boxes, reach.shift)) - margin;
                    };
                    far(0, boxLow.x, boxHigh.x), far(1, boxLow.y, boxHigh.y), far(2, boxLow.z, boxHigh.z);
                    to = select(leaps, max(to, leavesBox(from, perMm, mmPer, boxLow, boxHigh)), to);
                }
                to = min(max(to, begin + least), mm);
                to = select(to > begin, to, asFloat(asInt(begin) + I(1))); // the next number
                end = select(goes, to, end);
                const M enters = goes & (high > zero);
                inBox = inBox | enters;
                at = select(enters, zero, at);
                if constexpr (!Free) {
                    sure = select(enters, sure + low * (end - begin), sure);
                    ends(enters & (sure > F(leaf::kDarkDepth)), zero);
                }
            }
            // Lanes whose next place lies beyond their box leave it.
            const F most = Free ? high : high - low;
            const F through = most * ((end - begin) - at);
            const M asked = active & inBox & ~ready;
            const M leaves_ = asked & ~(through > depth);
            depth = select(leaves_, depth - through, depth);
            inBox = inBox & ~leaves_;
            ready = (ready | asked) & inBox & active;
            if (count(ready) * 2 < count(active))
                continue; // a look-up costs more than a box
            at = select(ready, at + depth / most, at);
            const F place = begin + at;
            M reads = ready;
            F share = zero;
            if constexpr (Free) {
                share = nextNumber(numbers, ready) * high;
                const M sureHit = ready & (share < low);
                reads = ready & ~sureHit;
                ends(sureHit, place);
            }
            if (any(reads)) {
                lookUps += static_cast<unsigned>(count(reads));
                M there = reads;
                const F3 p = from + place * perMm;
                PacketRows rows;
                PacketRows* const kept = rowsToKeep(o, rows);
                F here_ = extinctionOf(o, entriesOf(o, valueOf<K, true>(s, here, p, there, kept)), reads);
                if (graded) {
                    // What gradients and labels leave is no more, but for the labels' own.
                    if (Free && o.labels.density == 0.0f)
                        there = there & (share < here_);
                    Beside beside;
                    if (any(there))
                        here_ =
                            select(there, gradedExtinction<K>(s, here, p, here_, beside, there, kept), here_);
                }
                here_ = min(here_, F(e.limit));
                exceeded += static_cast<unsigned>(count(reads & ((here_ > high) | (here_ < low))));
                if constexpr (Free) {
                    const M hits = reads & (share < here_);
                    ends(hits, place);
                    const M goesOn = reads & ~hits;
                    nullCollisions += static_cast<unsigned>(count(goesOn));
                    depth = select(goesOn, exponential(nextNumber(numbers, goesOn)), depth);
                } else {
                    left = select(reads, left * (one - (here_ - low) / most), left);
                    const M little = reads & (left < F(leaf::kLittleLight));
                    if (any(little)) {
                        const M dark = little & ~(left > zero);
                        const M drawn = little & ~dark;
                        const F share = nextNumber(numbers, drawn) * F(leaf::kLittleLight);
                        const M stays = drawn & (share < left);
                        ends(little & ~stays, zero);
                        left = select(stays, F(leaf::kLittleLight), left);
                    }
                    const M goesOn = reads & active;
                    depth = select(goesOn, exponential(nextNumber(numbers, goesOn)), depth);
                }
            }
            ready = tessera::TESSERA_LANES::none();
        }
        store(lanes.begin, begin), store(lanes.end, end), store(lanes.low, low), store(lanes.high, high);
        store(lanes.at, at), store(lanes.depth, depth), store(lanes.left, left), store(lanes.sure, sure);
        store(lanes.draws, numbers.draws);
        alignas(64) float results[kWidth];
        store(results, result);
        for (unsigned ended = bits(done); ended != 0; ended &= ended - 1) {
            const int lane = __builtin_ctz(ended);
            ways.result[lanes.way[lane]] = results[lane];
            ways.draws[lanes.way[lane]] = static_cast<std::uint32_t>(lanes.draws[lane]);
        }
        active_ = bits(active);
        inBox_ = bits(inBox);
    }
    ways.lookUps += lookUps, ways.nullCollisions += nullCollisions;
    ways.cells += cells, ways.exceeded += exceeded;
}

template <bool Free> PacketWaysMarch waysOf(const PacketScene& s) {
    return withSamples(s.field, [&](auto of) {
        constexpr SampleKind kKind = decltype(of)::kind;
        return s.field.mixed ? followWays<kKind, true, Free> : followWays<kKind, false, Free>;
    });
}
inline PacketWaysMarch chooseWays(const PacketScene& s, bool free) {
    return free ? waysOf<true>(s) : waysOf<false>(s);
}

} // namespace tessera::TESSERA_LANES
