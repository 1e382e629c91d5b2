// render/contract/leaf_opacity.h: the opacity of a segment and compositing front to back (docs/sampling.md,
// "Ray"). Exponentials are written out: drivers' own differ by many ulp. For leaves.h and shaders alone: C++
// and GLSL in one text.

/// 1 - exp(-x) in float, x not negative: a polynomial below, a written-out exponential from there on.
const float kOneMinusExpBelow = 0.25f;
LEAF V oneMinusExpBelow(V x) {
    LEAF_LET one = V(1.0f);
    LEAF_LET v =
        x * (one - x * V(1.0f / 2.0f) *
                       (one - x * V(1.0f / 3.0f) *
                                  (one - x * V(1.0f / 4.0f) *
                                             (one - x * V(1.0f / 5.0f) * (one - x * V(1.0f / 6.0f))))));
    return v;
}
LEAF V oneMinusExpAbove(V x) {
    LEAF_LET one = V(1.0f);
    LEAF_LET y = max(x * V(-1.44269504f), V(-126.0f)), n = floor(y);
    LEAF_LET r = (y - n) * V(0.693147181f); // 2^(y-n) = e^r
    LEAF_LET p =
        one +
        r * (one +
             r * V(1.0f / 2.0f) *
                 (one + r * V(1.0f / 3.0f) *
                            (one + r * V(1.0f / 4.0f) *
                                       (one + r * V(1.0f / 5.0f) *
                                                  (one + r * V(1.0f / 6.0f) *
                                                             (one + r * V(1.0f / 7.0f) *
                                                                        (one + r * V(1.0f / 8.0f))))))));
    LEAF_LET v = one - p * powerOfTwo(n);
    return v;
}

/// Mean position that a segment of constant extinction is seen at, over its light, as a share of the way to
/// its back: 1/x - 1/(e^x - 1), x its optical depth.
LEAF V seenDepth(V depth, V alpha) {
    LEAF_LET one = V(1.0f), s = depth * depth;
    LEAF_LET c1 = one / V(12.0f), c2 = one / V(720.0f), c3 = one / V(30240.0f);
    LEAF_LET c4 = one / V(1209600.0f), c5 = one / V(47900160.0f);
    LEAF_LET c6 = V(691.0f) / V(90.0f) / V(14529715200.0f); // over 15!, which no float is
    LEAF_LET thin = V(0.5f) - depth * (c1 - s * (c2 - s * (c3 - s * (c4 - s * (c5 - s * c6)))));
    LEAF_LET thick = one / depth - (one - alpha) / alpha;
    return select(depth < V(0.5f), thin, thick);
}

/// Composites a colour with an opacity behind a ray's colour so far, front to back. The weight is the true
/// growth of alpha: near 1 it no longer grows, and colours must not either.
/// @param sum  premultiplied
/// @param colour  not premultiplied
LEAF_OF_VEC void compositeBehind(LEAF_INOUT(Vec) sum, LEAF_INOUT(V) alpha, LEAF_IN(Vec) colour, V opacity) {
    LEAF_LET after = alpha + (V(1.0f) - alpha) * opacity; // exactly 1 where the opacity is
    LEAF_LET weight = after - alpha;
    LEAF_LET3 gathered = sum + weight * colour;
    sum = gathered;
    alpha = after;
}
