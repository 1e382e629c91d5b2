// render/contract/leaf_labels.h: the effect of labels on a segment (docs/sampling.md, "Labels"). For leaves.h
// and shaders alone: C++ and GLSL in one text.

/// Differences of the medium's share are taken over this many voxels of level 0 to either side; and stored
/// units that its whole share counts as for the length of a gradient.
const float kLabelReach = 2.0f;
const float kLabelSteepness = 1e4f;

/// The border of the medium, as its share there: nothing of it lies where its share is less.
const float kLabelBorder = 0.42f;

/// The middle of the sample that holds a place, along an axis: there nearest borders take factors.
/// @param pitch, perVoxel  of samples there, voxels, a power of two; and its inverse
LEAF V middleOfSample(V p, V pitch, V perVoxel) {
    LEAF_LET middle = (floor(p * perVoxel) + V(0.5f)) * pitch;
    return middle;
}

LEAF_STRUCT LabelShares {
    V plain, tinted, solid;
    V dense;            // solid times the medium's extinction there, relative to the densest
    V red, green, blue; // times tinted + solid
};
/// The extinction of the function's share, and of the labels' medium.
LEAF V labelledFunction(LEAF_IN(LEAF_OF(LabelShares)) shares, V extinction) {
    LEAF_LET taken = extinction * (shares.plain + shares.tinted);
    return taken;
}
LEAF V labelledMedium(LEAF_IN(LEAF_OF(LabelShares)) shares, V density) {
    LEAF_LET inside = heldToOne((shares.solid - V(kLabelBorder)) * V(1.0f / (1.0f - kLabelBorder)));
    LEAF_LET own = density * inside * (shares.dense / shares.solid);
    return select(inside > V(0.0f), own, V(0.0f));
}
/// Of the medium along an axis, stored units per voxel.
/// @param low, high  its shares before and behind
LEAF V mediumSlope(V low, V high) {
    LEAF_LET slope = (high - low) * V(kLabelSteepness / (2.0f * kLabelReach));
    return slope;
}
/// The share of a segment's light that has the labels' colour.
/// @param extinction  the function's, before shares
/// @param sum  of both above, more than 0
LEAF V labelledPart(LEAF_IN(LEAF_OF(LabelShares)) shares, V extinction, V medium, V sum) {
    LEAF_LET coloured = extinction * shares.tinted + medium;
    LEAF_LET part = heldToOne(coloured / sum);
    return part;
}
/// A component of the colour.
/// @param label  of the shares
LEAF V labelledColour(LEAF_IN(LEAF_OF(LabelShares)) shares, V colour, V label, V part) {
    LEAF_LET whole = shares.tinted + shares.solid;
    LEAF_LET own = select(whole > V(0.0f), label / whole, colour);
    LEAF_LET mixed = colour + part * (own - colour);
    return mixed;
}
