// render/backends/native/packet_fused.h: a packet of rays through several volumes: the same as fusedAlong()
// of the mirror, for one ray a lane. One loop draws any number and kinds of volumes: it calls a function a
// volume for the samples of all lanes. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_march.h"

namespace tessera::TESSERA_LANES {

using native::kMostVolumes;
using native::PacketFusion;

/// Rays in one of the volumes.
struct VolumeRays {
    F3 entry, step;                      // voxels
    F3 direction;                        // patient space
    F enters, leaves;                    // its box within its cuts, in segments from the lattice's entry
    F3 last;                             // its extent
    const leaf::CutSlab* cuts = nullptr; // of it alone
    int cutCount = 0;
    LeapingRays leaping;
    Here<false> here;     // of one level
    Here<true> hereMixed; // of mixed levels
    M shows = none();     // lanes that are ready, and whose sample is there
};

/// A sample of one volume, and what it shows.
struct FusedLook {
    F extinction; // per mm
    F3 colour;
    M adds;
    M lacks; // lanes that lack a brick
    std::uint64_t gradients = 0;
};
using FusedSample = void (*)(const PacketScene&, VolumeRays&, const F3& p, const M& wanted, FusedLook&);

template <SampleKind K, bool Mixed>
void fusedSample(const PacketScene& s, VolumeRays& rays, const F3& p, const M& wanted, FusedLook& look) {
    const PacketOptics& o = s.optics;
    Here<Mixed>& here = [&]() -> Here<Mixed>& {
        if constexpr (Mixed)
            return rays.hereMixed;
        else
            return rays.here;
    }();
    const bool hasLabels = o.labels.count > 0;
    M m = wanted;
    PacketRows rows;
    PacketRows* const kept = o.gradient == PacketGradient::central ? &rows : nullptr;
    const F value = valueOf<K, true>(s, here, p, m, kept);
    const TableLook found = lookUp(o, entriesOf(o, value));
    look.extinction = found.extinction;
    look.colour = found.colour;
    Beside beside;
    look.adds = m & (look.extinction > F(0.0f));
    if (hasLabels)
        look.adds = takeLabels<Mixed>(s, here, p, look.extinction, beside, m);
    look.lacks = wanted & ~m;
    if (!any(look.adds))
        return;
    if (o.lit || o.gradientOpacity.count > 0)
        look.lacks = look.lacks | takeGradient<K>(s, here, p, hasLabels, kept, beside, look.extinction,
                                                  look.adds, look.gradients);
    if (hasLabels) {
        look.lacks = look.lacks | shareByLabels<Mixed>(s, here, p, beside, look.extinction, look.adds);
        if (o.labels.colour >= 0)
            look.colour = colouredByLabels(beside, look.colour);
    }
    look.adds = look.adds & (look.extinction > F(0.0f));
    look.colour = seenColour<Mixed>(s, here, look.colour, beside.gradient, rays.direction, p,
                                    placeOf(o, value), look.adds);
}

template <SampleKind K> FusedSample fusedSampleOf(const PacketScene& s) {
    return s.field.mixed ? fusedSample<K, true> : fusedSample<K, false>;
}
inline FusedSample fusedSampleOf(const PacketScene& s) {
    return withSamples(s.field, [&](auto of) { return fusedSampleOf<decltype(of)::kind>(s); });
}

/// The same rays in one of the volumes.
inline __attribute__((noinline)) void volumeRays(const PacketFusion& fusion, int number_,
                                                 const PacketJob& job, VolumeRays& rays) {
    const PacketScene& s = *fusion.volumes[number_];
    const float* const linear = fusion.linear[number_];
    const float(&offset)[3] = fusion.offset[number_];
    const F3 entry = transformed(linear, load3(job.entry));
    rays.entry = {entry.x + F(offset[0]), entry.y + F(offset[1]), entry.z + F(offset[2])};
    rays.step = transformed(linear, load3(job.step));
    rays.direction = transformed(s.optics.toPatient, transformed(linear, load3(job.direction)));
    rays.last = {number(I(s.field.extentVoxels[0])), number(I(s.field.extentVoxels[1])),
                 number(I(s.field.extentVoxels[2]))};
    F t0(-kMostFloat), t1(kMostFloat);
    const F zero(0.0f);
    M misses = leaf::clip(rays.entry.x, rays.step.x, zero, rays.last.x, t0, t1);
    misses = misses | leaf::clip(rays.entry.y, rays.step.y, zero, rays.last.y, t0, t1);
    misses = misses | leaf::clip(rays.entry.z, rays.step.z, zero, rays.last.z, t0, t1);
    rays.cuts = fusion.cuts[number_];
    rays.cutCount = fusion.cutCount[number_];
    for (int n = 0; n < rays.cutCount; ++n) { // whose inside is kept: nothing shows beyond
        const leaf::CutSlab& slab = rays.cuts[n];
        if (slab.keepsOutside)
            continue;
        const auto across = [&](const F3& v) { return leaf::placeAcross<F>(slab, v.x, v.y, v.z); };
        const F d = across(rays.step), length = abs(rays.step.x) + abs(rays.step.y) + abs(rays.step.z),
                most = length * (abs(F(slab.normal[0])) + abs(F(slab.normal[1])) + abs(F(slab.normal[2])));
        // Along a face rounding decides: samples of such rays are looked at one by one.
        const M crosses = abs(d) > F(1e-3f) * most;
        F from = t0, to = t1;
        const M beside = leaf::clip(across(rays.entry), d, F(slab.low), F(slab.high), from, to);
        t0 = select(crosses, from, t0), t1 = select(crosses, to, t1);
        misses = misses | (crosses & beside);
    }
    misses = misses | (t0 > t1);
    rays.enters = select(misses, F(kMostFloat), t0);
    rays.leaves = select(misses, F(-kMostFloat), t1);
    rays.leaping = leapingRays(rays.entry, rays.step);
    if (s.field.mixed)
        rays.hereMixed = hereAtFirst<true>(s.field);
    else
        rays.here = hereAtFirst<false>(s.field);
}

/// Looks at one volume for lanes: sets whose sample is in it and can show something. Returns the segment
/// from which on others could.
inline __attribute__((noinline)) F lookInto(const PacketScene& s, VolumeRays& rays, const F& at,
                                            const M& looking) {
    // Segments around the box's border, in which rounding decides: they are looked at one by one.
    constexpr float kAround = 2;
    const F3 p = leaf::placeAlong(rays.entry, rays.step, at), zero{F(0.0f), F(0.0f), F(0.0f)};
    M in = looking & within(p, zero, rays.last);
    if (rays.cutCount > 0)
        in = in & leaf::isKept(rays.cuts, rays.cutCount, p);
    const F before = floor(rays.enters - F(kAround)), behind = rays.leaves + F(kAround);
    F next = select(at < before, before, select(at > behind, F(kMostFloat), F(0.0f)));
    M shows = in;
    if (s.space.map && any(in)) {
        const BoxAt box = boxAt(s.space, s.field, p, in);
        shows = box.shows;
        next = select(in & ~shows, ceil(leaves(s.space, rays.leaping, box) - F(0.5f)), next);
    }
    rays.shows = (rays.shows & ~looking) | shows;
    return next;
}

inline void marchFused(const PacketScene& s, PacketJob& job) {
    const PacketFusion& fusion = *s.fusion;
    const PacketRays rays{load3(job.entry), load3(job.step), load(job.tail), load(job.count)};
    const F segmentMm = load(job.segmentMm);
    VolumeRays all[kMostVolumes];
    FusedSample sampleOf[kMostVolumes];
    for (int v = 0; v < fusion.count; ++v) {
        volumeRays(fusion, v, job, all[v]);
        sampleOf[v] = fusedSampleOf(*fusion.volumes[v]);
    }
    const I n(fusion.segments);
    I i = load(job.next);
    F3 sum{load(job.colour[0]), load(job.colour[1]), load(job.colour[2])};
    F alpha = load(job.colour[3]);
    M active = i < rays.count, ready = none(), waiting = none();
    int turns = 0;
    std::uint64_t iterations = 0, segments = 0, values = 0, gradients = 0, sampling = 0;
    while (any(active)) {
        if (++turns % kTurnsBetweenLooks == 0 && s.help.expired(s.help.context))
            break;
        if (job.turns != 0 && turns > job.turns)
            break;
        iterations += static_cast<unsigned>(count(active & ~ready));
        const F length = strideLength(rays, i, n), at = leaf::strideMiddle(number(i), length);
        const M looking = active & ~ready;
        M shows = none();
        F next(kMostFloat);
        for (int v = 0; v < fusion.count; ++v) {
            next = min(next, lookInto(*fusion.volumes[v], all[v], at, looking));
            shows = shows | (looking & all[v].shows);
        }
        ready = ready | shows;
        const M leaps = looking & ~shows;
        if (any(leaps)) {
            const M ends = ~(next < number(rays.count));
            const I to = max(truncated(select(ends, F(0.0f), next)), I(0)) & I(-fusion.segments);
            i = select(leaps, select(ends, rays.count, max(i + n, to)), i);
            active = active & (i < rays.count);
            if (paysToWait(leaps, active, ready))
                continue;
        }
        if (!any(ready))
            continue;
        M m = ready;
        leaf::Fused<F> fused{F(0.0f), F(0.0f), F(0.0f), F(0.0f)};
        M adds = none();
        for (int v = 0; v < fusion.count; ++v) {
            const M wanted = m & all[v].shows;
            if (!any(wanted))
                continue;
            FusedLook look;
            sampleOf[v](*fusion.volumes[v], all[v], leaf::placeAlong(all[v].entry, all[v].step, at), wanted,
                        look);
            values += static_cast<unsigned>(count(wanted));
            gradients += look.gradients;
            waiting = waiting | look.lacks;
            active = active & ~look.lacks;
            m = m & ~look.lacks;
            const M here = look.adds & ~look.lacks;
            if (!any(here))
                continue;
            const F opacity = fusion.rule == leaf::kFusionOver
                                  ? opacityOf(look.extinction * F(fusion.unitMm[v]), here)
                                  : F(0.0f);
            const leaf::Fused<F> with = leaf::fusedWith<F>(fused, fusion.rule, look.extinction, opacity,
                                                           look.colour.x, look.colour.y, look.colour.z);
            fused = {select(here, with.extinction, fused.extinction), select(here, with.red, fused.red),
                     select(here, with.green, fused.green), select(here, with.blue, fused.blue)};
            adds = adds | here;
        }
        ready = none();
        adds = adds & m;
        if (any(adds)) {
            const F opacity = opacityOf(fused.extinction * (length * segmentMm), adds);
            F3 gathered = sum;
            F after = alpha;
            leaf::compositeBehind(gathered, after, F3{fused.red, fused.green, fused.blue}, opacity);
            sum = select(adds, gathered, sum);
            alpha = select(adds, after, alpha);
            const M opaque = adds & (F(1.0f) - alpha < F(s.optics.termination));
            if (any(opaque)) [[unlikely]] {
                i = select(opaque, rays.count, i);
                active = active & ~opaque;
                m = m & ~opaque;
                segments += static_cast<unsigned>(count(opaque));
            }
        }
        segments += static_cast<unsigned>(count(m));
        ++sampling;
        i = select(m, i + n, i);
        active = active & (i < rays.count);
    }
    store(job.next, i);
    store(job.colour[0], sum.x), store(job.colour[1], sum.y), store(job.colour[2], sum.z);
    store(job.colour[3], alpha);
    job.waiting = bits(waiting);
    job.iterations += iterations;
    job.segments += segments;
    job.values += values;
    job.gradients += gradients;
    job.turnsTaken += sampling;
}

} // namespace tessera::TESSERA_LANES
