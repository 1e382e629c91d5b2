// render/backends/native/packet_tissue.h: extinctions at places with labels and gradient opacity, as shadows
// and paths of light ask for them, for all lanes of a packet. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_seen.h"

namespace tessera::TESSERA_LANES {

/// True if extinctions depend on more than values.
TESSERA_LANE bool isGraded(const PacketOptics& o) {
    return o.gradientOpacity.count > 0 || o.labels.count > 0;
}

/// Where the samples of a value are to be kept for a gradient at the same place; null: they are not needed.
TESSERA_LANE PacketRows* rowsToKeep(const PacketOptics& o, PacketRows& rows) {
    return o.gradientOpacity.count > 0 && o.gradient == PacketGradient::central ? &rows : kNoRows;
}

/// Extinctions at p, where isGraded(). Lanes that lack a brick are taken from m.
/// @param extinction  of the function
/// @param beside  gets labels and their share of light
/// @param rows  as valueHere()
template <SampleKind K, bool Mixed>
inline __attribute__((noinline)) F gradedExtinction(const PacketScene& s, const Here<Mixed>& here,
                                                    const F3& p, F extinction, Beside& beside, M& m,
                                                    const PacketRows* rows = kNoRows) {
    const PacketOptics& o = s.optics;
    const bool hasLabels = o.labels.count > 0;
    M takes = m & (extinction > F(0.0f));
    if (hasLabels)
        takes = takeLabels<Mixed>(s, here, p, extinction, beside, m);
    if (o.gradientOpacity.count > 0 && any(takes)) {
        M there = takes;
        const F3 gradient = gradientAt<K>(s.field, s.help, here, o.gradient, p, there, rows);
        m = m & ~(takes & ~there);
        extinction = select(there, extinction * gradientFactor(o, gradient), extinction);
    }
    if (!hasLabels)
        return extinction;
    const F sum = leaf::labelledFunction(beside.labels, extinction) + beside.medium;
    beside.ofLabels = leaf::labelledPart(beside.labels, extinction, beside.medium, sum);
    return sum;
}

} // namespace tessera::TESSERA_LANES
