// render/contract/leaf_cubic.h: cubic B-splines about a place in a cell, of the samples -1, 0, 1, 2
// (docs/sampling.md, "Value"). For leaves.h and shaders alone: C++ and GLSL in one text.

/// Weights of the four samples; and of the three differences between each and the next, for the derivative.
/// So it is exactly 0 where all are the same.
LEAF_STRUCT CubicWeights {
    V v0, v1, v2, v3, d0, d1, d2;
};
LEAF LEAF_OF(CubicWeights) cubicWeights(V f) {
    LEAF_LET one = V(1.0f), sixth = one / V(6.0f);
    LEAF_LET g = one - f, ff = f * f, gg = g * g;
    LEAF_LET first = sixth * gg * g, last = sixth * ff * f;
    LEAF_LET low = V(2.0f) / V(3.0f) - ff * (one - V(0.5f) * f);
    LEAF_LET high = ((one - first) - low) - last;
    LEAF_LET behind = V(0.5f) * gg, here = V(0.5f) + f * g, ahead = V(0.5f) * ff;
    return LEAF_MAKE(CubicWeights, (first, low, high, last, behind, here, ahead));
}

/// Of four samples in a row, or of four rows that are smoothed.
LEAF V cubicValue(LEAF_IN(LEAF_OF(CubicWeights)) w, V a, V b, V c, V d) {
    LEAF_LET sum = w.v0 * a + w.v1 * b + w.v2 * c + w.v3 * d;
    return sum;
}
LEAF V cubicStep(LEAF_IN(LEAF_OF(CubicWeights)) w, V a, V b, V c, V d) {
    LEAF_LET sum = w.d0 * (b - a) + w.d1 * (c - b) + w.d2 * (d - c);
    return sum;
}
