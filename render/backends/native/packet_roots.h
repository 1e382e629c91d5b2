// render/backends/native/packet_roots.h: crossings of a ray and surfaces of one value inside a piece, for all
// lanes of a packet, by the leaves that render/contract/cell_roots.h has too. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/contract/cell_roots.h" // precision of a root

namespace tessera::TESSERA_LANES {

using Cubic = leaf::CellCubic<F>;

/// The monotone parts of cubics: from ends[n] to ends[n + 1], n < count.
struct MonotoneParts {
    I count;
    F ends[4];
};
TESSERA_LANE MonotoneParts monotoneParts(const Cubic& f) {
    const F zero(0.0f), one(1.0f);
    const leaf::CellTurns<F> turns = leaf::cellTurns(f);
    return {I(1) + select(turns.first < one, I(1), I(0)) + select(turns.second < one, I(1), I(0)),
            {zero, turns.first, turns.second, one}};
}

/// The roots of f - isovalue in [a,b], on whose ends it takes fa and fb, of unlike sides in the lanes of m.
inline __attribute__((noinline)) F bracketedRoot(const Cubic& f, F isovalue, F a, F b, F fa, F fb, M m) {
    const F zero(0.0f), half(0.5f);
    constexpr float kTolerance = rootTolerance<float>();
    const M atEnd = (fa == zero) | (fb == zero);
    F root = select(fa == zero, a, b);
    M found = atEnd, open = m & ~atEnd;
    const F pull = F(0.2f) / (b - a);
    F reach(1.0f);
    for (int turn = 0; turn < kRootTurns<float>; ++turn) {
        const F width = b - a;
        open = open & (width > F(2.0f * kTolerance));
        if (!any(open))
            break;
        const F u = leaf::rootGuess(a, b, fa, fb, pull, reach);
        const F fu = leaf::cubicAt(f, u) - isovalue;
        const M hits = open & (fu == zero);
        root = select(hits, u, root);
        found = found | hits;
        open = open & ~hits;
        const M isBelow = fu < zero, wasBelow = fa < zero;
        const M likeFront = (isBelow & wasBelow) | (~isBelow & ~wasBelow);
        const M front = open & likeFront, back = open & ~likeFront;
        a = select(front, u, a);
        fa = select(front, fu, fa);
        b = select(back, u, b);
        fb = select(back, fu, fb);
        reach = half * reach;
    }
    return select(found, root, a + half * (b - a));
}

} // namespace tessera::TESSERA_LANES
