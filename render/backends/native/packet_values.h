// render/backends/native/packet_values.h: a packet of rays that keep one of the values along them, or their
// mean: the same as keepAlong() in mirror.h, for one ray a lane. A lane reads the bounds of values
// once a box: it leaps over the box, or takes all samples in it. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_march.h"

namespace tessera::TESSERA_LANES {

using native::PacketBounds;
using native::PacketReduction;

/// Boxes around places: whether samples there can change a lane's kept value, and log2 of the box's edge,
/// voxels.
struct BoundedBox {
    I voxel[3];
    I shift;
    M tells;
};

TESSERA_LANE BoundedBox boundedBoxAt(const PacketBounds& b, const PacketField& f, F3 p, F kept, M m) {
    BoundedBox box;
    const auto voxel = [&](F at, int axis) { return min(max(truncated(at), I(0)), I(f.lastVoxel[axis])); };
    box.voxel[0] = voxel(p.x, 0), box.voxel[1] = voxel(p.y, 1), box.voxel[2] = voxel(p.z, 2);
    const auto telling = [&](const float* bounds, const std::int32_t(&grid)[3], int shift, M wanted) {
        const I index =
            (sar(box.voxel[2], I(shift)) * I(grid[1]) + sar(box.voxel[1], I(shift))) * I(grid[0]) +
            sar(box.voxel[0], I(shift));
        const F bound = asFloat(gather<4>(bounds, index, wanted));
        return wanted & (b.least ? bound < kept : bound > kept);
    };
    box.tells = telling(b.brick, f.grid, 5, m);
    box.shift = I(5);
    if (b.cell && any(box.tells)) {
        const M inBrick = box.tells;
        box.tells = telling(b.cell, b.cells, 3, inBrick);
        box.shift = select(inBrick, I(3), box.shift);
    }
    return box;
}

/// The rays' exits from the box, less a margin, in segments from their entry.
TESSERA_LANE F leaves(const LeapingRays& rays, const BoundedBox& box) {
    const auto leave = [&](int axis, F perStep, F toLeave) {
        const F side = number(shl(sar(box.voxel[axis], box.shift) + rays.ascends[axis], box.shift));
        return select(perStep == F(0.0f), F(kMostFloat), (side + toLeave) * perStep);
    };
    return min(min(leave(0, rays.perStep.x, rays.toLeave.x), leave(1, rays.perStep.y, rays.toLeave.y)),
               leave(2, rays.perStep.z, rays.toLeave.z));
}

/// The content of job.colour until a ray's end: the kept value, its length, and 1 once it has met the drawn
/// part of the volume; then its colour.
template <SampleKind K, bool Mixed> void keep(const PacketScene& s, PacketJob& job) {
    const PacketField& f = s.field;
    const PacketOptics& o = s.optics;
    const bool mean = o.reduction == PacketReduction::average,
               least = o.reduction == PacketReduction::minimum;
    const bool leapsOver = !mean && s.bounds.brick != nullptr;
    const PacketRays rays{load3(job.entry), load3(job.step), load(job.tail), load(job.count)};
    const LeapingRays leaping = leapingRays(rays.entry, rays.step);
    Here<Mixed> here = hereAtFirst<Mixed>(f);
    Strides strides;
    I i = load(job.next);
    F kept = load(job.colour[0]), length = load(job.colour[1]), met = load(job.colour[3]);
    const F lastPlace(o.lastPlace), end = least ? F(0.0f) : lastPlace;
    M active = i < rays.count;
    if (least)
        kept = select(active & (met == F(0.0f)), lastPlace, kept);
    met = select(active, F(1.0f), met);
    M waiting = none();
    I until(0); // segments before it need no test
    int turns = 0;
    std::uint64_t leapt = 0, segments = 0, sampling = 0;
    while (any(active)) {
        if (++turns % kTurnsBetweenLooks == 0 && s.help.expired(s.help.context))
            break;
        if (job.turns != 0 && turns > job.turns)
            break;
        I k = stridesAt<Mixed>(s, rays, strides, i, active);
        I n = shl(I(1), k);
        F part = strideLength(rays, i, n);
        F3 p = along(rays, number(i) + F(0.5f) * part);
        M ready = active;
        if (leapsOver) {
            const M looking = active & ~(i < until);
            if (any(looking)) {
                const BoundedBox box = boundedBoxAt(s.bounds, f, p, kept, looking);
                const F beyond = ceil(leaves(leaping, box) - F(0.5f));
                const M ends = looking & ~(beyond < number(rays.count));
                const I to = max(truncated(select(ends, F(0.0f), beyond)), I(0));
                until = select(looking & box.tells, select(ends, rays.count, max(to, i + I(1))), until);
                const M leaps = looking & ~box.tells;
                if (any(leaps)) {
                    leapt += static_cast<unsigned>(count(leaps));
                    I start = to;
                    if constexpr (Mixed)
                        start = strideStarts(f, rays, strides, to, leaps & ~ends & (to > i + n));
                    else
                        start = to & I(-f.uniformSegments);
                    i = select(leaps, select(ends, rays.count, max(i + n, start)), i);
                    active = active & (i < rays.count);
                    ready = active & ~leaps;
                    // A test costs less than a sample: it pays to wait until most lanes have one to take.
                    if (count(ready) * 2 < count(active) || !any(ready))
                        continue;
                }
            }
        }
        M m = ready;
        const F value = valueOf<K>(s, here, p, m);
        const M lacks = ready & ~m;
        waiting = waiting | lacks;
        active = active & ~lacks;
        if (mean) {
            kept = select(m, kept + part * value, kept);
            length = select(m, length + part, length);
        } else {
            const F at = value * F(o.scale) + F(o.offset);
            const F place = leaf::heldPlace(at, lastPlace);
            kept = select(m, least ? min(kept, place) : max(kept, place), kept);
        }
        segments += static_cast<unsigned>(count(m));
        ++sampling;
        i = select(m, i + n, i);
        if (!mean) {
            const M done = m & (kept == end);
            if (any(done)) [[unlikely]]
                i = select(done, rays.count, i);
        }
        active = active & (i < rays.count);
    }
    store(job.next, i);
    const M ended = o.keepsOn ? tessera::TESSERA_LANES::none() : ~(i < rays.count) & ~waiting;
    F at = kept;
    if (mean) {
        const F value = kept / length;
        const F place = value * F(o.scale) + F(o.offset);
        at = leaf::heldPlace(place, lastPlace);
    }
    const M shows = ended & (met == F(1.0f));
    const Entries entries = entriesAt(o, select(shows, at, F(0.0f)));
    const F3 colour = lookUp(o, entries).colour;
    const F none_(0.0f);
    store(job.colour[0], select(ended, select(shows, colour.x, none_), kept));
    store(job.colour[1], select(ended, select(shows, colour.y, none_), length));
    store(job.colour[2], select(shows, colour.z, none_));
    store(job.colour[3], met);
    job.waiting = bits(waiting);
    job.iterations += leapt + segments;
    job.segments += segments;
    job.values += segments;
    job.turnsTaken += sampling;
}

inline PacketMarch chooseKeep(const PacketScene& s) {
    return withSamples(s.field, [&](auto of) {
        constexpr SampleKind kKind = decltype(of)::kind;
        return s.field.mixed ? keep<kKind, true> : keep<kKind, false>;
    });
}

} // namespace tessera::TESSERA_LANES
