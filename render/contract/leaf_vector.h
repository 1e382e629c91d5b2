// render/contract/leaf_vector.h: sums of products in a written order. For leaves.h and shaders alone: C++ and
// GLSL in one text.

LEAF V heldToOne(V x) {
    return min(V(1.0f), max(V(0.0f), x));
}

LEAF_OF_VEC V dot3(LEAF_IN(Vec) a, LEAF_IN(Vec) b) {
    LEAF_LET sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}
LEAF_OF_VEC V length3(LEAF_IN(Vec) v) {
    LEAF_LET length = sqrt(dot3(v, v));
    return length;
}

/// By a matrix, column by column.
LEAF_OF_MATRIX Vec transformed(LEAF_IN(Mat) m, LEAF_IN(Vec) v) {
    LEAF_LET3 t = v.x * m[0] + v.y * m[1] + v.z * m[2];
    return t;
}
