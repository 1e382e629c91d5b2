// skipping_masks.comp: which blocks of 2^3 voxels of a cell can show anything (render/backends/gpu/skipping_binding.h): a group a cell,
// an invocation a block. Only for cells where the field is plain interpolation of level 0. Values are places in the
// transfer function's table, in entries.

layout(local_size_x = 64) in;

#include "sampler_atlas.glsl"

layout(rg32ui) writeonly uniform uimage3D uMap;
layout(std430, binding = BINDING_RUNS) readonly buffer Runs { int uRuns[]; };    // see zeroRuns() in render/backends/gpu/skipping_binding.cpp
layout(std430, binding = BINDING_CELLS) readonly buffer Cells { uint uCells[]; }; // numbers in the grid
uniform ivec3 uExtentVoxels, uGrid;
uniform float uTableScale, uTableOffset;
uniform int uTableLast;
uniform float uFilterError; // misplacing of a sample by fetches, all axes together, voxels

const int kEdge = 10; // a cell's 8 samples and one on both sides
shared float sSamples[kEdge * kEdge * kEdge];
shared uint sBlocks[2];

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

vec4 samplesAlong(int at) { return vec4(sSamples[at], sSamples[at + 1], sSamples[at + 2], sSamples[at + 3]); }

float least(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float most(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

// The largest error of a computed value between samples of this range: some thirty roundings of 2^-24, here and in
// the ray caster. Filtered fetches add their misplacing.
float slackOf(float lo, float hi) {
    return (max(abs(lo), abs(hi)) + 2.0 * abs(uTableOffset)) / 262144.0 + (hi - lo) * uFilterError;
}

// True if any value of the range shows. Entry i shows from i - 1 to i + 1, because entries are interpolated between.
bool showsWithin(float lo, float hi, float slack) {
    float end = float(uTableLast);
    int at = int(clamp(floor(lo - slack), 0.0, end));
    int to = int(clamp(ceil(hi + slack), 0.0, end));
    const int kMostRuns = 5; // values beyond them count as shown
    for (int run = 0; run < kMostRuns && at <= to; ++run) {
        if (uRuns[at] > 0) return true;
        at = -uRuns[at];
    }
    return at <= to;
}

// Four samples along a line, at -1/2 to 5/2 voxels from the block's face: the field on both faces, and between.
vec4 along(vec4 s) { return vec4(0.5 * (s.x + s.y), s.y, s.z, 0.5 * (s.z + s.w)); }

void main() {
    ivec3 at = cellAt();
    int me = int(gl_LocalInvocationIndex);
    loadSamples(at);
    if (me < 2) sBlocks[me] = 0u;
    barrier();
    int first = 2 * ((me & 3) + kEdge * ((me >> 2 & 3) + kEdge * (me >> 4))); // of the 4^3 samples of the block's values
    vec4 lo = vec4(3.402823466e38);
    vec4 hi = -lo;
    vec4 all[2] = vec4[2](lo, hi); // of the samples
    vec4 faces[16];                // y fastest
    for (int z = 0; z < 4; ++z) {
        int slice = first + z * kEdge * kEdge;
        vec4 s0 = samplesAlong(slice), s1 = samplesAlong(slice + kEdge);
        vec4 s2 = samplesAlong(slice + 2 * kEdge), s3 = samplesAlong(slice + 3 * kEdge);
        all[0] = min(all[0], min(min(s0, s1), min(s2, s3)));
        all[1] = max(all[1], max(max(s0, s1), max(s2, s3)));
        vec4 r0 = along(s0), r1 = along(s1), r2 = along(s2), r3 = along(s3);
        faces[4 * z] = 0.5 * (r0 + r1);
        faces[4 * z + 1] = r1;
        faces[4 * z + 2] = r2;
        faces[4 * z + 3] = 0.5 * (r2 + r3);
    }
    for (int y = 0; y < 4; ++y) {
        vec4 low = 0.5 * (faces[y] + faces[4 + y]);
        vec4 high = 0.5 * (faces[8 + y] + faces[12 + y]);
        lo = min(lo, min(min(low, high), min(faces[4 + y], faces[8 + y])));
        hi = max(hi, max(max(low, high), max(faces[4 + y], faces[8 + y])));
    }
    if (showsWithin(least(lo), most(hi), slackOf(least(all[0]), most(all[1])))) {
        int bit = min(me, 62); // the last two share one
        atomicOr(sBlocks[bit >> 5], 1u << (bit & 31));
    }
    barrier();
    if (me != 0) return;
    uvec2 texel = uvec2(sBlocks[0], sBlocks[1] | 0x80000000u);
    if (sBlocks[0] == 0u && sBlocks[1] == 0u) texel = uvec2(0x01010101u); // empty after all, and no further
    imageStore(uMap, at, uvec4(texel, 0u, 0u));
}
