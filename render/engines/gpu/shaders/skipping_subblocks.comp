// skipping_subblocks.comp: which sub-blocks of 1/2 x 1/2 x 1/4 voxel of a cell's occupied blocks can show anything
// (render/engines/gpu/fine_mask.h): a group a cell, an invocation a block. A sub-block never crosses a plane of samples, so that
// trilinear interpolation is extreme at its corners.

layout(local_size_x = 64) in;

#include "common_features.glsl"
#include "sampler_atlas.glsl"
#include "skipping_samples.glsl"

layout(rg32ui, binding = 0) readonly uniform uimage3D uMap;
layout(std430, binding = 2) readonly buffer Places { uint uPlaces[]; };
layout(std430, binding = 3) buffer SubBlocks { uint uSubBlocks[]; }; // four words a block: see render/engines/gpu/fine_mask.h

void main() {
    ivec3 at = cellAt();
    int me = int(gl_LocalInvocationIndex);
    loadSamples(at);
    barrier();
    uvec2 blocks = imageLoad(uMap, at).xy & uvec2(0xFFFFFFFFu, 0x7FFFFFFFu);
    int bit = min(me, 62);
    if (((bit < 32 ? blocks.x : blocks.y) >> (bit & 31) & 1u) == 0u) return;
    uvec2 before = uvec2(bit < 32 ? (1u << bit) - 1u : 0xFFFFFFFFu, bit < 32 ? 0u : (1u << (bit - 32)) - 1u) & blocks;
    uint place = 4u * (uPlaces[1u + uCells[gl_WorkGroupID.x]] - 1u + uint(bitCount(before.x) + bitCount(before.y)));
    int first = firstSample();
    vec4 lo = samplesAlong(first);
    vec4 hi = lo;
    for (int row = 1; row < 16; ++row) {
        vec4 s = samplesAlong(first + kEdge * ((row & 3) + kEdge * (row >> 2)));
        lo = min(lo, s);
        hi = max(hi, s);
    }
    Shown shown = shownWithin(least(lo), most(hi), slackOf(least(lo), most(hi)));
    uint word = 0u;
    // Of the plane before, per row of sub-blocks; set because a driver's warning about it counts as an error.
    vec4 lowBefore[4] = vec4[4](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0)), highBefore[4] = lowBefore;
    vec4 below[4], above[4];          // samples beside the plane
    int plane = 0;                    // 0 to 8, a quarter of a voxel apart, half a voxel beyond the first samples
    for (int slice = 0; slice < 4; ++slice) {
        for (int y = 0; y < 4; ++y) {
            below[y] = above[y];
            above[y] = samplesAlong(first + kEdge * (y + kEdge * slice));
        }
        if (slice == 0) continue;
        for (; plane <= min(4 * slice - 3, 8); ++plane) {
            vec4 rows[4];
            for (int y = 0; y < 4; ++y)
                rows[y] = mix(below[y], above[y], 0.25 * float(plane + 2 - 4 * (slice - 1)));
            vec4 lines[5] = vec4[5](0.5 * (rows[0] + rows[1]), rows[1], 0.5 * (rows[1] + rows[2]), rows[2], 0.5 * (rows[2] + rows[3]));
            vec4 low = vec4(0.0), high = vec4(0.0); // of the line before
            for (int y = 0; y < 5; ++y) {
                vec4 s = lines[y];
                vec3 between = 0.5 * (s.xyz + s.yzw);
                vec4 a = vec4(between.x, s.y, between.y, s.z);
                vec4 b = vec4(s.y, between.y, s.z, between.z);
                vec4 lowLine = min(a, b), highLine = max(a, b);
                if (y > 0) {
                    vec4 lowHere = min(low, lowLine), highHere = max(high, highLine);
                    if (plane > 0) {
                        lo = min(lowHere, lowBefore[y - 1]);
                        hi = max(highHere, highBefore[y - 1]);
                        int shift = (plane - 1 & 1) * 16 + 4 * (y - 1);
                        for (int x = 0; x < 4; ++x)
                            if (!isEmptyOver(shown, lo[x], hi[x])) word |= 1u << (shift + x);
                    }
                    lowBefore[y - 1] = lowHere;
                    highBefore[y - 1] = highHere;
                }
                low = lowLine;
                high = highLine;
            }
            if (plane > 0 && (plane & 1) == 0) {
                uint index = place + uint(plane / 2 - 1);
                if (me < 62) uSubBlocks[index] = word;
                else atomicOr(uSubBlocks[index], word); // the last two blocks share theirs
                word = 0u;
            }
        }
    }
}
