// skipping_masks.comp: which blocks of 2^3 voxels of a cell can show anything (render/engines/gpu/fine_mask.h): a group a cell,
// an invocation a block. Only for cells where the field is plain interpolation of level 0. Also gives cells whose
// blocks do not all show everywhere a place for their sub-blocks.

layout(local_size_x = 64) in;

#include "common_features.glsl"
#include "sampler_atlas.glsl"
#include "skipping_samples.glsl"

layout(rg32ui, binding = 0) writeonly uniform uimage3D uMap;
layout(std430, binding = 2) buffer Places { uint uPlaces[]; }; // uPlaces[0]: blocks so far; then one of each cell
uniform int uFindPlaces; // 1: wanted

shared uint sBlocks[2];
shared uint sPartly; // some block shows in parts

// Four samples along a line, at -1/2 to 5/2 voxels from the block's face: the field on both faces, and between.
vec4 along(vec4 s) { return vec4(0.5 * (s.x + s.y), s.y, s.z, 0.5 * (s.z + s.w)); }

void main() {
    ivec3 at = cellAt();
    int me = int(gl_LocalInvocationIndex);
    loadSamples(at);
    if (me < 2) sBlocks[me] = 0u;
    if (me == 2) sPartly = 0u;
    barrier();
    int first = firstSample();
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
    Shown shown = shownWithin(least(lo), most(hi), slackOf(least(all[0]), most(all[1])));
    if (shown.any) {
        int bit = min(me, 62); // the last two share one
        atomicOr(sBlocks[bit >> 5], 1u << (bit & 31));
        if (!shown.everywhere) atomicOr(sPartly, 1u);
    }
    barrier();
    if (me != 0) return;
    uvec2 texel = uvec2(sBlocks[0], sBlocks[1] | 0x80000000u);
    if (sBlocks[0] == 0u && sBlocks[1] == 0u) texel = uvec2(0x01010101u); // empty after all, and no further
    imageStore(uMap, at, uvec4(texel, 0u, 0u));
    if (uFindPlaces == 0) return;
    uint place = 0u;
    if (sPartly != 0u) place = 1u + atomicAdd(uPlaces[0], uint(bitCount(sBlocks[0]) + bitCount(sBlocks[1])));
    uPlaces[1u + uCells[gl_WorkGroupID.x]] = place;
}
