// render/contract/cell_roots.h: the crossings of a ray and a surface of one value inside one cell of
// trilinear interpolation: roots of a cubic. The C++ twin of shaders/march_surface.glsl: in float the same
// operations in the same order.
//
// Along a line trilinear interpolation is a cubic, so that a piece of a ray inside one cell can hold up to
// three crossings, and two with both ends on one side of the surface: a test of the ends alone misses those.
// The piece is cut where the cubic's derivative is zero (G. Marmitt et al., Fast and Accurate Ray-Voxel
// Intersection Techniques for Iso-Surface Ray Tracing, 2004), and where a monotone part changes
// sides, a bracketed method closes in on the place: ITP (I. Oliveira, R. Takahashi, An Enhancement of the
// Bisection Method Average Performance Preserving Minmax Optimality, 2020), which is never slower than
// bisection by more than a turn.
//
// Which side a value is on: below the isovalue, or not. Ends that pieces share have one value, so that a
// surface through a shared end is met once, and one that only touches from above, or a cell that is all of
// the isovalue, not at all.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace tessera {

/// c0 + u (c1 + u (c2 + u c3)), u in [0,1].
template <typename Real> struct CellCubic {
    Real c0, c1, c2, c3;
    Real operator()(Real u) const { return c0 + u * (c1 + u * (c2 + u * c3)); }
};

/// Through its values at u = 0, 1/3, 2/3, 1; from differences, so that equal values give zeros.
template <typename Real> CellCubic<Real> cellCubic(Real v0, Real v1, Real v2, Real v3) {
    const Real d1 = v1 - v0, d2 = v2 - v1, d3 = v3 - v2;
    const Real e1 = d2 - d1, e2 = d3 - d2;
    const Real f = e2 - e1;
    return {v0, Real(3) * (d1 - Real(0.5) * e1 + f * Real(1.0 / 3)), Real(4.5) * (e1 - f), Real(4.5) * f};
}

/// Where a cubic is monotone: from ends[i] to ends[i+1], i < count.
template <typename Real> struct MonotoneParts {
    int count = 1;
    Real ends[4] = {Real(0), Real(1), Real(1), Real(1)};
};
template <typename Real> MonotoneParts<Real> monotoneParts(const CellCubic<Real>& f) {
    MonotoneParts<Real> parts;
    const Real most = std::max(std::max(std::abs(f.c1), std::abs(f.c2)), std::abs(f.c3));
    if (!(most > Real(0)))
        return parts; // constant
    // a u^2 + 2 b u + c, scaled so that no product overflows.
    const Real a = Real(3) * (f.c3 / most), b = f.c2 / most, c = f.c1 / most;
    const Real square = b * b - a * c;
    if (!(square > Real(0)))
        return parts;
    const Real root = std::sqrt(square);
    const Real q = b < Real(0) ? root - b : -root - b;
    const Real r1 = a == Real(0) ? Real(2) : q / a, r2 = c / q;
    const Real low = std::min(r1, r2), high = std::max(r1, r2);
    if (low > Real(0) && low < Real(1)) {
        parts.ends[parts.count] = low;
        ++parts.count;
    }
    if (high > Real(0) && high < Real(1) && high > low) {
        parts.ends[parts.count] = high;
        ++parts.count;
    }
    parts.ends[parts.count] = Real(1);
    return parts;
}

/// How near bracketedRoot() comes, as a part of the piece, and the turns that takes at most.
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
        const Real middle = a + Real(0.5) * width;
        const Real falsi = a + width * (fa / (fa - fb));
        const Real delta = pull * width * width; // from regula falsi's place towards the middle
        const Real towards = middle - falsi;
        Real u = towards > delta ? falsi + delta : towards < -delta ? falsi - delta : middle;
        const Real most = reach - Real(0.5) * width;
        if (u - middle > most)
            u = middle + most;
        if (u - middle < -most)
            u = middle - most;
        if (!(u > a && u < b))
            u = middle;
        const Real fu = f(u) - isovalue;
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
    const CellCubic<Real> f = cellCubic(v0, v1, v2, v3);
    const MonotoneParts<Real> parts = monotoneParts(f);
    Real front = v0;
    for (int part = 0; part < parts.count; ++part) {
        const Real a = parts.ends[part], b = parts.ends[part + 1];
        const Real back = part + 1 == parts.count ? v3 : f(b);
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
