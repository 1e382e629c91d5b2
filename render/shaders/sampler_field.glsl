// sampler_field.glsl: the field of docs/sampling.md: the only code that turns a position into a value or a
// gradient; twin of render/sampler.h. Bricks of mixed levels are in sampler_interblock.glsl; where all share one
// level, the field is plain trilinear interpolation on that level's lattice, empty bricks reading as their mean.
// Needs FEATURE_MIXED and those of sampler_atlas.glsl. Gives fieldValue(p), fieldGradient(p); p in level-0
// voxels, values as stored, gradients in stored units per voxel; and what sampler_home.glsl gives.

#include "sampler_atlas.glsl"
#if FEATURE_MIXED
#include "sampler_interblock.glsl"
#else

uniform ivec3 uLevelExtent;     // samples
uniform float uSamplesPerVoxel; // 2^-level
uniform float uVoxelsPerSample; // 2^level
#if FEATURE_BRICKED
uniform int uBrickShift;        // log2 of the samples per brick edge: 5 - level
#endif

#if FEATURE_HARDWARE && FEATURE_BRICKED
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
#if FEATURE_HARDWARE && FEATURE_BRICKED
    // One filtered fetch per brick that holds a part of the eight samples: one almost everywhere, two across a
    // face. In the axes that cross, the fetch sits on the outermost sample, so the filter never leaves the slot.
    ivec3 brick = low >> uBrickShift;
    ivec3 crosses = (high >> uBrickShift) - brick;
    vec3 f = at - vec3(low);
    int mask = crosses.x | crosses.y << 1 | crosses.z << 2;
    int corner = 0;
    float value = 0.0;
    do {
        ++gTurns;
        ivec3 side = ivec3(corner, corner >> 1, corner >> 2) & 1;
        vec3 weights = mix(vec3(1.0), mix(1.0 - f, f, vec3(side)), vec3(crosses));
        value += weights.x * weights.y * weights.z *
                 filteredInBrick(brick + side, mix(at, vec3(low + side), vec3(crosses)));
        corner = (corner - mask) & mask; // the next subset of the axes that cross
    } while (corner != 0);
    return value;
#elif FEATURE_HARDWARE
    COUNT_FETCHES(1u);
    return storedFromFiltered(textureLod(uVoxels, (at + 0.5) * uTexelSize, 0.0).r);
#else
    precise vec3 f = at - vec3(low);
#if FEATURE_BRICKED
    return trilinearOverBricks(low, high, f, uBrickShift);
#else
    return trilinearInSlot(low, high, f);
#endif
#endif
}

float localPitch(vec3 p) { return uVoxelsPerSample; }
#endif

#include "sampler_home.glsl"

// Central differences of this very field, offset half a sample.
vec3 fieldGradient(vec3 p) {
    precise float pitch = inHome(p) ? homePitch() : localPitch(p);
    precise float h = 0.5 * pitch;
    // A compiler for SIMD lanes runs both sides of a branch, but a loop only as long as a lane needs it: so the
    // six values are taken from the brick at hand, and those again, one by one, where other bricks have weight.
    vec3 ahead;
    vec3 behind;
    int outside = 0; // bits: ahead along x, y, z, then behind
    for (int axis = 0; axis < 3; ++axis) {
        vec3 offset = vec3(0.0);
        offset[axis] = h;
        precise vec3 up = p + offset;
        precise vec3 down = p - offset;
        ahead[axis] = homeValue(up);
        behind[axis] = homeValue(down);
        outside |= int(!inHome(up)) << axis | int(!inHome(down)) << (axis + 3);
    }
    gTurns += 3;
    for (; outside != 0; outside &= outside - 1) {
        ++gTurns;
        int turn = findLSB(outside);
        bvec3 axis = equal(ivec3(turn >= 3 ? turn - 3 : turn), ivec3(0, 1, 2));
        precise vec3 at = p + mix(vec3(0.0), vec3(turn < 3 ? h : -h), axis);
        float value = fieldValue(at);
        if (turn < 3) ahead = mix(ahead, vec3(value), axis);
        else behind = mix(behind, vec3(value), axis);
    }
    precise vec3 g = (ahead - behind) / pitch;
    return g;
}
