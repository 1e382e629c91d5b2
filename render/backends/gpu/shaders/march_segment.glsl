// march_segment.glsl: the contribution of a ray's segment, as render/contract/integrators.h has it in float. It
// follows from the values at its two ends or at its middle alone, as places (units of the table's entries).
// Needs FEATURE_LINEAR, FEATURE_PREINTEGRATED, FEATURE_PREINTEGRATION_2D, FEATURE_LIGHTS, FEATURE_MATERIALS,
// march_optics.glsl. Gives FEATURE_ENDS, SegmentEnd, endOf(stored), segmentExtinction(front, back),
// segmentColour(front, back, depth, alpha, n).

#define FEATURE_ENDS (FEATURE_LINEAR || FEATURE_PREINTEGRATED)

struct SegmentEnd {
    float place;
#if FEATURE_MATERIALS && !FEATURE_ENDS
    float unlimited; // place, also beyond the table
#endif
#if FEATURE_PREINTEGRATED
    int bin; // -1 is before the table, its last entry after it
    vec4 entry;
#endif
};

#if FEATURE_ENDS || FEATURE_LIGHTS
float placeOf(float stored) { return farPlaceOf(stored, uTableScale, uTableOffset); }
#endif

#if !FEATURE_ENDS
#if FEATURE_MATERIALS
SegmentEnd endOf(float stored) { return SegmentEnd(tablePlace(stored), placeOf(stored)); }
#else
SegmentEnd endOf(float stored) { return SegmentEnd(tablePlace(stored)); }
#endif
float segmentExtinction(SegmentEnd front, SegmentEnd back) { return extinctionAt(back.place); }
vec3 segmentColour(SegmentEnd front, SegmentEnd back, float depth, float alpha, int n) { return colourAt(back.place); }
#else

float onTable(float place) { return heldPlace(place, float(uTableLast)); }

#if FEATURE_PREINTEGRATED
// extinctionBins() of preintegration.h, then its colourSums() or its Preintegration2d.
uniform samplerBuffer uSums;
uniform int uSumsStart; // of the sums after the bins

SegmentEnd endOf(float stored) {
    SegmentEnd end;
    end.place = placeOf(stored);
    end.bin = clamp(int(floor(end.place)), -1, uTableLast);
    end.entry = texelFetch(uSums, end.bin + 1);
    return end;
}

BinEnd binEnd(SegmentEnd end) {
    vec4 e = end.entry;
    return BinEnd(end.place, float(end.bin), e.x, e.y, e.z, e.w);
}

// Averaged over the values between two ends.
float segmentExtinction(SegmentEnd front, SegmentEnd back) {
    bool rises = front.place < back.place;
    BinEnd low = binEnd(back);
    BinEnd high = binEnd(front);
    if (rises) {
        low = binEnd(front);
        high = binEnd(back);
    }
    return meanExtinction(low, high);
}

#if FEATURE_PREINTEGRATION_2D
uniform float uPreintegrationScale; // places of the table of colours per entry of the other
uniform int uPreintegrationEdge, uPreintegrationFirstLayer;

vec3 segmentColour(SegmentEnd front, SegmentEnd back, float depth, float alpha, int n) {
    precise float x = onTable(front.place) * uPreintegrationScale;
    precise float y = onTable(back.place) * uPreintegrationScale;
    int i = min(int(x), uPreintegrationEdge - 2);
    int j = min(int(y), uPreintegrationEdge - 2);
    precise float fx = x - float(i);
    precise float fy = y - float(j);
    int at = uSumsStart + ((findLSB(n) - uPreintegrationFirstLayer) * uPreintegrationEdge + j) * uPreintegrationEdge + i;
    return bilinear(texelFetch(uSums, at).rgb, texelFetch(uSums, at + 1).rgb, texelFetch(uSums, at + uPreintegrationEdge).rgb,
                    texelFetch(uSums, at + uPreintegrationEdge + 1).rgb, fx, fy);
}
#else
vec4 entryOf(int i) { return vec4(texelFetch(uColours, i).rgb, EXTINCTION(i)); }

vec4 entryAt(float place) {
    float x = onTable(place);
    int i = tableCell(x);
    precise float part = x - float(i);
    vec4 a = entryOf(i);
    vec4 b = entryOf(i + 1);
    return vec4(partWay(a.rgb, b.rgb, part), partWay(a.a, b.a, part));
}

vec4 radiance(float width, float place) {
    vec4 e = entryAt(place);
    precise float weight = width * e.a;
    precise vec3 emitted = weight * e.rgb;
    return vec4(emitted, weight);
}

vec4 sumTo(int entry, int part) { return texelFetch(uSums, uSumsStart + 2 * (entry + 1) + part); }

vec3 segmentColour(SegmentEnd front, SegmentEnd back, float depth, float alpha, int n) {
    bool rises = front.place < back.place;
    float low = rises ? front.place : back.place;
    float high = rises ? back.place : front.place;
    int first = rises ? front.bin : back.bin;
    int last = rises ? back.bin : front.bin;
    precise float at = 0.5 * (low + high);
    vec3 middle = entryAt(at).rgb;
    if (first == last) return middle;
    float next = float(first + 1);
    float start = float(last);
    precise float widthBelow = next - low;
    precise float widthAbove = high - start;
    precise float middleBelow = 0.5 * (low + next);
    precise float middleAbove = 0.5 * (start + high);
    vec4 below = radiance(widthBelow, middleBelow);
    vec4 above = radiance(widthAbove, middleAbove);
    vec4 from = sumTo(first + 1, 0), fromRest = sumTo(first + 1, 1);
    vec4 to = sumTo(last, 0), toRest = sumTo(last, 1);
#define OF(c) sumOverBins(below.c, from.c, fromRest.c, to.c, toRest.c, above.c)
    vec4 sum = vec4(OF(x), OF(y), OF(z), OF(w));
#undef OF
    if (!(sum.a > 1e-30)) return middle; // nothing shows
    precise vec3 colour = sum.rgb / sum.a;
    return colour;
}
#endif

#else // constant extinction, linear colour
SegmentEnd endOf(float stored) { return SegmentEnd(placeOf(stored)); }

float segmentExtinction(SegmentEnd front, SegmentEnd back) {
    precise float mean = 0.5 * (extinctionAt(onTable(front.place)) + extinctionAt(onTable(back.place)));
    return mean;
}

vec3 segmentColour(SegmentEnd front, SegmentEnd back, float depth, float alpha, int n) {
    return partWay(colourAt(onTable(front.place)), colourAt(onTable(back.place)), seenDepth(depth, alpha));
}
#endif
#endif
