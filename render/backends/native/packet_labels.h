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

/// Voxels between the samples of the brick that p lies in, as LevelMap::levelAt() has its level.
template <bool Mixed> TESSERA_LANE F ownPitch(const PacketField& f, F3 p, M m) {
    if constexpr (!Mixed)
        return asFloat(shl<23>(I(127 + f.level)));
    const auto brick = [&](F at, int axis) {
        const F inside = min(max(at, F(0.0f)), F(static_cast<float>(f.extentVoxels[axis])));
        return min(sar<5>(truncated(inside)), I(f.grid[axis] - 1));
    };
    const I number = (brick(p.z, 2) * I(f.grid[1]) + brick(p.y, 1)) * I(f.grid[0]) + brick(p.x, 0);
    const I code = gather<4>(f.facts, number, m) & I(7);
    return asFloat(shl<23>(I(127) + select(code == I(leaf::kEmptyCode), I(f.finest), code)));
}

/// Shares at p. Lanes that lack a brick are taken from m.
template <bool Mixed>
inline __attribute__((noinline)) leaf::LabelShares<F> labelsAt(const PacketScene& s, const Here<Mixed>& here,
                                                               const F3& p, M& m) {
    const F3 at = leaf::placeOfLabels(s.optics.labels, p, [&] { return ownPitch<Mixed>(s.field, p, m); });
    return leaf::labelShares<F>(
        s.optics.labels, [&](int channel) { return labelChannel<Mixed>(s.labels[channel], here, at, m); });
}

/// The gradient of the labels' medium. Lanes that lack a brick are taken from m.
template <bool Mixed>
inline __attribute__((noinline)) F3 mediumGradient(const PacketScene& s, const Here<Mixed>& here, const F3& p,
                                                   M& m) {
    const PacketField& f = s.labels[s.optics.labels.solid];
    return leaf::mediumGradient<F>(p, [&](const F3& at) { return labelChannel<Mixed>(f, here, at, m); });
}

} // namespace tessera::TESSERA_LANES
