// render/contract/leaf_field.h: the field between samples, and its derivative there. For leaves.h and shaders
// alone: C++ and GLSL in one text.

LEAF V mixed(V a, V b, V part) {
    LEAF_LET v = a + part * (b - a);
    return v;
}
LEAF_OF_VEC Vec mixedColours(LEAF_IN(Vec) a, LEAF_IN(Vec) b, V part) {
    LEAF_LET3 colour = a + part * (b - a);
    return colour;
}

/// Between the eight samples of a cell; vzyx.
LEAF V trilinear(V v000, V v001, V v010, V v011, V v100, V v101, V v110, V v111, V fx, V fy, V fz) {
    LEAF_LET a = mixed(v000, v001, fx);
    LEAF_LET b = mixed(v010, v011, fx);
    LEAF_LET c = mixed(v100, v101, fx);
    LEAF_LET d = mixed(v110, v111, fx);
    return mixed(mixed(a, b, fy), mixed(c, d, fy), fz);
}

/// The derivative of trilinear(), per sample, and its value.
LEAF_STRUCT CellSlope {
    V x, y, z, value;
};
LEAF LEAF_OF(CellSlope)
    trilinearSlope(V v000, V v001, V v010, V v011, V v100, V v101, V v110, V v111, V fx, V fy, V fz) {
    LEAF_LET da = v001 - v000;
    LEAF_LET db = v011 - v010;
    LEAF_LET dc = v101 - v100;
    LEAF_LET dd = v111 - v110;
    LEAF_LET a = v000 + fx * da;
    LEAF_LET b = v010 + fx * db;
    LEAF_LET c = v100 + fx * dc;
    LEAF_LET d = v110 + fx * dd;
    LEAF_LET near = b - a;
    LEAF_LET far = d - c;
    LEAF_LET e = a + fy * near;
    LEAF_LET g = c + fy * far;
    LEAF_LET z = g - e;
    LEAF_LET value = e + fz * z;
    LEAF_OF(CellSlope) slope;
    slope.x = mixed(mixed(da, db, fy), mixed(dc, dd, fy), fz);
    slope.y = mixed(near, far, fz);
    slope.z = z;
    slope.value = value;
    return slope;
}
