// render/contract/leaf_cubic.h: cubic B-splines about a place in a cell, of the samples -1, 0, 1, 2
// (docs/sampling.md, "Value"). For leaves.h and shaders alone: C++ and GLSL in one text.

/// Of each sample; and what the derivative takes of the differences between each and the next. So it is
/// exactly 0 where all are the same.
LEAF_STRUCT CubicWeights {
    V value[4], step[3];
};
LEAF LEAF_OF(CubicWeights) cubicWeights(V f) {
    LEAF_LET one = V(1.0f);
    LEAF_LET sixth = one / V(6.0f);
    LEAF_LET g = one - f;
    LEAF_LET ff = f * f;
    LEAF_LET gg = g * g;
    LEAF_LET first = sixth * gg * g;
    LEAF_LET last = sixth * ff * f;
    LEAF_LET low = V(2.0f) / V(3.0f) - ff * (one - V(0.5f) * f);
    LEAF_LET high = ((one - first) - low) - last;
    LEAF_LET behind = V(0.5f) * gg;
    LEAF_LET here = V(0.5f) + f * g;
    LEAF_LET ahead = V(0.5f) * ff;
    LEAF_OF(CubicWeights) w;
    w.value[0] = first;
    w.value[1] = low;
    w.value[2] = high;
    w.value[3] = last;
    w.step[0] = behind;
    w.step[1] = here;
    w.step[2] = ahead;
    return w;
}

/// Of four samples in a row, or of four rows that are smoothed.
LEAF V cubicValue(LEAF_IN(LEAF_OF(CubicWeights)) w, V a, V b, V c, V d) {
    LEAF_LET sum = w.value[0] * a + w.value[1] * b + w.value[2] * c + w.value[3] * d;
    return sum;
}
LEAF V cubicStep(LEAF_IN(LEAF_OF(CubicWeights)) w, V a, V b, V c, V d) {
    LEAF_LET sum = w.step[0] * (b - a) + w.step[1] * (c - b) + w.step[2] * (d - c);
    return sum;
}
