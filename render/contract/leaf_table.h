// render/contract/leaf_table.h: places in a table of a function, in units of its entries, and the values
// between two of them (docs/sampling.md, "Integrators"). For leaves.h and shaders alone: C++ and GLSL in one
// text.

/// Beyond this, places stay; values that far outside of the table differ in nothing.
const float kFarPlace = 4194304.0f; // 2^22
/// Of a value, also beyond the table.
LEAF V farPlaceOf(V stored, V scale, V offset) {
    LEAF_LET x = stored * scale + offset;
    LEAF_LET above = select(x > V(-kFarPlace), x, V(-kFarPlace)); // also where it is no number
    return select(above < V(kFarPlace), above, V(kFarPlace));
}
/// On the table; a value that is no number is its first place. Not clamp(), which may keep that.
LEAF V heldPlace(V place, V last) {
    return min(select(place > V(0.0f), place, V(0.0f)), last);
}

/// One end of a segment for pre-integration: its place in the table, the bin that holds it, and the bin's
/// entry (extinctionBins()).
LEAF_STRUCT BinEnd {
    V place, bin, x, y, z, w;
};
/// Extinction, averaged over the values between two ends; exact for the table but for rounding. Zero exactly
/// where every entry around these values is zero.
/// @param low, high  by place
LEAF V meanExtinction(LEAF_IN(LEAF_OF(BinEnd)) low, LEAF_IN(LEAF_OF(BinEnd)) high) {
    LEAF_LET one = V(1.0f), f = low.place - low.bin, g = high.place - high.bin;
    LEAF_LET inside = low.x + (V(0.5f) * (f + g)) * low.y;
    LEAF_LET width = high.place - low.place;
    LEAF_LET above = g * (high.x + (V(0.5f) * g) * high.y);
    LEAF_LET below = (one - f) * (low.x + (V(0.5f) * (one + f)) * low.y);
    LEAF_LET beside = below + above; // nothing cancels, however close they are
    LEAF_LET under = f * (low.x + (V(0.5f) * f) * low.y);
    LEAF_LET sum = max((high.z - low.z) + ((high.w - low.w) + (above - under)), V(0.0f));
    LEAF_LET mean = select(low.bin + one == high.bin, beside, sum) / width;
    return select(low.bin == high.bin, inside, mean);
}

/// A sum over values: the part of the first bin, the bins between by two sums from the table's start, each in
/// two floats, and the part of the last.
LEAF V sumOverBins(V first, V start, V startRest, V end, V endRest, V last) {
    LEAF_LET between = (end - start) + (endRest - startRest);
    LEAF_LET sum = (first + between) + last;
    return sum;
}

/// Between four entries of a table by two places.
LEAF_OF_VEC Vec bilinear(LEAF_IN(Vec) c00, LEAF_IN(Vec) c10, LEAF_IN(Vec) c01, LEAF_IN(Vec) c11, V fx, V fy) {
    return partWay(partWay(c00, c10, fx), partWay(c01, c11, fx), fy);
}
