// render/contract/leaf_fusion.h: samples of several volumes at one place (docs/sampling.md, "Several
// volumes"). For leaves.h and shaders alone: C++ and GLSL in one text.

/// As Fusion of core/scene/scene.h.
const int kFusionMix = 0;
const int kFusionOver = 1;
const int kFusionMaximum = 2;

/// Of the volumes up to one: extinction per mm, and colour.
LEAF_STRUCT Fused {
    V extinction;
    V red, green, blue;
};
/// A component of the mean of two colours. That of the second where nothing was before, exactly.
/// @param part  of the second
LEAF V fusedColour(V before, V colour, V part) {
    LEAF_LET mixed = before + part * (colour - before);
    return select(part >= V(1.0f), colour, mixed);
}
/// The greatest of a component times extinction, over the greatest extinction.
LEAF V greatestColour(V before, V weight, V colour, V extinction, V most) {
    LEAF_LET both = max(before * weight, colour * extinction) / most;
    return select(weight > V(0.0f), both, colour);
}
/// Adds a volume that shows something.
/// @param rule  kFusion...
/// @param extinction  per mm, more than 0
/// @param opacity  of the unit distance of its function
LEAF LEAF_OF(Fused)
    fusedWith(LEAF_IN(LEAF_OF(Fused)) before, int rule, V extinction, V opacity, V red, V green, V blue) {
    LEAF_LET had = before.extinction;
    if (rule == kFusionMaximum) {
        LEAF_LET most = max(had, extinction);
        return LEAF_MAKE(Fused, (most, greatestColour(before.red, had, red, extinction, most),
                                 greatestColour(before.green, had, green, extinction, most),
                                 greatestColour(before.blue, had, blue, extinction, most)));
    }
    LEAF_LET left = rule == kFusionOver ? had - opacity * had : had;
    LEAF_LET sum = extinction + left, part = extinction / sum;
    return LEAF_MAKE(Fused, (sum, fusedColour(before.red, red, part), fusedColour(before.green, green, part),
                             fusedColour(before.blue, blue, part)));
}
