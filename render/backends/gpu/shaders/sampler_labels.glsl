// sampler_labels.glsl: labels of samples (docs/sampling.md, "Labels"), as labelShares() and mediumGradient() of
// render/contract/leaves.h have them.
// Needs FEATURE_LABELS, FEATURE_SHADING, sampler_channels.glsl. Gives labelsAt(p), mediumGradient(p), labelled(shares, part, colour).

#if FEATURE_LABELS
#include "leaf_labels.h"

uniform sampler3D uLabelTexels, uLabelStanding;         // the first four channels
uniform sampler3D uMoreLabelTexels, uMoreLabelStanding; // the others
uniform int uLabelPlain, uLabelTinted, uLabelSolid, uLabelDense, uLabelColour; // channels; -1: none
uniform float uLabelDensity;

float labelChannel(vec4 first, vec4 more, int channel) {
    if (channel < 0) return 0.0;
    return channel < 4 ? first[channel] : more[channel - 4];
}

LabelShares labelsAt(vec3 p) {
    precise vec4 first = channelsAt(uLabelTexels, uLabelStanding, p) * (1.0 / 16384.0);
    precise vec4 more = vec4(0.0);
    if (max(uLabelColour + 2, uLabelSolid) >= 4) more = channelsAt(uMoreLabelTexels, uMoreLabelStanding, p) * (1.0 / 16384.0);
    LabelShares shares = LabelShares(labelChannel(first, more, uLabelPlain), labelChannel(first, more, uLabelTinted),
                                     labelChannel(first, more, uLabelSolid), 0.0, 0.0, 0.0, 0.0);
    shares.dense = uLabelDense < 0 ? shares.solid : labelChannel(first, more, uLabelDense);
    if (uLabelColour < 0) return shares;
    shares.red = labelChannel(first, more, uLabelColour);
    shares.green = labelChannel(first, more, uLabelColour + 1);
    shares.blue = labelChannel(first, more, uLabelColour + 2);
    return shares;
}

#if FEATURE_SHADING
float solidAt(vec3 p) { // its channel is one of the first four
    precise vec4 first = channelsAt(uLabelTexels, uLabelStanding, p) * (1.0 / 16384.0);
    return first[uLabelSolid];
}

vec3 mediumGradient(vec3 p) {
    vec3 slope = vec3(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        TURNS(10);
        vec3 before = p;
        vec3 after = p;
        precise float low = p[axis] - kLabelReach;
        precise float high = p[axis] + kLabelReach;
        before[axis] = low;
        after[axis] = high;
        slope[axis] = mediumSlope(solidAt(before), solidAt(after));
    }
    return slope;
}
#endif

vec3 labelled(LabelShares shares, float part, vec3 colour) {
    if (uLabelColour < 0) return colour;
    return vec3(labelledColour(shares, colour.r, shares.red, part), labelledColour(shares, colour.g, shares.green, part),
                labelledColour(shares, colour.b, shares.blue, part));
}
#endif
