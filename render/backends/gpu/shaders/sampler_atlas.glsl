// sampler_atlas.glsl: texels of the atlas and stored values; nothing here knows how samples are blended.
// Needs FEATURE_HARDWARE, FEATURE_NORMALISED, FEATURE_COUNTING, FEATURE_PASSES, FEATURE_FUSED. Gives storedFromTexel,
// storedFromFiltered, brickEntry(brick), slotOrigin(entry, shift), trilinearOverBricks, trilinearInSlot.

#include "common_turns.glsl"
#include "common_texels.glsl"
#include "common_leaves.glsl"
#include "leaf_field.h"

#if FEATURE_FUSED
OF_VOLUME sampler3D uVoxels; // atlas pages: of either type, for single texels and filtered
#define uTexels uVoxels
#elif FEATURE_NORMALISED
OF_VOLUME TEXELS_R16 uTexels; // atlas pages
#else
OF_VOLUME TEXELS_R32F uTexels;
#endif
#if FEATURE_NORMALISED
OF_VOLUME float uStoredBias; // stored value = 65535 * texel + bias, exactly
#endif
#if FEATURE_HARDWARE
#if !FEATURE_FUSED
OF_VOLUME sampler3D uVoxels; // the same, filtered
#endif
OF_VOLUME vec3 uTexelSize; // 1 / extent of uVoxels
#endif
#if FEATURE_FUSED && FEATURE_NORMALISED
OF_VOLUME int uStoredAsFloats; // 1: stored value = texel; another volume has texels of 16 bits
#define STORED(text) (uStoredAsFloats != 0 ? texel : text)
#else
#define STORED(text) text
#endif
OF_VOLUME TEXELS_RG32UI uIndex; // one texel per brick: see render/residency/brick_residency.h
const uint kEntryValue = 0x80000000u;

#if FEATURE_COUNTING
uint gFetches = 0u;
#define COUNT_FETCHES(n) gFetches += n
#else
#define COUNT_FETCHES(n)
#endif

float storedFromTexel(float texel) {
#if FEATURE_NORMALISED
    return STORED(floor(texel * 65535.0 + 0.5) + uStoredBias);
#else
    return texel;
#endif
}

float storedFromFiltered(float texel) {
#if FEATURE_NORMALISED
    return STORED(texel * 65535.0 + uStoredBias);
#else
    return texel;
#endif
}

#if FEATURE_PASSES
// Bricks may be absent. A sample that needs one is not taken; its ray names all bricks that the sample needs, and
// waits. A brick keeps the first of the rays that named it, so that the host can serve at least one ray wholly.
const uint kEntryAbsent = 0x40000000u;
layout(std430, binding = BINDING_WANTED) buffer Wanted { uint uWanted[]; }; // per brick: number of the first ray, or all ones
bool gMissing = false; // the sample at hand needs an absent brick
bool gNaming = false;
uint gRayNumber = 0u;
#if FEATURE_FUSED
OF_VOLUME int uFirstWanted;   // of the volume's bricks
OF_VOLUME ivec3 uWantedGrid;  // of them; llvmpipe knows the extent of the first texture of an array alone
#else
#define uFirstWanted 0
#define uWantedGrid texelsExtent(uIndex)
#endif
#endif

uvec2 brickEntry(ivec3 brick) {
    uvec2 entry = texelAt(uIndex, brick).xy;
#if FEATURE_PASSES
    if ((entry.x & (kEntryAbsent | kEntryValue)) == kEntryAbsent) gMissing = true;
    ivec3 bricks = uWantedGrid;
    if (gNaming && (entry.x & kEntryValue) == 0u)
        atomicMin(uWanted[uFirstWanted + (brick.z * bricks.y + brick.y) * bricks.x + brick.x], gRayNumber);
#endif
    return entry;
}

// First texel of a slot whose edge is 2^shift samples. x: page (3 x 10 bits), y: slot inside it (3 x 5 bits).
ivec3 slotOrigin(uvec2 entry, int shift) {
    ivec3 page = ivec3(entry.x & 1023u, (entry.x >> 10) & 1023u, (entry.x >> 20) & 1023u);
    ivec3 slot = ivec3(entry.y & 31u, (entry.y >> 5) & 31u, (entry.y >> 10) & 31u);
    return page * 32 + (slot << shift);
}

float texelValue(ivec3 at) {
    COUNT_FETCHES(1u);
    return storedFromTexel(texelAt(uTexels, at).r);
}

#if FEATURE_FUSED && DRIVER_LLVMPIPE
// It compiles each fetch once for every volume. So a loop that it cannot unroll takes the corners of a cell.
uniform int uCellCorners; // 8
#define LOOP_OVER_CORNERS 1
#define CORNERS(Type, v, low, high, corner, fetched)                                                                   \
    Type v[8];                                                                                                         \
    for (int n = 0; n < uCellCorners; ++n) {                                                                           \
        TURN;                                                                                                          \
        ivec3 corner = mix(low, high, bvec3((n & 1) != 0, (n & 2) != 0, (n & 4) != 0));                                \
        Type found = fetched;                                                                                          \
        for (int k = 0; k < 8; ++k) v[k] = n == k ? found : v[k];                                                      \
    }
#else
#define LOOP_OVER_CORNERS 0
#endif

// Between texels of one slot.
#if LOOP_OVER_CORNERS
float trilinearInSlot(ivec3 low, ivec3 high, vec3 f) {
    CORNERS(float, v, low, high, at, texelValue(at))
    return trilinear(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], f.x, f.y, f.z);
}
#else
float trilinearInSlot(ivec3 low, ivec3 high, vec3 f) {
    return trilinear(texelValue(low), texelValue(ivec3(high.x, low.yz)), texelValue(ivec3(low.x, high.y, low.z)),
                      texelValue(ivec3(high.xy, low.z)), texelValue(ivec3(low.xy, high.z)),
                      texelValue(ivec3(high.x, low.y, high.z)), texelValue(ivec3(low.x, high.yz)),
                      texelValue(high), f.x, f.y, f.z);
}
#endif

// shift: log2 of the samples per brick edge
float latticeValue(ivec3 i, int shift) {
    COUNT_FETCHES(1u);
    uvec2 entry = brickEntry(i >> shift);
    if ((entry.x & kEntryValue) != 0u) return uintBitsToFloat(entry.y);
    ivec3 inside = i & ((1 << shift) - 1);
    return storedFromTexel(texelAt(uTexels, slotOrigin(entry, shift) + inside).r);
}

// Between samples of one level, whichever bricks they are in.
#if LOOP_OVER_CORNERS
float trilinearOverBricks(ivec3 low, ivec3 high, vec3 f, int shift) {
    CORNERS(float, v, low, high, at, latticeValue(at, shift))
    return trilinear(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], f.x, f.y, f.z);
}
#else
float trilinearOverBricks(ivec3 low, ivec3 high, vec3 f, int shift) {
    return trilinear(latticeValue(low, shift), latticeValue(ivec3(high.x, low.yz), shift),
                      latticeValue(ivec3(low.x, high.y, low.z), shift), latticeValue(ivec3(high.xy, low.z), shift),
                      latticeValue(ivec3(low.xy, high.z), shift),
                      latticeValue(ivec3(high.x, low.y, high.z), shift),
                      latticeValue(ivec3(low.x, high.yz), shift), latticeValue(high, shift), f.x, f.y, f.z);
}
#endif
