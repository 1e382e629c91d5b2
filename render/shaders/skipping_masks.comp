// skipping_masks.comp: which blocks of 2^3 voxels of a cell can show anything (render/fine_mask.h): a group a cell,
// an invocation a block. Only for cells where the field is plain interpolation of level 0.

layout(local_size_x = 64) in;

#include "common_features.glsl"
#include "sampler_atlas.glsl"

layout(std430, binding = 0) readonly buffer Zeros { int uNonZeroUpTo[]; }; // entries up to i that are not 0
layout(std430, binding = 1) readonly buffer Cells { uint uCells[]; };      // numbers in the grid
layout(rg32ui, binding = 0) writeonly uniform uimage3D uMap;
uniform ivec3 uExtentVoxels, uGrid;
uniform float uTableScale, uTableOffset;
uniform int uTableLast;

const int kEdge = 10; // a cell's 8 samples and one on both sides
shared float sSamples[kEdge * kEdge * kEdge];
shared uint sBlocks[2];

// TransferTable::emptyOver(): conservative by one entry on both sides.
bool isEmptyOver(float lo, float hi) {
    float a = lo * uTableScale + uTableOffset;
    float b = hi * uTableScale + uTableOffset;
    float last = float(uTableLast);
    int first = int(clamp(floor(min(a, b)) - 1.0, 0.0, last));
    int final = int(clamp(ceil(max(a, b)) + 1.0, 0.0, last));
    return uNonZeroUpTo[final] == (first == 0 ? 0 : uNonZeroUpTo[first - 1]);
}

// Four samples along a line, at -1/2 to 5/2 voxels from the block's face: the field on both faces, and between.
vec4 along(float s0, float s1, float s2, float s3) { return vec4(0.5 * (s0 + s1), s1, s2, 0.5 * (s2 + s3)); }

vec4 row(int at) { return along(sSamples[at], sSamples[at + 1], sSamples[at + 2], sSamples[at + 3]); }

void main() {
    int cell = int(uCells[gl_WorkGroupID.x]);
    ivec3 at = ivec3(cell % uGrid.x, cell / uGrid.x % uGrid.y, cell / (uGrid.x * uGrid.y));
    int me = int(gl_LocalInvocationIndex);
    for (int i = me; i < kEdge * kEdge * kEdge; i += 64) {
        ivec3 inside = ivec3(i % kEdge, i / kEdge % kEdge, i / (kEdge * kEdge));
        sSamples[i] = latticeValue(clamp(at * 8 - 1 + inside, ivec3(0), uExtentVoxels - 1), 5);
    }
    if (me < 2) sBlocks[me] = 0u;
    barrier();
    ivec3 block = ivec3(me & 3, me >> 2 & 3, me >> 4);
    int first = 2 * (block.x + kEdge * (block.y + kEdge * block.z));
    vec4 lo = vec4(3.402823466e38);
    vec4 hi = -lo;
    vec4 faces[16]; // y fastest
    for (int z = 0; z < 4; ++z) {
        int slice = first + z * kEdge * kEdge;
        vec4 r0 = row(slice), r1 = row(slice + kEdge), r2 = row(slice + 2 * kEdge), r3 = row(slice + 3 * kEdge);
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
    float lowest = min(min(lo.x, lo.y), min(lo.z, lo.w));
    float highest = max(max(hi.x, hi.y), max(hi.z, hi.w));
    if (!isEmptyOver(lowest, highest)) {
        int bit = min(me, 62); // the last two share one
        atomicOr(sBlocks[bit >> 5], 1u << (bit & 31));
    }
    barrier();
    if (me != 0) return;
    uvec2 texel = uvec2(sBlocks[0], sBlocks[1] | 0x80000000u);
    if (sBlocks[0] == 0u && sBlocks[1] == 0u) texel = uvec2(0x01010101u); // empty after all, and no further
    imageStore(uMap, at, uvec4(texel, 0u, 0u));
}
