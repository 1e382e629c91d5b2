// march_seen.glsl: the visible part of a segment beside its values: gradient opacity, labels and light; as seeSegment() in
// render/backends/mirror/mirror_sample.h.
// Needs FEATURE_SHADING, FEATURE_GRADIENT_OPACITY, FEATURE_LABELS, FEATURE_LIGHTS, sampler_field.glsl, march_segment.glsl,
// march_lights.glsl, sampler_light.glsl, sampler_labels.glsl. Gives MAY_SHOW, SeenSegment, seenSegment(...).

// A sample that may add something: of a medium of labels too, which needs no extinction of the function.
#if FEATURE_LABELS
#define MAY_SHOW (HAS_LABELS || extinction > 0.0)
#else
#define MAY_SHOW (extinction > 0.0)
#endif

struct SeenSegment {
    float extinction, alpha; // per mm; of the segment
    vec3 colour;             // not premultiplied
};

// The segment between two ends, or around the second alone. extinction: the function's; middle: voxels; direction: the
// ray's, unit in the voxels of one volume; n: its length in segments, before it is cut at the exit.
SeenSegment seenSegment(SegmentEnd front, SegmentEnd back, float extinction, vec3 middle, vec3 direction, float lengthMm, int n) {
#if FEATURE_GRADIENT_OPACITY
    vec3 gradient = fieldGradient(middle);
    precise float graded = extinction * gradientOpacity(gradient);
    extinction = graded;
#if FEATURE_SHADING && FEATURE_SOBEL_GRADIENT
    ONCE (SMOOTHS) gradient = normalGradient(middle);
#endif
#elif FEATURE_SHADING
    vec3 gradient = normalGradient(middle);
#elif FEATURE_LABELS
    vec3 gradient = vec3(0.0);
#endif
#if FEATURE_LABELS
    LabelShares shares;
    float ofLabels = 0.0;
    if (HAS_LABELS) {
        shares = labelsAt(middle, extinction, gradient);
        float medium = labelledMedium(shares, uLabelDensity);
        float function = labelledFunction(shares, extinction);
        precise float labelledSum = function + medium;
        ofLabels = labelledSum > 0.0 ? labelledPart(shares, extinction, medium, labelledSum) : 0.0;
        extinction = labelledSum;
    }
#endif
    precise float depth = extinction * lengthMm;
    precise float alpha = opacityOf(depth);
    vec3 colour = segmentColour(front, back, depth, alpha, n);
#if FEATURE_LABELS
    if (HAS_LABELS) colour = labelled(shares, ofLabels, colour);
#endif
#if FEATURE_LIGHTS
    if (HAS_LIGHTS) colour = shadeByLights(colour, gradient, direction, middle, materialPlace(front, back), receivedLight(middle));
    else colour = shade(colour, gradient, direction);
#elif FEATURE_SHADING
    colour = shade(colour, gradient, direction);
#endif
    return SeenSegment(extinction, alpha, colour);
}
