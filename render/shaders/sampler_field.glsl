// sampler_field.glsl: the field of docs/sampling.md: the only code that turns a position into a value or a
// gradient; twin of render/sampler.h. All resident bricks share one level, where the normalised weights of the
// course notes are plain trilinear interpolation on that level's lattice, empty bricks reading as their mean.
// Needs FEATURE_BRICKED, FEATURE_HARDWARE, FEATURE_NORMALISED. Gives fieldValue(p), fieldGradient(p);
// p in level-0 voxels, values as stored.

uniform sampler3D uVoxels;    // atlas pages, or the whole level
uniform ivec3 uLevelExtent;   // samples
uniform float uSamplesPerVoxel; // 2^-level
uniform float uVoxelsPerSample; // 2^level
#if FEATURE_NORMALISED
uniform float uStoredBias;    // stored value = 65535 * texel + bias, exactly
#endif
#if FEATURE_BRICKED
uniform usampler3D uIndex;    // one texel per brick: see atlas.h
uniform int uBrickShift;      // log2 of the samples per brick edge: 5 - level
const uint kEntryEmpty = 0x80000000u;
#endif
#if FEATURE_HARDWARE
uniform vec3 uTexelSize;      // 1 / extent of uVoxels
#endif

#if FEATURE_COUNTING
uint gFetches = 0u;
#define COUNT_FETCHES(n) gFetches += n
#else
#define COUNT_FETCHES(n)
#endif

float storedFromTexel(float texel) {
#if FEATURE_NORMALISED
    return floor(texel * 65535.0 + 0.5) + uStoredBias;
#else
    return texel;
#endif
}

float storedFromFiltered(float texel) {
#if FEATURE_NORMALISED
    return texel * 65535.0 + uStoredBias;
#else
    return texel;
#endif
}

#if FEATURE_BRICKED
// First texel of the brick's slot. x: page (3 x 10 bits), y: slot inside it (3 x 5 bits), both in slots' units.
ivec3 slotOrigin(uvec2 entry) {
    ivec3 page = ivec3(entry.x & 1023u, (entry.x >> 10) & 1023u, (entry.x >> 20) & 1023u);
    ivec3 slot = ivec3(entry.y & 31u, (entry.y >> 5) & 31u, (entry.y >> 10) & 31u);
    return page * 32 + (slot << uBrickShift);
}

float latticeValue(ivec3 i) {
    COUNT_FETCHES(1u);
    uvec2 entry = texelFetch(uIndex, i >> uBrickShift, 0).xy;
    if ((entry.x & kEntryEmpty) != 0u) return uintBitsToFloat(entry.y);
    ivec3 inside = i & ((1 << uBrickShift) - 1);
    return storedFromTexel(texelFetch(uVoxels, slotOrigin(entry) + inside, 0).r);
}
#else
float latticeValue(ivec3 i) {
    COUNT_FETCHES(1u);
    return storedFromTexel(texelFetch(uVoxels, i, 0).r);
}
#endif

float trilinear(ivec3 low, ivec3 high, vec3 f) {
    float v000 = latticeValue(low);
    float v100 = latticeValue(ivec3(high.x, low.yz));
    float v010 = latticeValue(ivec3(low.x, high.y, low.z));
    float v110 = latticeValue(ivec3(high.xy, low.z));
    float v001 = latticeValue(ivec3(low.xy, high.z));
    float v101 = latticeValue(ivec3(high.x, low.y, high.z));
    float v011 = latticeValue(ivec3(low.x, high.yz));
    float v111 = latticeValue(high);
    precise float a = v000 + f.x * (v100 - v000);
    precise float b = v010 + f.x * (v110 - v010);
    precise float c = v001 + f.x * (v101 - v001);
    precise float d = v011 + f.x * (v111 - v011);
    precise float e = a + f.y * (b - a);
    precise float g = c + f.y * (d - c);
    precise float v = e + f.z * (g - e);
    return v;
}

#if FEATURE_HARDWARE && FEATURE_BRICKED
// A ray stays in a brick for many samples: its entry is looked up once.
ivec3 gBrick = ivec3(-1);
uvec2 gEntry = uvec2(0u);

// at: lattice coordinates, between samples of this one brick.
float filteredInBrick(ivec3 brick, vec3 at) {
    COUNT_FETCHES(1u);
    if (brick != gBrick) {
        gBrick = brick;
        gEntry = texelFetch(uIndex, brick, 0).xy;
    }
    uvec2 entry = gEntry;
    if ((entry.x & kEntryEmpty) != 0u) return uintBitsToFloat(entry.y);
    vec3 texel = vec3(slotOrigin(entry) - (brick << uBrickShift)) + at + 0.5;
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
    return trilinear(low, high, f);
#endif
}

// Central differences of this very field, offset half a sample; stored units per sample pitch.
vec3 fieldGradient(vec3 p) {
    vec3 g;
    precise float h = 0.5 * uVoxelsPerSample;
    for (int axis = 0; axis < 3; ++axis) {
        vec3 offset = vec3(0.0);
        offset[axis] = h;
        precise vec3 ahead = p + offset;
        precise vec3 behind = p - offset;
        g[axis] = fieldValue(ahead) - fieldValue(behind);
    }
    return g;
}
