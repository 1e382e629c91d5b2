// render/backends/native/packet_labels.h: labels of samples (docs/sampling.md, "Labels"), for all lanes of a
// packet. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/packet_field.h"

namespace tessera::TESSERA_LANES {

using native::PacketScene;

/// A channel's factor at p. Lanes that lack a brick are taken from m.
template <bool Mixed> TESSERA_LANE F labelChannel(const PacketField& f, const Here<Mixed>& here, F3 p, M& m) {
    const F3 x = inBrick(here, p);
    return F(1 / leaf::kLightOne) * valueAt<SampleKind::u16>(f, here, p, x, m & isHere(here, x), m);
}

/// Shares at p. Lanes that lack a brick are taken from m.
template <bool Mixed>
inline __attribute__((noinline)) leaf::LabelShares<F> labelsAt(const PacketScene& s, const Here<Mixed>& here,
                                                               const F3& p, M& m) {
    return leaf::labelShares<F>(
        s.optics.labels, [&](int channel) { return labelChannel<Mixed>(s.labels[channel], here, p, m); });
}

/// The gradient of the labels' medium. Lanes that lack a brick are taken from m.
template <bool Mixed>
inline __attribute__((noinline)) F3 mediumGradient(const PacketScene& s, const Here<Mixed>& here, const F3& p,
                                                   M& m) {
    const PacketField& f = s.labels[s.optics.labels.solid];
    return leaf::mediumGradient<F>(p, [&](const F3& at) { return labelChannel<Mixed>(f, here, at, m); });
}

} // namespace tessera::TESSERA_LANES
