// render/contract/leaf_field.h: the field between samples, and its derivative there. For leaves.h and shaders
// alone: C++ and GLSL in one text.

LEAF V partWay(V a, V b, V part) {
    LEAF_LET v = a + part * (b - a);
    return v;
}
LEAF_OF_VEC Vec partWay(LEAF_IN(Vec) a, LEAF_IN(Vec) b, V part) {
    LEAF_LET3 colour = a + part * (b - a);
    return colour;
}

/// Between the eight samples of a cell; vzyx.
LEAF V trilinear(V v000, V v001, V v010, V v011, V v100, V v101, V v110, V v111, V fx, V fy, V fz) {
    LEAF_LET a = partWay(v000, v001, fx), b = partWay(v010, v011, fx);
    LEAF_LET c = partWay(v100, v101, fx), d = partWay(v110, v111, fx);
    return partWay(partWay(a, b, fy), partWay(c, d, fy), fz);
}

/// The derivative of trilinear(), per sample, and its value.
LEAF_STRUCT CellSlope {
    V x, y, z, value;
};
LEAF LEAF_OF(CellSlope)
    trilinearSlope(V v000, V v001, V v010, V v011, V v100, V v101, V v110, V v111, V fx, V fy, V fz) {
    LEAF_LET da = v001 - v000, db = v011 - v010, dc = v101 - v100, dd = v111 - v110;
    LEAF_LET a = v000 + fx * da, b = v010 + fx * db, c = v100 + fx * dc, d = v110 + fx * dd;
    LEAF_LET near = b - a, far = d - c;
    LEAF_LET e = a + fy * near, g = c + fy * far;
    LEAF_LET z = g - e, value = e + fz * z;
    return LEAF_MAKE(
        CellSlope, (partWay(partWay(da, db, fy), partWay(dc, dd, fy), fz), partWay(near, far, fz), z, value));
}
