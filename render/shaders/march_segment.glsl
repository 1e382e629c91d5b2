// march_segment.glsl: what a segment of a ray adds, from the places (values in units of the table's entries) at its
// front and its back, or at its middle alone; twin of render/integrators.h, operation by operation.
// Needs FEATURE_LINEAR, FEATURE_PREINTEGRATED, FEATURE_SEENCOLOURS, march_optics.glsl. Gives FEATURE_ENDS,
// placeOf(stored), segmentExtinction(front, back), segmentColour(front, back, depth, alpha, n).

#define FEATURE_ENDS (FEATURE_LINEAR || FEATURE_PREINTEGRATED)

#if !FEATURE_ENDS
float placeOf(float stored) { return tablePlace(stored); }
float segmentExtinction(float front, float back) { return extinctionAt(back); }
vec3 segmentColour(float front, float back, float depth, float alpha, int n) { return colourAt(back); }
#else

const float kFarPlace = 4194304.0;

float placeOf(float stored) {
    precise float x = stored * uTableScale + uTableOffset;
    float above = x > -kFarPlace ? x : -kFarPlace; // also where it is no number
    return above < kFarPlace ? above : kFarPlace;
}

float onTable(float place) { return clamp(place, 0.0, float(uTableLast)); }
float extinctionOf(float place) { return extinctionAt(onTable(place)); }
vec3 colourOf(float place) { return colourAt(onTable(place)); }

#if FEATURE_PREINTEGRATED
// tableSums() of preintegration.h, then SeenColours where there are some: [layer][back][front].
layout(std430, binding = 7) readonly buffer TableSums { vec4 uSums[]; };

int binOf(float place) { return clamp(int(floor(place)), -1, uTableLast); }

// Integral of extinction from entry i to entry j; from -1 to the number of entries.
float extinctionBetween(int i, int j) {
    precise float sum = (uSums[2 * j + 2].a - uSums[2 * i + 2].a) + (uSums[2 * j + 3].a - uSums[2 * i + 3].a);
    return sum;
}

// Averaged over the values between two places. Zero exactly where every entry around these values is zero.
float segmentExtinction(float front, float back) {
    float low = min(front, back);
    float high = max(front, back);
    int first = binOf(low);
    int last = binOf(high);
    if (first == last) {
        precise float middle = 0.5 * (low + high);
        return extinctionOf(middle);
    }
    if (extinctionBetween(first, last + 1) == 0.0) return 0.0;
    float next = float(first + 1);
    float start = float(last);
    precise float middleBelow = 0.5 * (low + next);
    precise float middleAbove = 0.5 * (start + high);
    precise float below = (next - low) * extinctionOf(middleBelow);
    precise float above = (high - start) * extinctionOf(middleAbove);
    precise float mean = (below + extinctionBetween(first + 1, last) + above) / (high - low);
    return mean;
}

#if FEATURE_SEENCOLOURS
uniform float uSeenScale; // places of the table of colours per entry of the other
uniform int uSeenStart, uSeenEdge, uSeenFirstLayer;

vec3 segmentColour(float front, float back, float depth, float alpha, int n) {
    precise float x = onTable(front) * uSeenScale;
    precise float y = onTable(back) * uSeenScale;
    int i = min(int(x), uSeenEdge - 2);
    int j = min(int(y), uSeenEdge - 2);
    precise float fx = x - float(i);
    precise float fy = y - float(j);
    int at = uSeenStart + ((findLSB(n) - uSeenFirstLayer) * uSeenEdge + j) * uSeenEdge + i;
    vec3 c00 = uSums[at].rgb;
    vec3 c01 = uSums[at + uSeenEdge].rgb;
    precise vec3 near = c00 + fx * (uSums[at + 1].rgb - c00);
    precise vec3 far = c01 + fx * (uSums[at + uSeenEdge + 1].rgb - c01);
    precise vec3 colour = near + fy * (far - near);
    return colour;
}
#else
vec4 radianceAt(float place) {
    float x = onTable(place);
    int i = tableCell(x);
    vec4 a = uTable[i];
    precise vec4 e = a + (x - float(i)) * (uTable[i + 1] - a);
    precise vec3 emitted = e.rgb * e.a;
    return vec4(emitted, e.a);
}

vec4 sumInsideBin(float low, float high) {
    precise float middle = 0.5 * (low + high);
    precise vec4 sum =
        ((high - low) * (1.0 / 6.0)) * (radianceAt(low) + 4.0 * radianceAt(middle) + radianceAt(high));
    return sum;
}

vec4 sumBetween(int i, int j) {
    precise vec4 sum = (uSums[2 * j + 2] - uSums[2 * i + 2]) + (uSums[2 * j + 3] - uSums[2 * i + 3]);
    return sum;
}

vec3 segmentColour(float front, float back, float depth, float alpha, int n) {
    float low = min(front, back);
    float high = max(front, back);
    int first = binOf(low);
    int last = binOf(high);
    precise vec4 sum;
    if (first == last) sum = sumInsideBin(low, high);
    else
        sum = sumInsideBin(low, float(first + 1)) + sumBetween(first + 1, last) + sumInsideBin(float(last), high);
    precise float middle = 0.5 * (low + high);
    if (!(sum.a > 1e-30)) return colourOf(middle); // the values hardly differ, or nothing shows
    precise vec3 colour = sum.rgb / sum.a;
    return colour;
}
#endif

#else // constant extinction, linear colour
float segmentExtinction(float front, float back) {
    precise float mean = 0.5 * (extinctionOf(front) + extinctionOf(back));
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

vec3 segmentColour(float front, float back, float depth, float alpha, int n) {
    vec3 a = colourOf(front);
    precise vec3 colour = a + seenDepth(depth, alpha) * (colourOf(back) - a);
    return colour;
}
#endif
#endif
