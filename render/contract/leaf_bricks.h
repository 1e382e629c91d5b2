// render/contract/leaf_bricks.h: weights of bricks of unlike levels beside one another (docs/sampling.md,
// "Value"). For leaves.h and shaders alone: C++ and GLSL in one text.

// Codes of bricks: levels, and
const int kEmptyCode = 6;   // stands as one value
const int kOutsideCode = 7; // of the volume
// Functions of edges, as EdgeFunction of core/scene/scene.h.
const int kNearestEdge = 0;
const int kMinimumEdge = 1;
const int kMaximumEdge = 3;

/// The level whose half sample is the reach of an edge weight between two facing bricks. Towards an empty
/// brick always the other's; between two empty ones the finest level's, so that a volume of one level stays
/// plain trilinear everywhere.
/// @param own, other  codes
/// @param ahead  on the brick's own side; else on the other's
LEAF_OF_CODE Code edgeLevel(Code own, Code other, Bool ahead, int edge, Code finest) {
    Code empty = Code(kEmptyCode);
    Code mine = own;
    Code theirs = other;
    if (edge == kMinimumEdge)
        mine = theirs = min(own, other);
    if (edge == kMaximumEdge)
        mine = theirs = max(own, other);
    Code shown = select(own == empty, select(other == empty, finest, other), own);
    return select(either(own == empty, other == empty), shown, select(ahead, mine, theirs));
}
/// Rises linearly across the boundary of two bricks.
/// @param into  voxels from it into the brick's own side
/// @param perReach  1 / the reach there, a power of two
LEAF V edgeWeight(V into, V perReach) {
    LEAF_LET rising = V(0.5f) + V(0.5f) * (into * perReach);
    return min(max(rising, V(0.0f)), V(1.0f));
}
/// Without a reach: no blend at all.
LEAF V edgeStep(V into, Bool upper) {
    return select(either(into > V(0.0f), both(into == V(0.0f), upper)), V(1.0f), V(0.0f));
}
/// Derivative of edgeWeight() along its axis' coordinate.
LEAF V edgeSlope(V into, V reach, Bool upper) {
    LEAF_LET slope = select(upper, V(0.5f), V(-0.5f)) / reach;
    return select(abs(into) < reach, slope, V(0.0f));
}
