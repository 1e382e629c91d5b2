// render/contract/cell_roots.h: the crossings of a ray and a surface of one value inside one cell of
// trilinear interpolation: roots of a cubic, by the leaves of leaf_surface.h.
//
// Along a line trilinear interpolation is a cubic. So a piece of a ray inside one cell can hold up to three
// crossings, and two with both ends on one side of the surface. A test of the ends alone misses those. The
// piece is cut where the cubic's derivative is zero (G. Marmitt et al., Fast and Accurate Ray-Voxel
// Intersection Techniques for Iso-Surface Ray Tracing, 2004). Where a monotone part changes sides, a
// bracketed method closes in on the place: ITP (I. Oliveira, R. Takahashi, An Enhancement of the Bisection
// Method Average Performance Preserving Minmax Optimality, 2020), which is never slower than bisection by
// more than a turn.
//
// A value is on one of two sides: below the isovalue, or not. Ends that pieces share have one value, so a
// surface through a shared end is met once. One that only touches from above, or a cell that is all of the
// isovalue, is not met at all.
#pragma once

#include "render/contract/leaves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace tessera {

template <typename Real> using CellCubic = leaf::CellCubic<Real>;

/// The monotone parts of a cubic: from ends[i] to ends[i+1], i < count.
template <typename Real> struct MonotoneParts {
    int count = 1;
    Real ends[4] = {Real(0), Real(1), Real(1), Real(1)};
};
template <typename Real> MonotoneParts<Real> monotoneParts(const CellCubic<Real>& f) {
    const leaf::CellTurns<Real> turns = leaf::cellTurns(f);
    const Real one(1);
    return {1 + (turns.first < one) + (turns.second < one), {Real(0), turns.first, turns.second, one}};
}

/// The precision of bracketedRoot(), as a part of the piece, and the most turns that it takes.
template <typename Real> constexpr int kRootTurns = std::numeric_limits<Real>::digits - 1; // 23 and 52
template <typename Real> constexpr Real rootTolerance() {
    return Real(2) * std::numeric_limits<Real>::epsilon(); // 2^-22 and 2^-51
}

/// The root of f - isovalue in [a,b], on whose ends it takes fa and fb, of unlike sides; f monotone there.
/// Stays in [a,b] whatever the values, no numbers included.
template <typename Real>
Real bracketedRoot(const CellCubic<Real>& f, Real isovalue, Real a, Real b, Real fa, Real fb) {
    if (fa == Real(0))
        return a;
    if (fb == Real(0))
        return b;
    const Real tolerance = rootTolerance<Real>();
    const Real pull = Real(0.2) / (b - a);
    Real reach = Real(1); // half of what bisection, begun one turn later, would have left
    for (int turn = 0; turn < kRootTurns<Real>; ++turn) {
        const Real width = b - a;
        if (!(width > Real(2) * tolerance))
            break;
        const Real u = leaf::rootGuess(a, b, fa, fb, pull, reach);
        const Real fu = leaf::cubicAt(f, u) - isovalue;
        if (fu == Real(0))
            return u;
        if ((fu < Real(0)) == (fa < Real(0))) {
            a = u;
            fa = fu;
        } else {
            b = u;
            fb = fu;
        }
        reach = Real(0.5) * reach;
    }
    return a + Real(0.5) * (b - a);
}

/// Calls visit(u, surface) for every crossing of a piece, in the order of u; those of one place in the order
/// of their values along the ray. At most three of each surface.
/// @param v0,v1,v2,v3  the field at u = 0, 1/3, 2/3, 1
/// @param isovalues    ascending
template <typename Real, typename Visit>
void forEachCrossing(Real v0, Real v1, Real v2, Real v3, std::span<const Real> isovalues,
                     const Visit& visit) {
    const CellCubic<Real> f = leaf::cellCubic(v0, v1, v2, v3);
    const MonotoneParts<Real> parts = monotoneParts(f);
    Real front = v0;
    for (int part = 0; part < parts.count; ++part) {
        const Real a = parts.ends[part], b = parts.ends[part + 1];
        const Real back = part + 1 == parts.count ? v3 : leaf::cubicAt(f, b);
        const bool rises = back > front;
        for (std::size_t n = 0; n < isovalues.size(); ++n) {
            const std::size_t surface = rises ? n : isovalues.size() - 1 - n;
            const Real isovalue = isovalues[surface];
            if ((front < isovalue) != (back < isovalue))
                visit(bracketedRoot(f, isovalue, a, b, front - isovalue, back - isovalue), surface);
        }
        front = back;
    }
}

} // namespace tessera
