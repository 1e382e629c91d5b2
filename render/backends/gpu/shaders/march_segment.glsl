// march_segment.glsl: what a segment of a ray adds, from the values at its two ends or at its middle alone, as places
// (units of the table's entries); twin of render/contract/integrators.h, operation by operation.
// Needs FEATURE_LINEAR, FEATURE_PREINTEGRATED, FEATURE_PREINTEGRATION_2D, FEATURE_LIGHTS, FEATURE_MATERIALS, march_optics.glsl. Gives FEATURE_ENDS, SegmentEnd,
// endOf(stored), segmentExtinction(front, back), segmentColour(front, back, depth, alpha, n).

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
const float kFarPlace = 4194304.0;

float placeOf(float stored) {
    precise float x = stored * uTableScale + uTableOffset;
    float above = x > -kFarPlace ? x : -kFarPlace; // also where it is no number
    return above < kFarPlace ? above : kFarPlace;
}
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

float onTable(float place) { return clamp(place, 0.0, float(uTableLast)); }

#if FEATURE_PREINTEGRATED
// extinctionBins() of preintegration.h, then its colourSums() or its Preintegration2d.
uniform samplerBuffer uSums;
uniform int uSumsStart; // of what comes after the bins

SegmentEnd endOf(float stored) {
    SegmentEnd end;
    end.place = placeOf(stored);
    end.bin = clamp(int(floor(end.place)), -1, uTableLast);
    end.entry = texelFetch(uSums, end.bin + 1);
    return end;
}

// Averaged over the values between two ends. Zero exactly where every entry around these values is zero.
float segmentExtinction(SegmentEnd front, SegmentEnd back) {
    bool rises = front.place < back.place;
    SegmentEnd low = back;
    SegmentEnd high = front;
    if (rises) {
        low = front;
        high = back;
    }
    precise float f = low.place - float(low.bin);
    precise float g = high.place - float(high.bin);
    precise float inside = low.entry.x + (0.5 * (f + g)) * low.entry.y;
    precise float width = high.place - low.place;
    precise float above = g * (high.entry.x + (0.5 * g) * high.entry.y);
    precise float below = (1.0 - f) * (low.entry.x + (0.5 * (1.0 + f)) * low.entry.y);
    precise float under = f * (low.entry.x + (0.5 * f) * low.entry.y);
    precise float sum = (high.entry.z - low.entry.z) + ((high.entry.w - low.entry.w) + (above - under));
    sum = max(sum, 0.0);
    precise float beside = below + above; // nothing cancels, however close they are
    precise float mean = (low.bin + 1 == high.bin ? beside : sum) / width;
    return low.bin == high.bin ? inside : mean;
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
    vec3 c00 = texelFetch(uSums, at).rgb;
    vec3 c01 = texelFetch(uSums, at + uPreintegrationEdge).rgb;
    precise vec3 near = c00 + fx * (texelFetch(uSums, at + 1).rgb - c00);
    precise vec3 far = c01 + fx * (texelFetch(uSums, at + uPreintegrationEdge + 1).rgb - c01);
    precise vec3 colour = near + fy * (far - near);
    return colour;
}
#else
vec4 entryOf(int i) { return vec4(texelFetch(uColours, i).rgb, texelFetch(uExtinctions, i).x); }

vec4 entryAt(float place) {
    float x = onTable(place);
    int i = tableCell(x);
    vec4 a = entryOf(i);
    precise vec4 e = a + (x - float(i)) * (entryOf(i + 1) - a);
    return e;
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
    precise vec4 between = (sumTo(last, 0) - sumTo(first + 1, 0)) + (sumTo(last, 1) - sumTo(first + 1, 1));
    precise vec4 sum = (below + between) + above;
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

// How far towards its back a segment is seen, in the mean over its light: 1/x - 1/(e^x - 1), x its depth.
float seenDepth(float depth, float alpha) {
    if (depth < 0.5) {
        precise float s = depth * depth;
        precise float small = 0.5 - depth * ((1.0 / 12.0) - s * ((1.0 / 720.0) - s * ((1.0 / 30240.0) -
                              s * ((1.0 / 1209600.0) - s * ((1.0 / 47900160.0) - s * (691.0 / 1307674368000.0))))));
        return small;
    }
    precise float large = 1.0 / depth - (1.0 - alpha) / alpha;
    return large;
}

vec3 segmentColour(SegmentEnd front, SegmentEnd back, float depth, float alpha, int n) {
    vec3 a = colourAt(onTable(front.place));
    precise vec3 colour = a + seenDepth(depth, alpha) * (colourAt(onTable(back.place)) - a);
    return colour;
}
#endif
#endif
