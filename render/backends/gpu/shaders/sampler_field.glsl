// sampler_field.glsl: the field of docs/sampling.md: the only code that turns a position into a value or a gradient;
// as render/contract/sampler.h has it. Bricks of mixed levels are in sampler_interblock.glsl; where all share one
// level, the field is plain trilinear interpolation on that level's lattice, empty bricks reading as their mean.
// Needs FEATURE_MIXED and those of sampler_atlas.glsl. Gives fieldValue(p); p in level-0 voxels, values as stored;
// and the functions of sampler_current_brick.glsl and sampler_gradient.glsl.

#include "sampler_atlas.glsl"
#if FEATURE_MIXED
#include "sampler_interblock.glsl"
#else

OF_VOLUME ivec3 uLevelExtent;     // samples
OF_VOLUME float uSamplesPerVoxel; // 2^-level
OF_VOLUME float uVoxelsPerSample; // 2^level
OF_VOLUME int uBrickShift;        // log2 of the samples per brick edge: 5 - level

#if FEATURE_HARDWARE
// at: lattice coordinates, between samples of this one brick.
float filteredInBrick(ivec3 brick, vec3 at) {
    COUNT_FETCHES(1u);
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) return uintBitsToFloat(entry.y);
    vec3 texel = vec3(slotOrigin(entry, uBrickShift) - (brick << uBrickShift)) + at + 0.5;
    return storedFromFiltered(textureLod(uVoxels, texel * uTexelSize, 0.0).r);
}
#endif

float fieldValue(vec3 p) {
    precise vec3 at = p * uSamplesPerVoxel - 0.5;
    at = clamp(at, vec3(0.0), vec3(uLevelExtent - 1));
    ivec3 low = ivec3(at); // not negative, so this is floor
    ivec3 high = min(low + 1, uLevelExtent - 1);
#if FEATURE_HARDWARE
    // One filtered fetch per brick that holds a part of the eight samples: one almost everywhere, two across a
    // face. In the axes that cross, the fetch sits on the outermost sample, so the filter never leaves the slot.
    ivec3 brick = low >> uBrickShift;
    ivec3 crosses = (high >> uBrickShift) - brick;
    vec3 f = at - vec3(low);
    int mask = crosses.x | crosses.y << 1 | crosses.z << 2;
    int corner = 0;
    float value = 0.0;
    do {
        TURN;
        ivec3 side = ivec3(corner, corner >> 1, corner >> 2) & 1;
        vec3 weights = mix(vec3(1.0), mix(1.0 - f, f, vec3(side)), vec3(crosses));
        value += weights.x * weights.y * weights.z *
                 filteredInBrick(brick + side, mix(at, vec3(low + side), vec3(crosses)));
        corner = (corner - mask) & mask; // the next subset of the axes that cross
    } while (corner != 0);
    return value;
#else
    precise vec3 f = at - vec3(low);
    return trilinearOverBricks(low, high, f, uBrickShift);
#endif
}

float localPitch(vec3 p) { return uVoxelsPerSample; }
#endif

#include "sampler_current_brick.glsl"

#include "sampler_gradient.glsl"
