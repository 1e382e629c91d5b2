// render/contract/leaf_surface.h: a ray inside one cell of trilinear interpolation, where the field along it
// is a cubic; where that crosses a value (render/contract/cell_roots.h). For leaves.h and shaders alone: C++
// and GLSL in one text.

/// c0 + u (c1 + u (c2 + u c3)), u in [0,1].
LEAF_STRUCT CellCubic {
    V c0, c1, c2, c3;
};
LEAF V cubicAt(LEAF_IN(LEAF_OF(CellCubic)) f, V u) {
    LEAF_LET v = f.c0 + u * (f.c1 + u * (f.c2 + u * f.c3));
    return v;
}
/// Through its values at u = 0, 1/3, 2/3, 1; from differences, so that equal values give zeros.
LEAF LEAF_OF(CellCubic) cellCubic(V v0, V v1, V v2, V v3) {
    LEAF_LET d1 = v1 - v0, d2 = v2 - v1, d3 = v3 - v2;
    LEAF_LET e1 = d2 - d1, e2 = d3 - d2, g = e2 - e1;
    LEAF_LET c1 = V(3.0f) * (d1 - V(0.5f) * e1 + g * (V(1.0f) / V(3.0f)));
    LEAF_LET c2 = V(4.5f) * (e1 - g), c3 = V(4.5f) * g;
    return LEAF_MAKE(CellCubic, (v0, c1, c2, c3));
}

/// Bounds of a cubic's values in [0,1], and a little beyond: its Bernstein coefficients, widened by more than
/// their rounding. A value that is no number, or too large, counts as anywhere. This spares a search; the
/// roots found do not depend on it.
LEAF_STRUCT CellRange {
    V low, high;
};
LEAF LEAF_OF(CellRange) cellRange(LEAF_IN(LEAF_OF(CellCubic)) f, V v3, V largest) {
    LEAF_LET third = V(1.0f) / V(3.0f);
    LEAF_LET first = f.c0 + f.c1 * third, second = f.c0 + (V(2.0f) * f.c1 + f.c2) * third;
    LEAF_LET low = min(min(f.c0, v3), min(first, second));
    LEAF_LET high = max(max(f.c0, v3), max(first, second));
    LEAF_LET slack = V(1.0f / 65536.0f) * max(abs(low), abs(high));
    LEAF_LET size = abs(f.c1) + abs(f.c2) + abs(f.c3);
    LEAF_LET from = low - slack, to = high + slack, least = V(0.0f) - largest;
    return LEAF_MAKE(CellRange, (select(size <= largest, from, least), select(size <= largest, to, largest)));
}
LEAF Bool mayHold(LEAF_IN(LEAF_OF(CellRange)) range, V value) {
    return both(range.low <= value, value <= range.high);
}

/// Turning points of a cubic in (0,1), ascending; 1 where it does not turn, or no more.
LEAF_STRUCT CellTurns {
    V first, second;
};
LEAF LEAF_OF(CellTurns) cellTurns(LEAF_IN(LEAF_OF(CellCubic)) f) {
    LEAF_LET zero = V(0.0f), one = V(1.0f);
    LEAF_LET most = max(max(abs(f.c1), abs(f.c2)), abs(f.c3));
    // a u^2 + 2 b u + c, scaled so that no product overflows.
    LEAF_LET a = V(3.0f) * (f.c3 / most), b = f.c2 / most, c = f.c1 / most;
    LEAF_LET square = b * b - a * c;
    Bool turns = both(most > zero, square > zero);
    LEAF_LET root = sqrt(select(turns, square, one));
    LEAF_LET above = root - b, below = (zero - root) - b, q = select(b < zero, above, below);
    LEAF_LET ratio = q / a, r1 = select(a == zero, V(2.0f), ratio), r2 = c / q;
    LEAF_LET low = min(r1, r2), high = max(r1, r2);
    Bool lowCounts = both(turns, both(low > zero, low < one));
    Bool highCounts = both(turns, both(both(high > zero, high < one), high > low));
    return LEAF_MAKE(CellTurns, (select(lowCounts, low, select(highCounts, high, one)),
                                 select(both(lowCounts, highCounts), high, one)));
}

/// The next place to evaluate for the root of a monotone f in [a,b], on whose ends it takes fa and fb, of
/// unlike sides: ITP. Never outside of the bracket, whatever the values, no numbers included.
/// @param pull  0.2 / (b - a) of the first bracket
/// @param reach  half of what bisection, begun one turn later, would have left
LEAF V rootGuess(V a, V b, V fa, V fb, V pull, V reach) {
    LEAF_LET zero = V(0.0f), width = b - a, middle = a + V(0.5f) * width;
    LEAF_LET falsi = a + width * (fa / (fa - fb));
    LEAF_LET delta = pull * width * width; // from regula falsi's place towards the middle
    LEAF_LET towards = middle - falsi, ahead = falsi + delta, behind = falsi - delta;
    LEAF_LET u = select(towards > delta, ahead, select(towards < zero - delta, behind, middle));
    LEAF_LET most = reach - V(0.5f) * width, above = middle + most, below = middle - most;
    LEAF_LET v = select(u - middle > most, above, u);
    LEAF_LET w = select(v - middle < zero - most, below, v);
    return select(both(w > a, w < b), w, middle);
}

/// A plane of sample centres that starts a piece sooner than this, in voxels, is one that rounding has left
/// before the piece.
const float kPlaneMargin = 1.0f / 2048.0f;
/// The first plane of sample centres that a ray meets along an axis, in segments from `from`.
/// @param d  of a segment along the axis, voxels, not 0
/// @param w  behind which, segments
/// @param least  w and the margin
LEAF V planeBehind(V from, V d, V w, V pitch, V least) {
    Bool up = d > V(0.0f);
    LEAF_LET x = (from + w * d) / pitch - V(0.5f);
    LEAF_LET ahead = select(up, V(1.0f), V(-1.0f));
    LEAF_LET plane = select(up, floor(x), ceil(x)) + ahead;
    LEAF_LET at = ((plane + V(0.5f)) * pitch - from) / d;
    LEAF_LET after = ((plane + ahead + V(0.5f)) * pitch - from) / d;
    return select(at > least, at, after);
}
