// sampler_labels.glsl: labels of samples (docs/sampling.md, "Labels"), as labelShares() and mediumGradient() of
// render/contract/leaves.h have them.
// Needs FEATURE_LABELS, FEATURE_FUSED, sampler_channels.glsl. Gives HAS_LABELS, labelsAt(p, extinction, gradient),
// labelled(shares, part, colour).

#if FEATURE_LABELS
#include "leaf_labels.h"

OF_VOLUME sampler3D uLabelTexels; // the first four channels
OF_VOLUME sampler3D uLabelStanding;
OF_VOLUME sampler3D uMoreLabelTexels; // the others
OF_VOLUME sampler3D uMoreLabelStanding;
OF_VOLUME int uLabelPlain; // channels; -1: none
OF_VOLUME int uLabelTinted;
OF_VOLUME int uLabelSolid;
OF_VOLUME int uLabelDense;
OF_VOLUME int uLabelColour;
OF_VOLUME float uLabelDensity;
#if FEATURE_FUSED
OF_VOLUME int uHasLabels;
#define HAS_LABELS (uHasLabels != 0)
#else
#define HAS_LABELS true
#endif
OF_VOLUME int uLabelSlopes; // 6 where a medium is lit, else 0

OF_VOLUME int uLabelNearest; // 1: a place has the factors of the sample that holds it

vec3 placeOfLabels(vec3 p) {
    if (uLabelNearest == 0) return p;
#if FEATURE_MIXED
    Place place = placeOf(p);
    uint code = codeOf(cornerTexel(place.corner), place.current);
    int level = int(code == kCodeEmpty ? uint(uFinest) : code);
    float perVoxel = samplesPerVoxel(level);
    float pitch = samplesPerVoxel(-level);
#else
    float perVoxel = uSamplesPerVoxel;
    float pitch = 1.0 / uSamplesPerVoxel;
#endif
    return vec3(middleOfSample(p.x, pitch, perVoxel), middleOfSample(p.y, pitch, perVoxel), middleOfSample(p.z, pitch, perVoxel));
}

float labelChannel(vec4 first, vec4 more, int channel) {
    if (channel < 0) return 0.0;
    return channel < 4 ? first[channel] : more[channel - 4];
}

// The shares at p; and the gradient of the medium, where a lit medium prevails over the function of this extinction. One text of
// the places for both: compilers repeat what is called twice.
LabelShares labelsAt(vec3 p, float extinction, inout vec3 gradient) {
    LabelShares shares;
    vec3 middle = placeOfLabels(p);
    float low = 0.0;
    for (int n = 0; n <= uLabelSlopes; ++n) {
        TURNS(2);
        int axis = (n - 1) >> 1;
        bool isHigh = (n & 1) == 0;
        vec3 at = n > 0 ? p : middle;
        if (n > 0) {
            precise float place = isHigh ? p[axis] + kLabelReach : p[axis] - kLabelReach;
            at[axis] = place;
        }
        precise vec4 first = channelsAt(uLabelTexels, uLabelStanding, at) * (1.0 / 16384.0);
        if (n > 0) {
            if (isHigh) gradient[axis] = mediumSlope(low, first[uLabelSolid]); // one of the first four
            else low = first[uLabelSolid];
            continue;
        }
        precise vec4 more = vec4(0.0);
        if (max(uLabelColour + 2, uLabelDense) >= 4) more = channelsAt(uMoreLabelTexels, uMoreLabelStanding, middle) * (1.0 / 16384.0);
        shares.plain = labelChannel(first, more, uLabelPlain);
        shares.tinted = labelChannel(first, more, uLabelTinted);
        shares.solid = labelChannel(first, more, uLabelSolid);
        shares.dense = uLabelDense < 0 ? shares.solid : labelChannel(first, more, uLabelDense);
        shares.red = labelChannel(first, more, uLabelColour);
        shares.green = labelChannel(first, more, uLabelColour < 0 ? -1 : uLabelColour + 1);
        shares.blue = labelChannel(first, more, uLabelColour < 0 ? -1 : uLabelColour + 2);
        if (!(labelledMedium(shares, uLabelDensity) > labelledFunction(shares, extinction))) break;
    }
    return shares;
}

vec3 labelled(LabelShares shares, float part, vec3 colour) {
    if (uLabelColour < 0) return colour;
    return vec3(labelledColour(shares, colour.r, shares.red, part), labelledColour(shares, colour.g, shares.green, part),
                labelledColour(shares, colour.b, shares.blue, part));
}
#endif
