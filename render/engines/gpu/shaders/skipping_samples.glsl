// skipping_samples.glsl: what the passes that find blocks and sub-blocks share: a group works on a cell of 8^3 voxels,
// an invocation on one of its 4^3 blocks; values are places in the transfer function's table, in entries.
// Needs sampler_atlas.glsl. Gives cellAt(), loadSamples(cell), firstSample(), samplesAlong(at), slackOf(lo, hi),
// shownWithin(lo, hi), isEmptyOver(shown, lo, hi).

layout(std430, binding = 0) readonly buffer Runs { int uRuns[]; };    // see zeroRuns() in render/engines/gpu/fine_mask.cpp
layout(std430, binding = 1) readonly buffer Cells { uint uCells[]; }; // numbers in the grid
uniform ivec3 uExtentVoxels, uGrid;
uniform float uTableScale, uTableOffset;
uniform int uTableLast;
uniform float uFilterError; // what fetches misplace a sample by, all axes together, voxels

const int kEdge = 10; // a cell's 8 samples and one on both sides
shared float sSamples[kEdge * kEdge * kEdge];

ivec3 cellAt() {
    int cell = int(uCells[gl_WorkGroupID.x]);
    return ivec3(cell % uGrid.x, cell / uGrid.x % uGrid.y, cell / (uGrid.x * uGrid.y));
}

// All invocations call it, and wait before they read.
void loadSamples(ivec3 cell) {
    for (int i = int(gl_LocalInvocationIndex); i < kEdge * kEdge * kEdge; i += 64) {
        ivec3 inside = ivec3(i % kEdge, i / kEdge % kEdge, i / (kEdge * kEdge));
        float stored = latticeValue(clamp(cell * 8 - 1 + inside, ivec3(0), uExtentVoxels - 1), 5);
        sSamples[i] = stored * uTableScale + uTableOffset;
    }
}

// The first of the 4^3 samples that values in the block of this invocation come from.
int firstSample() {
    int me = int(gl_LocalInvocationIndex);
    return 2 * ((me & 3) + kEdge * ((me >> 2 & 3) + kEdge * (me >> 4)));
}
vec4 samplesAlong(int at) { return vec4(sSamples[at], sSamples[at + 1], sSamples[at + 2], sSamples[at + 3]); }

float least(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float most(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

// How far a value between samples of this range can be computed from the true one: some thirty roundings of 2^-24,
// here and in the march, and for filtered fetches what their misplacing adds.
float slackOf(float lo, float hi) {
    return (max(abs(lo), abs(hi)) + 2.0 * abs(uTableOffset)) / 262144.0 + (hi - lo) * uFilterError;
}

// What a range of values shows: nothing below first, in the gap and above last. Entry i shows from i - 1 to i + 1,
// because entries are interpolated between.
struct Shown {
    bool any, everywhere;
    float first, last;   // entries
    vec2 gap;            // the first one between them: entries that show nothing, from x up to y but not y
    float slack;
};

Shown shownWithin(float lo, float hi, float slack) {
    float end = float(uTableLast);
    int from = int(clamp(floor(lo - slack), 0.0, end));
    int to = int(clamp(ceil(hi + slack), 0.0, end));
    Shown shown = Shown(false, true, 0.0, end, vec2(end + 2.0), slack);
    const int kMostRuns = 5; // what lies beyond them counts as shown
    int at = from;
    for (int run = 0; run < kMostRuns && at <= to; ++run) {
        int word = uRuns[at];
        int next = abs(word);
        if (word > 0) { // shows
            if (!shown.any) shown.first = float(at);
            shown.any = true;
            shown.last = float(min(next - 1, to));
        } else {
            shown.everywhere = false;
            if (shown.any && shown.gap.x > end) shown.gap = vec2(at, next);
        }
        at = next;
    }
    if (at <= to) { // more runs
        if (!shown.any) shown.first = float(at);
        shown.any = true;
        shown.last = float(to);
    }
    return shown;
}

// Of a range inside that of shown.
bool isEmptyOver(Shown shown, float lo, float hi) {
    float a = clamp(lo - shown.slack, 0.0, float(uTableLast));
    float b = clamp(hi + shown.slack, 0.0, float(uTableLast));
    return !shown.any || b <= shown.first - 1.0 || a >= shown.last + 1.0 || (a >= shown.gap.x && b <= shown.gap.y - 1.0);
}
