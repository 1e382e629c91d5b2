// render/backends/native/packet_roots.h: crossings of a ray and surfaces of one value inside a piece, for all
// lanes of a packet: twin of render/contract/cell_roots.h. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/contract/cell_roots.h" // how near a root is

namespace tessera::TESSERA_LANES {

struct Cubic {
    F c0, c1, c2, c3;
};
TESSERA_LANE F valueAt(const Cubic& f, F u) {
    return f.c0 + u * (f.c1 + u * (f.c2 + u * f.c3));
}

TESSERA_LANE Cubic cubicThrough(F v0, F v1, F v2, F v3) {
    const F d1 = v1 - v0, d2 = v2 - v1, d3 = v3 - v2;
    const F e1 = d2 - d1, e2 = d3 - d2;
    const F f = e2 - e1;
    return {v0, F(3.0f) * (d1 - F(0.5f) * e1 + f * F(static_cast<float>(1.0 / 3))), F(4.5f) * (e1 - f),
            F(4.5f) * f};
}

/// Between which values cubics stay in [0,1], and a little beyond: their Bernstein coefficients, and more
/// than rounding makes of them. What is no number, or too large, counts as anywhere. Spares a search; what is
/// found does not depend on it.
struct CubicRange {
    F low, high;
};
TESSERA_LANE CubicRange rangeOf(const Cubic& f, F v3) {
    const F third(1.0f / 3.0f), far(kMostFloat);
    const F first = f.c0 + f.c1 * third, second = f.c0 + (F(2.0f) * f.c1 + f.c2) * third;
    const F low = min(min(f.c0, v3), min(first, second)), high = max(max(f.c0, v3), max(first, second));
    const F slack = F(1.0f / 65536.0f) * max(abs(low), abs(high));
    const M known = abs(f.c1) + abs(f.c2) + abs(f.c3) <= far;
    return {select(known, low - slack, F(0.0f) - far), select(known, high + slack, far)};
}
TESSERA_LANE M mayHold(const CubicRange& range, F value) {
    return (range.low <= value) & (value <= range.high);
}

/// Where cubics are monotone: from ends[n] to ends[n + 1], n < count.
struct MonotoneParts {
    I count;
    F ends[4];
};
TESSERA_LANE MonotoneParts monotoneParts(const Cubic& f) {
    const F zero(0.0f), one(1.0f);
    const F most = max(max(abs(f.c1), abs(f.c2)), abs(f.c3));
    const F a = F(3.0f) * (f.c3 / most), b = f.c2 / most, c = f.c1 / most;
    const F square = b * b - a * c;
    const M turns = (most > zero) & (square > zero);
    const F root = sqrt(select(turns, square, one));
    const F q = select(b < zero, root - b, (zero - root) - b);
    const F r1 = select(a == zero, F(2.0f), q / a), r2 = c / q;
    const F low = min(r1, r2), high = max(r1, r2);
    const M first = turns & (low > zero) & (low < one);
    const M second = turns & (high > zero) & (high < one) & (high > low);
    const F lower = select(first, low, select(second, high, one));
    return {I(1) + select(first, I(1), I(0)) + select(second, I(1), I(0)),
            {zero, lower, select(first & second, high, one), one}};
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
        const F middle = a + half * width;
        const F falsi = a + width * (fa / (fa - fb));
        const F delta = pull * width * width;
        const F towards = middle - falsi;
        F u = select(towards > delta, falsi + delta, select(towards < zero - delta, falsi - delta, middle));
        const F most = reach - half * width;
        u = select(u - middle > most, middle + most, u);
        u = select(u - middle < zero - most, middle - most, u);
        u = select((u > a) & (u < b), u, middle);
        const F fu = valueAt(f, u) - isovalue;
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
