// render/backends/native/packet_places.h: places of paths of light, a lane each: where rays see something,
// and what the field has there. The same as the scalar text, bit for bit. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_march.h"
#include "render/backends/native/packet_numbers.h"
#include "render/backends/native/packet_tissue.h"

namespace tessera::TESSERA_LANES {

using native::PacketSamples;
using native::PacketSeen;

/// Values and gradients of a list of places, as the scalar text has them.
template <SampleKind K, bool Mixed> void takeSamples(const PacketScene& s, PacketSamples& list) {
    Here<Mixed> here = hereAtFirst<Mixed>(s.field);
    for (int first = 0; first < list.count; first += kWidth) {
        const int rest = list.count - first;
        const M all = rest >= kWidth ? every() : fromBits((1u << rest) - 1u);
        const F3 p{load(list.at[0] + first), load(list.at[1] + first), load(list.at[2] + first)};
        M there = all;
        store(list.value + first, valueOf<K, true>(s, here, p, there));
        if (!list.gradient[0])
            continue;
        there = all;
        const F3 g = gradientAt<K>(s.field, s.help, here, list.kind, p, there);
        store(list.gradient[0] + first, g.x), store(list.gradient[1] + first, g.y);
        store(list.gradient[2] + first, g.z);
    }
}

/// What a midpoint has of the function, by gradients and labels too.
/// @param m  rays that ask
template <SampleKind K, bool Mixed>
TESSERA_LANE TableLook lookOf(const PacketScene& s, Here<Mixed>& here, const F3& middle, M& m) {
    const PacketOptics& o = s.optics;
    PacketRows rows;
    PacketRows* const kept = rowsToKeep(o, rows);
    TableLook look = lookUp(o, entriesOf(o, valueOf<K, true>(s, here, middle, m, kept)));
    if (isGraded(o)) {
        Beside beside;
        look.extinction = gradedExtinction<K>(s, here, middle, look.extinction, beside, m, kept);
        if (o.labels.count > 0 && o.labels.colour >= 0)
            look.colour = colouredByLabels(beside, look.colour);
    }
    return look;
}

/// Stretches that are sought again, a ray each: segments; the share of their opacity in front of the place.
struct Stretches {
    F start, length, passed;
};
/// As seekInParts() (render/backends/mirror/mirror_places.h).
/// @param found  rays that have such a segment
template <SampleKind K, bool Mixed>
void seekPartsOf(const PacketScene& s, const PacketRays& rays, F segmentMm, Here<Mixed>& here,
                 const Stretches& of, M found, F3& place, F3& colour) {
    constexpr int kParts = leaf::kSoughtParts;
    const F part(1.0f / kParts), one(1.0f);
    const auto placeOf = [&](F share) { return along(rays, of.start + share * of.length); };
    F depths[kParts], depth(0.0f);
    F3 colours[kParts];
    for (int n = 0; n < kParts; ++n) {
        M m = found;
        const TableLook look =
            lookOf<K, Mixed>(s, here, placeOf((F(static_cast<float>(n)) + F(0.5f)) * part), m);
        depths[n] = look.extinction * (part * (of.length * segmentMm));
        colours[n] = look.colour;
        depth = depth + depths[n];
    }
    F left = exponential(of.passed * opacityOf(depth, found));
    M sought = found;
    for (int n = 0; n < kParts; ++n) {
        const M shows = sought & (depths[n] > F(0.0f));
        place = select(shows, placeOf((F(static_cast<float>(n)) + min(one, left / depths[n])) * part), place);
        colour = select(shows, colours[n], colour);
        sought = sought & ~(shows & (left < depths[n]));
        left = select(shows, left - depths[n], left);
    }
}

/// Where rays have gathered an opacity: as compositeAlong() with a SeenPlace
/// (render/backends/mirror/mirror.h), by the midpoint rule.
template <SampleKind K, bool Mixed>
void seekPlaces(const PacketScene& s, const PacketJob& job, PacketSeen& seen) {
    const PacketField& f = s.field;
    const PacketOptics& o = s.optics;
    const bool skips = s.space.map != nullptr;
    const PacketRays rays{load3(job.entry), load3(job.step), load(job.tail), load(job.count)};
    const F segmentMm = load(job.segmentMm), sought = load(seen.sought), one(1.0f);
    const LeapingRays leaping = leapingRays(rays.entry, rays.step);
    Here<Mixed> here = hereAtFirst<Mixed>(f);
    Strides strides;
    I i(0);
    F alpha = load(seen.alpha);
    F3 place = load3(seen.place), colour = load3(seen.colour);
    M active = i < rays.count, ready = none(), shows = fromBits(seen.shows), all = none();
    F firstSeen(leaf::kNothingSeen);
    Stretches of{F(0.0f), F(1.0f), F(0.0f)};
    std::uint64_t segments = 0;
    while (any(active)) {
        const I k = stridesAt<Mixed>(s, rays, strides, i, active), n = shl(I(1), k);
        const F length = strideLength(rays, i, n);
        const F3 middle = along(rays, leaf::strideMiddle(number(i), length));
        if (skips) {
            const M leapt = leapOver<Mixed>(s, rays, strides, leaping, middle, n, i, active, ready);
            if (paysToWait(leapt, active, ready))
                continue;
        } else {
            ready = active;
        }
        if (!any(ready))
            continue;
        M m = ready;
        ready = none();
        const TableLook look = lookOf<K, Mixed>(s, here, middle, m);
        const M adds = m & (look.extinction > F(0.0f));
        segments += static_cast<unsigned>(count(m));
        if (any(adds)) {
            const F depth = look.extinction * (length * segmentMm);
            const F opacity = opacityOf(depth, adds);
            const F share = max(F(0.0f), (sought - alpha) / (one - alpha));
            const M seen_ = adds & (opacity > F(0.0f)), found = seen_ & (share < opacity);
            const F part = select(found, min(one, exponential(share) / depth), one);
            place = select(seen_, along(rays, number(i) + part * length), place);
            firstSeen = select(seen_ & (alpha == F(0.0f)), number(i), firstSeen);
            const F from = leaf::soughtFrom(number(i), length, firstSeen);
            of.start = select(found, from, of.start);
            of.length = select(found, (number(i) - from) + length, of.length);
            of.passed =
                select(found, leaf::soughtShare(number(i), from, sought, alpha, opacity, share), of.passed);
            colour = select(seen_, look.colour, colour);
            shows = shows | seen_;
            all = all | found;
            alpha = select(adds, alpha + (one - alpha) * opacity, alpha);
            active = active & ~found & ~(adds & (one - alpha < F(o.termination)));
        }
        i = select(m, i + n, i);
        active = active & (i < rays.count);
    }
    if (any(all))
        seekPartsOf<K, Mixed>(s, rays, segmentMm, here, of, all, place, colour);
    for (int axis = 0; axis < 3; ++axis) {
        store(seen.place[axis], axis == 0 ? place.x : axis == 1 ? place.y : place.z);
        store(seen.colour[axis], axis == 0 ? colour.x : axis == 1 ? colour.y : colour.z);
    }
    store(seen.alpha, alpha);
    seen.shows = bits(shows), seen.found = bits(all);
    seen.segments += segments;
}

inline native::PacketPlaceTools choosePlaces(const PacketScene& s) {
    return withSamples(s.field, [&](auto of) {
        constexpr SampleKind kKind = decltype(of)::kind;
        return s.field.mixed ? native::PacketPlaceTools{takeSamples<kKind, true>, seekPlaces<kKind, true>}
                             : native::PacketPlaceTools{takeSamples<kKind, false>, seekPlaces<kKind, false>};
    });
}

} // namespace tessera::TESSERA_LANES
