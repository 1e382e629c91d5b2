// render/backends/native/packet_march.h: a packet of rays through a volume without surfaces: the same as
// mirrorRay(), for one ray a lane. A turn of the loop finds for every lane a stride that can show something.
// Once enough lanes have one, it takes their samples. For packet_*.cpp alone: it is compiled once for every
// instruction set.
#pragma once

#include "render/backends/native/packet_seen.h"
#include "render/backends/native/packet_space.h"

namespace tessera::TESSERA_LANES {

using native::PacketMarch;
using native::PacketScene;

constexpr int kTurnsBetweenLooks = 128; // at the clock
constexpr int kMaxStepsUnchecked = 3;   // turns: where much shows, tests cost more than useless samples

struct PacketRays {
    F3 entry, step;
    F tail;
    I count;
};
TESSERA_LANE F3 load3(const float (&p)[3][native::kMostLanes]) {
    return {load(p[0]), load(p[1]), load(p[2])};
}

/// Lengths of strides of n segments from i.
TESSERA_LANE F strideLength(const PacketRays& rays, I i, I n) {
    const M cut = i + n > rays.count - I(1);
    return select(cut, number(rays.count - I(1) - i) + rays.tail, number(n));
}
TESSERA_LANE F3 along(const PacketRays& rays, F segments) {
    return leaf::placeAlong(rays.entry, rays.step, segments);
}

/// log2 of the largest stride that a start at i allows.
TESSERA_LANE I alignmentOf(I i) {
    const I lowest = i & (I(0) - i);                            // a power of two, or 0
    const I exponent = shr<23>(asInt(number(lowest))) - I(127); // exact
    return select(i == I(0), I(31), exponent);
}

/// Mixed levels: the box where each lane's strides are known, and the strides; nowhere at first.
struct Strides {
    single::StrideBox a = single::noStrideBox(), b = single::noStrideBox();
    __attribute__((always_inline)) F3 low() const {
        return {{a.low.x, b.low.x}, {a.low.y, b.low.y}, {a.low.z, b.low.z}};
    }
    __attribute__((always_inline)) F3 high() const {
        return {{a.high.x, b.high.x}, {a.high.y, b.high.y}, {a.high.z, b.high.z}};
    }
    __attribute__((always_inline)) I exponent() const { return {a.exponent, b.exponent}; }
    __attribute__((always_inline)) I most() const { return {a.most, b.most}; }
};
inline __attribute__((noinline)) void findStrides(const PacketField& f, Strides& strides, const F3& p, M m) {
    single::updateStrideBox(f, strides.a, lowerHalf(p), m.a);
    single::updateStrideBox(f, strides.b, upperHalf(p), m.b);
}

/// Strides that start at i: log2 of their segments.
template <bool Mixed>
TESSERA_LANE I stridesAt(const PacketScene& s, const PacketRays& rays, Strides& strides, I i, M m) {
    if constexpr (!Mixed)
        return I(__builtin_ctz(static_cast<unsigned>(s.field.uniformSegments)));
    else {
        const F3 start = along(rays, number(i));
        const M rest = m & ~within(start, strides.low(), strides.high());
        if (any(rest))
            findStrides(s.field, strides, start, rest);
        return min(strides.exponent(), alignmentOf(i));
    }
}

/// The starts of the strides that hold segments i, of lanes m.
inline __attribute__((noinline)) I strideStarts(const PacketField& f, const PacketRays& rays,
                                                Strides& strides, I i, M m) {
    const F3 at = along(rays, number(i));
    const M unknown = m & ~within(at, strides.low(), strides.high());
    if (any(unknown))
        findStrides(f, strides, at, unknown);
    const I most = strides.most();
    // If all strides that could hold i start in one box, they have its exponent.
    const M all = within(along(rays, number(i & (I(0) - shl(I(1), most)))), strides.low(), strides.high());
    I to = select(m & all, i & (I(0) - shl(I(1), strides.exponent())), i);
    m = m & ~all & (most > I(0));
    if (!any(m))
        return to;
    for (int k = f.mostStride; k > 0; --k) {
        const M fits = m & ~(most < I(k));
        if (!any(fits))
            continue;
        const I start = i & I(-(1 << k));
        const I stride = min(strideExponent(f, along(rays, number(start)), fits), alignmentOf(start));
        const M holds = fits & (start + shl(I(1), stride) > i);
        to = select(holds, start, to);
        m = m & ~holds;
    }
    return to;
}

/// Takes lanes over the box that they are in, where nothing in it shows. The others get ready for a sample.
/// @param p  the middles of lanes' strides
/// @param n  segments that lanes would take
/// @param i  lanes' segments
/// @returns the lanes that it took
template <bool Mixed>
TESSERA_LANE M leapOver(const PacketScene& s, const PacketRays& rays, Strides& strides,
                        const LeapingRays& leaping, const F3& p, const I& n, I& i, M& active, M& ready) {
    const M looking = active & ~ready;
    const BoxAt box = boxAt(s.space, s.field, p, looking);
    ready = ready | box.shows;
    const M leaps = looking & ~box.shows;
    if (any(leaps)) {
        const F beyond = ceil(leaves(s.space, leaping, box) - F(0.5f)); // the first segment there
        const M ends = ~(beyond < number(rays.count));
        I to = max(truncated(select(ends, F(0.0f), beyond)), I(0));
        if constexpr (Mixed)
            to = strideStarts(s.field, rays, strides, to, leaps & ~ends & (to > i + n));
        else
            to = to & I(-s.field.uniformSegments);
        i = select(leaps, select(ends, rays.count, max(i + n, to)), i);
        active = active & (i < rays.count);
    }
    return leaps;
}

/// A look for empty boxes costs less than a sample: it pays to wait until most lanes have one to take.
/// @param leapt  lanes that may leap again
TESSERA_LANE bool paysToWait(M leapt, M active, M ready) {
    return count(leapt & active) * 2 > count(ready);
}

/// The field at p, which then lies in the lanes' brick where it lies in one.
/// @param Gradients  follow at p, so that lanes do not stay in the ghost layer of a brick behind them, where
///     some of a gradient's values are beyond
/// @param rows  as valueHere()
template <SampleKind K, bool Gradients = false, bool Mixed>
TESSERA_LANE F valueOf(const PacketScene& s, Here<Mixed>& here, F3 p, M& m, PacketRows* rows = kNoRows) {
    F3 x = inBrick(here, p);
    M inside = m & isHere(here, x);
    M outside = m & ~inside;
    if constexpr (Mixed) { // not where another brick would be no other one
        const F first = F(0.5f) * here.perVoxel - F(0.5f), last = first + F(32.0f) * here.perVoxel;
        outside = m & ~within(x, {first, first, first}, {last, last, last});
    } else if constexpr (Gradients) {
        const F first(0.0f), last(32.0f);
        outside = outside | (m & ~within(x, {first, first, first}, {last, last, last}));
    }
    if (any(outside)) {
        enter<Mixed>(s.field, here, p, outside);
        x = inBrick(here, p);
        inside = m & isHere(here, x);
    }
    return valueAt<K>(s.field, here, p, x, inside, m, rows);
}

/// @tparam Graded  the visible part needs more than its value: it is lit, its opacity goes by gradients, or
///     it has labels. Which is asked where it is taken: a loop for each kind would double the compiled code.
template <SampleKind K, bool Mixed, bool Ends, bool Graded> void march(const PacketScene& s, PacketJob& job) {
    const PacketField& f = s.field;
    const PacketOptics& o = s.optics;
    const bool skips = s.space.map != nullptr;
    const PacketRays rays{load3(job.entry), load3(job.step), load(job.tail), load(job.count)};
    const F segmentMm = load(job.segmentMm);
    const LeapingRays leaping = leapingRays(rays.entry, rays.step);
    F3 direction{F(0.0f), F(0.0f), F(0.0f)};
    if constexpr (Graded)
        direction = transformed(o.toPatient, load3(job.direction));
    Here<Mixed> here = hereAtFirst<Mixed>(f);
    Strides strides;
    I i = load(job.next);
    F3 sum{load(job.colour[0]), load(job.colour[1]), load(job.colour[2])};
    F alpha = load(job.colour[3]);
    M active = i < rays.count;
    M ready = none(), waiting = none();
    End front;                             // at the start of segment i
    M known = none(), showsFront = none(); // front is; something can show there
    M showsBack = none();                  // at the end of the stride of a lane that is ready
    const bool hasLabels = Graded && o.labels.count > 0,
               takesGradients = o.lit || o.gradientOpacity.count > 0;
    int turns = 0;
    int dense = 0,
        unlooked = 0; // tests in a row that found nothing empty; turns without one then
    std::uint64_t iterations = 0, segments = 0, values = 0, gradients = 0, sampling = 0;
    while (any(active)) {
        if (++turns % kTurnsBetweenLooks == 0 && s.help.expired(s.help.context))
            break;
        if (job.turns != 0 && turns > job.turns)
            break;
        iterations += static_cast<unsigned>(count(active & ~ready));
        I k = stridesAt<Mixed>(s, rays, strides, i, active);
        I n = shl(I(1), k);
        F length = strideLength(rays, i, n);
        if constexpr (!Ends) {
            F3 p = along(rays, leaf::strideMiddle(number(i), length));
            if (skips && unlooked > 0) {
                --unlooked;
                ready = active;
            } else if (skips) {
                const M leapt = leapOver<Mixed>(s, rays, strides, leaping, p, n, i, active, ready);
                if (!any(leapt)) {
                    unlooked = dense = dense < kMaxStepsUnchecked ? dense + 1 : dense;
                } else {
                    dense = 0;
                    if (paysToWait(leapt, active, ready))
                        continue;
                }
            } else {
                ready = active;
            }
        } else if (skips) {
            const M looking = active & ~ready;
            const BoxAt end = boxAt(s.space, f, along(rays, number(i) + length), looking);
            showsBack = (showsBack & ready) | end.shows;
            const M sure = looking & known & (showsFront | end.shows);
            const M doubtful = looking & ~sure;
            ready = ready | sure;
            if (any(doubtful)) {
                const BoxAt start = boxAt(s.space, f, along(rays, number(i)), doubtful);
                const M empty = doubtful & ~start.shows;
                ready = ready | start.shows;
                if (any(empty)) {
                    const F beyond = floor(leaves(s.space, leaping, start));
                    const M ends = empty & ~(beyond < number(rays.count));
                    M goes = empty & ~ends;
                    I to = max(truncated(select(goes, beyond, F(0.0f))), I(0));
                    if constexpr (Mixed)
                        to = strideStarts(f, rays, strides, to, goes & (to > i));
                    else
                        to = to & I(-f.uniformSegments);
                    to = select(goes, max(i, to), i);
                    known = known & ~(goes & (to != i));
                    i = select(ends, rays.count, to);
                    active = active & ~ends;
                    k = stridesAt<Mixed>(s, rays, strides, i, active);
                    n = shl(I(1), k);
                    length = strideLength(rays, i, n);
                    // Empty boxes that touch share a value, so that nothing between the values in both shows.
                    const BoxAt after = boxAt(s.space, f, along(rays, number(i) + length), goes);
                    const M passes = goes & ~after.shows & touches(s.space, leaping, start, after);
                    showsBack = (showsBack & ~goes) | after.shows;
                    known = known & ~passes;
                    i = select(passes, i + n, i);
                    ready = ready | (goes & ~passes);
                    active = active & (i < rays.count);
                    if (paysToWait(passes, active, ready))
                        continue;
                }
            }
        } else {
            ready = active;
        }
        if (!any(ready))
            continue;
        const F3 middle = along(rays, leaf::strideMiddle(number(i), length));
        M m = ready;
        const M taken = ready;
        ready = none();
        F extinction;
        End back;
        TableLook look;
        F place; // of the values that are lit
        PacketRows rows;
        const bool shares = !Ends && Graded && o.gradient == PacketGradient::central;
        PacketRows* const kept = shares ? &rows : nullptr;
        if constexpr (Ends) {
            const M unknown = m & ~known;
            if (any(unknown)) {
                M there = unknown;
                const F value = valueOf<K>(s, here, along(rays, number(i)), there);
                const M lacks = unknown & ~there;
                waiting = waiting | lacks;
                active = active & ~lacks;
                m = m & ~lacks;
                front = select(there, endOf(o, value, there), front);
                known = known | there;
                values += static_cast<unsigned>(count(there));
            }
            const M wanted = m;
            back = endOf(o, valueOf<K>(s, here, along(rays, number(i) + length), m), m);
            const M lacks = wanted & ~m;
            waiting = waiting | lacks;
            active = active & ~lacks;
            extinction = extinctionBetween(o, front, back);
            if constexpr (Graded)
                place = F(0.5f) * (front.place + back.place);
        } else {
            const M wanted = m;
            const F value = valueOf<K, Graded>(s, here, middle, m, kept);
            const M lacks = wanted & ~m;
            waiting = waiting | lacks;
            active = active & ~lacks;
            look = lookUp(o, entriesOf(o, value));
            if constexpr (Graded)
                place = placeOf(o, value);
            extinction = look.extinction;
        }
        M adds = m & (extinction > F(0.0f));
        Beside beside;
        const auto leaveOut = [&](M lacks) {
            waiting = waiting | lacks;
            active = active & ~lacks;
            m = m & ~lacks;
        };
        if constexpr (Graded)
            if (hasLabels) {
                const M wanted = m;
                adds = takeLabels<Mixed>(s, here, middle, extinction, beside, m);
                leaveOut(wanted & ~m);
            }
        if (any(adds)) {
            if (Graded && takesGradients)
                leaveOut(
                    takeGradient<K>(s, here, middle, hasLabels, kept, beside, extinction, adds, gradients));
            if constexpr (Graded)
                if (hasLabels)
                    leaveOut(shareByLabels<Mixed>(s, here, middle, beside, extinction, adds));
            const F depth = extinction * (length * segmentMm);
            const F opacity = opacityOf(depth, adds);
            F3 colour;
            if constexpr (Ends)
                colour = colourBetween(o, front, back, depth, opacity, k, adds);
            else
                colour = look.colour;
            if constexpr (Graded)
                if (hasLabels && o.labels.colour >= 0)
                    colour = colouredByLabels(beside, colour);
            if constexpr (Graded)
                colour = seenColour<Mixed>(s, here, colour, beside.gradient, direction, middle, place, adds);
            F3 gathered = sum;
            F after = alpha;
            leaf::compositeBehind(gathered, after, colour, opacity);
            sum = select(adds, gathered, sum);
            alpha = select(adds, after, alpha);
            // A branch, which is foreseen: else the next turn's samples would wait for this one's opacities.
            const M opaque = adds & (F(1.0f) - alpha < F(o.termination));
            if (any(opaque)) [[unlikely]] {
                i = select(opaque, rays.count, i);
                active = active & ~opaque;
                m = m & ~opaque;
                segments += static_cast<unsigned>(count(opaque));
            }
        }
        segments += static_cast<unsigned>(count(m));
        values += static_cast<unsigned>(count(taken));
        ++sampling;
        i = select(m, i + n, i);
        active = active & (i < rays.count);
        if constexpr (Ends) {
            front = select(m, back, front);
            showsFront = (showsFront & ~m) | (showsBack & m);
        }
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

template <SampleKind K>
void bareSamplesOf(const PacketScene& s, const std::int32_t (&brick)[3], int turns, PacketJob& job) {
    constexpr int kTurnsInside = 40; // half a voxel each
    Here<false> here;
    here.row = F(static_cast<float>(s.field.rowPitch[0]));
    here.slice = F(static_cast<float>(s.field.slicePitch[0]));
    alignas(64) float across[kWidth];
    for (int lane = 0; lane < kWidth; ++lane)
        across[lane] = 0.6f * static_cast<float>(lane % 4);
    const F3 first{F(static_cast<float>(32 * brick[0] + 4)) + load(across),
                   F(static_cast<float>(32 * brick[1] + 4)) + load(across),
                   F(static_cast<float>(32 * brick[2] + 4))};
    M m = every();
    enter<false>(s.field, here, first, m);
    F sum(0.0f);
    for (int turn = 0; turn < turns; ++turn) {
        const F along(static_cast<float>(turn % kTurnsInside) * 0.5f);
        const F3 p{first.x + along * F(0.3f), first.y + along * F(0.2f), first.z + along};
        sum = sum + valueHere<K>(s.field, here, inBrick(here, p), m, kNoRows);
    }
    store(job.colour[0], load(job.colour[0]) + sum);
}
inline void bareSamples(const PacketScene& s, const std::int32_t (&brick)[3], int turns, PacketJob& job) {
    return withSamples(s.field, [&](auto of) { bareSamplesOf<decltype(of)::kind>(s, brick, turns, job); });
}

template <SampleKind K, bool Mixed> PacketMarch chosen(const PacketScene& s) {
    const bool ends = s.optics.integrator != PacketIntegrator::midpoint;
    if (s.optics.lit || s.optics.gradientOpacity.count > 0 || s.optics.labels.count > 0)
        return ends ? march<K, Mixed, true, true> : march<K, Mixed, false, true>;
    return ends ? march<K, Mixed, true, false> : march<K, Mixed, false, false>;
}
template <SampleKind K> PacketMarch chosen(const PacketScene& s) {
    return s.field.mixed ? chosen<K, true>(s) : chosen<K, false>(s);
}
inline PacketMarch chooseMarch(const PacketScene& s) {
    return withSamples(s.field, [&](auto of) { return chosen<decltype(of)::kind>(s); });
}

} // namespace tessera::TESSERA_LANES
