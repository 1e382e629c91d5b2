// render/backends/native/packet_surfaces.h: a packet of rays through a volume with isosurfaces: the same as
// surfaceRay() in render/backends/mirror/mirror_surfaces.h, for one ray a lane. A turn of the loop finds for
// every lane a stride that is not proven empty. Once enough lanes have one, it takes those strides whole, so
// packets stop between strides alone. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_march.h"
#include "render/backends/native/packet_roots.h"
#include "render/backends/native/packet_values.h"

namespace tessera::TESSERA_LANES {

using native::PacketHits;
using native::PacketSurfaces;

/// Lanes of m whose way from a to b is proven empty: the same as isClear() in render/empty_space/occupancy.h,
/// for lanes.
inline __attribute__((noinline)) M clearBetween(const PacketEmptySpace& space, const PacketField& f, F3 a,
                                                F3 b, M m) {
    const I fine(space.shift - 2);
    I first[3], spans(0);
    const auto axis = [&](F from, F to, int n) {
        const auto voxel = [&](F at) { return min(max(truncated(at), I(0)), I(f.lastVoxel[n])); };
        const I u = voxel(from), v = voxel(to);
        first[n] = sar(min(u, v), fine);
        const I span = sar(max(u, v), fine) - first[n];
        m = m & ~(span > I(1));
        spans = spans | shl(span & I(1), I(n));
    };
    axis(a.x, b.x, 0), axis(a.y, b.y, 1), axis(a.z, b.z, 2);
    for (int corner = 0; corner < 8; ++corner) {
        const M lanes = m & ((I(corner) & ~spans) == I(0));
        if (!any(lanes))
            continue;
        const I x = first[0] + I(corner & 1), y = first[1] + I((corner >> 1) & 1),
                z = first[2] + I(corner >> 2);
        const I box = (sar<2>(z) * I(space.grid[1]) + sar<2>(y)) * I(space.grid[0]) + sar<2>(x);
        const Pair texel = texelsAt(space, box, lanes);
        const M isOccupied = texel.high < I(0);
        m = m & ~(lanes & isOccupied & blockShows(texel, x & I(3), y & I(3), z & I(3)));
    }
    return m;
}

/// leaves(), rounded as the mirror's. It decides whether a stride that spans more than two blocks is taken or
/// leapt over. If values jump between bricks (edge function nearest) such a stride can hold a crossing that
/// no block holds.
TESSERA_LANE F leavesAsTheMirror(const PacketEmptySpace& space, const PacketRays& rays,
                                 const LeapingRays& leaping, const BoxAt& box) {
    const auto [reach, shift] = emptyReach(space, leaping, box);
    F leave(kMostFloat);
    const auto axis = [&, reach = reach, shift = shift](int n, F entry, F d) {
        const M up = leaping.ascends[n] == I(1);
        const F side = number(shl(sar(box.voxel[n], shift) + select(up, reach, I(1) - reach), shift));
        const F at = (side + select(up, F(-kMargin), F(kMargin)) - entry) / d;
        leave = select(d == F(0.0f), leave, min(leave, at));
    };
    axis(0, rays.entry.x, rays.step.x), axis(1, rays.entry.y, rays.step.y);
    axis(2, rays.entry.z, rays.step.z);
    return leave;
}

/// The first plane of sample centres on each ray beyond w, in segments from start.
TESSERA_LANE F nextPlane(F3 start, F3 step, F w, F pitch, float segmentVoxels) {
    F next(kMostFloat);
    const F least = w + F(leaf::kPlaneMargin / segmentVoxels);
    const auto axis = [&](F from, F d) {
        next = select(d == F(0.0f), next, min(next, leaf::planeBehind(from, d, w, pitch, least)));
    };
    axis(start.x, step.x), axis(start.y, step.y), axis(start.z, step.z);
    return next;
}

/// The strides that lanes take at once. Members are of all lanes.
template <SampleKind K, bool Mixed> struct SurfaceStrides {
    const PacketScene& s;
    const PacketField& f;
    const PacketOptics& o;
    const PacketSurfaces& surfaces;
    PacketHits* const hits; // null: nobody asks
    const bool ends;
    PacketRays rays;
    F segmentMm;
    F3 direction; // patient space
    Here<Mixed> here;
    F3 sum;
    F alpha;
    I met; // 1 + the surface that was met first; 0: none

    I i, stride; // the segment that strides start with; log2 of their segments
    F3 start;
    F length;
    M there;           // lanes whose samples are all there so far
    M done;            // nothing behind is seen
    F from, valueFrom; // start of the part not added yet: segments from start
    std::uint64_t values = 0, gradients = 0, sampling = 0;

    SurfaceStrides(const PacketScene& scene, const PacketJob& job)
        : s(scene), f(scene.field), o(scene.optics), surfaces(scene.surfaces), hits(job.hits),
          ends(scene.optics.integrator != PacketIntegrator::midpoint), rays{load3(job.entry), load3(job.step),
                                                                            load(job.tail), load(job.count)},
          segmentMm(load(job.segmentMm)), direction(transformed(o.toPatient, load3(job.direction))),
          here(hereAtFirst<Mixed>(scene.field)), sum{load(job.colour[0]), load(job.colour[1]),
                                                     load(job.colour[2])},
          alpha(load(job.colour[3])), met(hits ? load(hits->surface) : I(0)) {}

    /// The field at p. Lanes that lack a brick are taken from m, and no longer there.
    __attribute__((noinline)) F valueOf(F3 p, M& m) {
        const M wanted = m;
        values += static_cast<unsigned>(count(m));
        ++sampling;
        const F value = TESSERA_LANES::valueOf<K>(s, here, p, m);
        there = there & ~(wanted & ~m);
        return value;
    }
    F valueOf(F3 p, M&& m) { return valueOf(p, m); }
    /// @param smooth  of normals, where these have an operator of their own
    __attribute__((noinline)) F3 gradientOf(F3 p, M& m, bool smooth) {
        const M wanted = m;
        const F3 gradient = smooth && o.normalReach > 1.0f
                                ? otherDifferences<K>(f, here, PacketGradient::sobel, p, m, o.normalReach)
                                : gradientAt<K>(f, s.help, here, o.gradient, p, m);
        gradients += static_cast<unsigned>(count(m));
        there = there & ~(wanted & ~m);
        return gradient;
    }
    F3 along(F segments) const { return leaf::placeAlong(start, rays.step, segments); }

    void composite(F3 colour, F opacity, M m) {
        F3 gathered = sum;
        F after = alpha;
        leaf::compositeBehind(gathered, after, colour, opacity);
        sum = select(m, gathered, sum);
        alpha = select(m, after, alpha);
        const F left = F(1.0f) - alpha;
        done = done | (m & ((left < F(o.termination)) | ~(left > F(0.0f))));
    }

    /// @param position, place  of the lit point: voxels; of its value in the table
    F3 lit(F3 colour, F3 gradient, F3 position, F place, M m) const {
        return seenColour<Mixed>(s, here, colour, gradient, direction, position, place, m);
    }

    /// The volume between two places of a stride, segments from its start.
    __attribute__((noinline)) void addVolume(F low, F high, F valueLow, F valueHigh, M m) {
        const F part = high - low;
        m = m & there & ~done & (part > F(0.0f));
        if (!surfaces.volumeShows || !any(m))
            return;
        const F3 middle = along(low + F(0.5f) * part);
        End a, b;
        TableLook look;
        F extinction;
        if (ends) {
            a = endOf(o, valueLow, m), b = endOf(o, valueHigh, m);
            extinction = extinctionBetween(o, a, b);
        } else {
            const F value = valueOf(middle, m);
            look = lookUp(o, entriesOf(o, value));
            b.place = placeOf(o, value);
            extinction = look.extinction;
        }
        m = m & (extinction > F(0.0f));
        if (!any(m))
            return;
        const bool grades = o.gradientOpacity.count > 0;
        F3 gradient;
        if (grades) {
            gradient = gradientOf(middle, m, false);
            extinction = extinction * gradientFactor(o, gradient);
        }
        const F depth = extinction * (part * segmentMm);
        const F opacity = opacityOf(depth, m);
        F3 colour = ends ? colourBetween(o, a, b, depth, opacity, stride, m) : look.colour;
        if (o.lit) {
            if (!grades || o.normalReach > 1.0f)
                gradient = gradientOf(middle, m, true);
            colour = lit(colour, gradient, middle, ends ? F(0.5f) * (a.place + b.place) : b.place, m);
        }
        if (surfaces.showsDistances)
            colour.x = (number(i) + (low + F(0.5f) * part)) * segmentMm;
        composite(colour, opacity, m);
    }

    /// The first hits of rays that had met nothing.
    void note(F3 p, F3 gradient, I surface, M m) {
        m = m & (met == I(0)) & (F(0.0f) < word(surfaces.reports, surface, m));
        if (!any(m))
            return;
        const F3 g = transformed(o.toGradient, gradient);
        const F size = leaf::length3(g);
        const F3 normal = leaf::facingNormal(g, direction, size, size > F(0.0f));
        const auto keep = [&](float* to, F x) { store(to, select(m, x, load(to))); };
        keep(hits->position[0], p.x), keep(hits->position[1], p.y), keep(hits->position[2], p.z);
        keep(hits->weight, F(1.0f) - alpha);
        keep(hits->normal[0], normal.x), keep(hits->normal[1], normal.y), keep(hits->normal[2], normal.z);
        met = select(m, surface + I(1), met);
    }

    __attribute__((noinline)) void addSurface(F at, I surface, F isovalue, M m) {
        m = m & there & ~done;
        if (!any(m))
            return;
        addVolume(from, at, valueFrom, isovalue, m);
        from = select(m, at, from);
        valueFrom = select(m, isovalue, valueFrom);
        m = m & there & ~done;
        const F3 p = along(at);
        F3 gradient{F(0.0f), F(0.0f), F(0.0f)};
        if ((o.lit || hits) && any(m))
            gradient = gradientOf(p, m, true);
        if (hits)
            note(p, gradient, surface, m);
        const auto look = [&](const float* column) { return word(column, surface, m); };
        F3 colour{look(surfaces.red), look(surfaces.green), look(surfaces.blue)};
        if (o.lit)
            colour = lit(colour, gradient, p, placeOf(o, isovalue), m);
        if (surfaces.showsDistances)
            colour.x = (number(i) + at) * segmentMm;
        composite(colour, look(surfaces.opacity), m);
    }

    /// The crossings of the pieces from w on, in their order.
    /// @param v0,v1,v2,v3  the field at thirds of it
    void addCrossings(F w, F piece, F v0, F v1, F v2, F v3, M m) {
        const Cubic cubic = leaf::cellCubic(v0, v1, v2, v3);
        const auto range = leaf::cellRange(cubic, v3, F(kMostFloat));
        M may = none();
        for (int n = 0; n < surfaces.count; ++n)
            may = may | leaf::mayHold(range, F(surfaces.isovalue[n]));
        m = m & may;
        if (!any(m))
            return;
        const MonotoneParts parts = monotoneParts(cubic);
        F front = v0;
        for (int part = 0; part < 3; ++part) {
            const M lanes = m & (I(part) < parts.count);
            if (!any(lanes))
                break;
            const F a = parts.ends[part], b = parts.ends[part + 1];
            const F back = select(parts.count == I(part + 1), v3, leaf::cubicAt(cubic, b));
            const M rises = back > front;
            for (int n = 0; n < surfaces.count; ++n) {
                const int other = surfaces.count - 1 - n;
                const F isovalue = select(rises, F(surfaces.isovalue[n]), F(surfaces.isovalue[other]));
                const M before = front < isovalue, after = back < isovalue;
                const M crosses = lanes & ((before & ~after) | (~before & after)) & ~done;
                if (!any(crosses))
                    continue;
                const F u = bracketedRoot(cubic, isovalue, a, b, front - isovalue, back - isovalue, crosses);
                addSurface(w + u * piece, select(rises, I(n), I(other)), isovalue, crosses);
            }
            front = back;
        }
    }

    F pitchAt(F3 p, M m) const {
        if constexpr (!Mixed)
            return F(static_cast<float>(1 << f.level));
        const I code = codeAt(f, p, m);
        return asFloat(shl<23>(I(127) + select(code == I(single::kEmptyCode), I(f.finest), code)));
    }

    void addSurfaces(F front, F back, M m) {
        const F third(static_cast<float>(1.0 / 3)), thirds(static_cast<float>(2.0 / 3));
        F w(0.0f), value = front;
        while (any(m)) {
            const F next = min(nextPlane(start, rays.step, w, pitchAt(along(w), m), f.segmentVoxels), length);
            const F piece = next - w;
            const M last = next == length;
            const F v1 = valueOf(along(w + piece * third), m);
            const F v2 = valueOf(along(w + piece * thirds), m);
            F v3 = back;
            M goesOn = m & ~last;
            if (any(goesOn))
                v3 = select(last, back, valueOf(along(next), goesOn));
            m = m & (last | goesOn);
            addCrossings(w, piece, value, v1, v2, v3, m);
            w = next;
            value = v3;
            m = m & (w < length) & there & ~done;
        }
    }

    /// Takes a stride of the lanes of m from their segments i on, which are others then: those behind the
    /// stride, or the ray's count. Lanes that lack a brick stay as they were.
    /// @param front, known  the field at a stride's start, and whether it is known
    M take(I& segment, I k, F strides, F& front, M& known, M m) {
        const F3 sumBefore = sum;
        const F alphaBefore = alpha;
        const I metBefore = met;
        i = segment, stride = k, length = strides;
        start = TESSERA_LANES::along(rays, number(i));
        const F3 end = TESSERA_LANES::along(rays, number(i) + length);
        there = m, done = none();
        M solves = m;
        if (surfaces.space.map)
            solves = m & ~clearBetween(surfaces.space, f, start, end, m);
        const M needs = ends ? m : solves;
        F back(0.0f);
        if (any(needs)) {
            const M unknown = needs & ~known;
            if (any(unknown))
                front = select(unknown, valueOf(start, M(unknown)), front);
            back = valueOf(end, needs & there);
        }
        from = F(0.0f), valueFrom = front;
        if (any(solves))
            addSurfaces(front, back, solves & there);
        addVolume(from, length, valueFrom, back, m);
        const M lacks = m & ~there;
        if (any(lacks)) [[unlikely]] {
            sum = select(lacks, sumBefore, sum);
            alpha = select(lacks, alphaBefore, alpha);
            met = select(lacks, metBefore, met);
        }
        segment = select(there, select(done, rays.count, i + shl(I(1), k)), i);
        front = select(there, back, front);
        known = (known & ~m) | (needs & there);
        return there;
    }
};

template <SampleKind K, bool Mixed> void marchSurfaces(const PacketScene& s, PacketJob& job) {
    const PacketField& f = s.field;
    const bool skips = s.space.map != nullptr;
    SurfaceStrides<K, Mixed> strides(s, job);
    const PacketRays& rays = strides.rays;
    Strides aligned;
    const LeapingRays leaping = leapingRays(rays.entry, rays.step);
    I i = load(job.next);
    M active = i < rays.count, ready = none(), waiting = none(), known = none();
    F front(0.0f); // the field at the start of segment i, where it is known
    int turns = 0;
    while (any(active)) {
        if (++turns % kTurnsBetweenLooks == 0 && s.help.expired(s.help.context))
            break;
        if (job.turns != 0 && turns > job.turns)
            break;
        job.iterations += static_cast<unsigned>(count(active & ~ready));
        I k = stridesAt<Mixed>(s, rays, aligned, i, active);
        F length = strideLength(rays, i, shl(I(1), k));
        if (!skips) {
            ready = active;
        } else {
            const M looking = active & ~ready;
            const BoxAt box = boxAt(s.space, f, along(rays, number(i)), looking);
            const M empty = looking & ~box.shows;
            ready = ready | box.shows;
            if (any(empty)) {
                const F beyond = floor(leavesAsTheMirror(s.space, rays, leaping, box));
                const M ends = empty & ~(beyond < number(rays.count));
                const M goes = empty & ~ends;
                I to = max(truncated(select(goes, beyond, F(0.0f))), I(0));
                if constexpr (Mixed)
                    to = strideStarts(f, rays, aligned, to, goes & (to > i));
                else
                    to = to & I(-f.uniformSegments);
                to = select(goes, max(i, to), i);
                const M stays = to == i;
                known = known & (stays | ~goes);
                i = select(ends, rays.count, to);
                active = active & ~ends;
                k = stridesAt<Mixed>(s, rays, aligned, i, active);
                length = strideLength(rays, i, shl(I(1), k));
                const M passes =
                    clearBetween(s.space, f, along(rays, number(i)), along(rays, number(i) + length), goes);
                known = known & ~passes;
                i = select(passes, i + shl(I(1), k), i);
                const M goesOn = goes & (passes | ~stays); // and is tested again
                ready = ready | (goes & ~goesOn);
                active = active & (i < rays.count);
                if (paysToWait(goesOn, active, ready))
                    continue;
            }
        }
        if (!any(ready))
            continue;
        const M there = strides.take(i, k, length, front, known, ready);
        waiting = waiting | (ready & ~there);
        job.segments += static_cast<unsigned>(count(there));
        active = active & ~waiting & (i < rays.count);
        ready = none();
    }
    store(job.next, i);
    store(job.colour[0], strides.sum.x), store(job.colour[1], strides.sum.y);
    store(job.colour[2], strides.sum.z), store(job.colour[3], strides.alpha);
    if (job.hits)
        store(job.hits->surface, strides.met);
    job.waiting = bits(waiting);
    job.values += strides.values;
    job.gradients += strides.gradients;
    job.turnsTaken += strides.sampling;
}

template <SampleKind K> PacketMarch chosenForSurfaces(const PacketScene& s) {
    return s.field.mixed ? marchSurfaces<K, true> : marchSurfaces<K, false>;
}
inline PacketMarch chooseAnyMarch(const PacketScene& s) {
    if (s.optics.reduction != native::PacketReduction::composite)
        return chooseKeep(s);
    if (s.surfaces.count == 0)
        return chooseMarch(s);
    return withSamples(s.field, [&](auto of) { return chosenForSurfaces<decltype(of)::kind>(s); });
}

} // namespace tessera::TESSERA_LANES
