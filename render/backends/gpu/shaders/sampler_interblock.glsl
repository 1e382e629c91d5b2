// sampler_interblock.glsl: the field of mixed levels: blends of the eight bricks around the nearest brick
// corner (docs/sampling.md, "Value"; course notes 2.10.2); as in render/contract/level_map.h and render/contract/sampler.h.
// Needs sampler_atlas.glsl. Gives fieldValue(p), localPitch(p), placeOf(p), cornerTexel, codeOf, gBlended.

#include "leaf_bricks.h"

OF_VOLUME TEXELS_RG32UI uCorners; // one texel per brick corner: see render/contract/level_map.h
OF_VOLUME ivec3 uBricks;        // grid of bricks
OF_VOLUME ivec3 uExtentVoxels;
OF_VOLUME int uEdgeFunction;    // 0 nearest, 1 minimum, 2 split, 3 maximum
OF_VOLUME int uFinest;          // level of the selection

const uint kCodeEmpty = uint(kEmptyCode), kCodeOutside = uint(kOutsideCode), kNoReach = 15u, kAgreeBit = 1u << 12;

#if FEATURE_COUNTING
uint gBlended = 0u; // evaluations that took more than the brick at hand
#endif

uint codeOf(uvec2 corner, int brick) { return (corner.x >> (4 * brick)) & 15u; }
float halfSample(uint level) { return uintBitsToFloat((126u + level) << 23); }

struct Place {
    ivec3 corner;
    vec3 p, offset; // voxels
    int current;
};

Place placeOf(vec3 position) {
    Place place;
    place.p = position;
    ivec3 brick = min(ivec3(clamp(position, vec3(0.0), vec3(uExtentVoxels))) >> 5, uBricks - 1);
    vec3 inside = place.p - vec3(brick * 32);
    bvec3 lower = lessThan(inside, vec3(16.0));
    place.corner = brick + 1 - ivec3(lower);
    place.offset = inside - 32.0 * (1.0 - vec3(lower));
    ivec3 bits = ivec3(lower);
    place.current = bits.x | bits.y << 1 | bits.z << 2;
    return place;
}

uvec2 cornerTexel(ivec3 corner) { return texelAt(uCorners, corner).xy; }

int nearAxes(uvec2 corner, vec3 offset) {
    int near = 0;
    TURNS(3);
    for (int axis = 0; axis < 3; ++axis) {
        uint reach = (corner.y >> (4 * axis)) & 15u;
        if (reach != kNoReach && abs(offset[axis]) < halfSample(reach)) near |= 1 << axis;
    }
    return near;
}

// Edge weight of one of the eight along an axis, given by its bit, 1 where that is not near; slope: its derivative.
float edgeAlong(uvec2 corner, int brick, int near, int bit, float offset, out float slope) {
    int own = int(codeOf(corner, brick));
    int other = int(codeOf(corner, brick ^ bit));
    bool upper = (brick & bit) != 0;
    float into = upper ? offset : -offset;
    int level = edgeLevel(own, other, into >= 0.0, uEdgeFunction, uFinest);
    bool counts = (near & bit) != 0 && other != kOutsideCode;
    bool steps = uEdgeFunction == kNearestEdge && own != kEmptyCode && other != kEmptyCode;
    float weight = steps ? edgeStep(into, upper) : edgeWeight(into, uintBitsToFloat(uint(128 - level) << 23));
    slope = counts && !steps ? edgeSlope(into, halfSample(uint(level)), upper) : 0.0;
    return counts ? weight : 1.0;
}
vec3 edgeWeights(uvec2 corner, int brick, int near, vec3 offset, out vec3 slopes) {
    float x = edgeAlong(corner, brick, near, 1, offset.x, slopes.x);
    float y = edgeAlong(corner, brick, near, 2, offset.y, slopes.y);
    float z = edgeAlong(corner, brick, near, 4, offset.z, slopes.z);
    return vec3(x, y, z);
}

// Weight of one of the eight before normalisation: the product of its edge weights along the near axes.
float cornerWeight(uvec2 corner, int brick, int near, vec3 offset) {
    vec3 slopes;
    precise vec3 weights = edgeWeights(corner, brick, near, offset, slopes);
    precise float weight = weights.x * weights.y * weights.z;
    return codeOf(corner, brick) == kCodeOutside ? 0.0 : weight;
}

ivec3 brickOf(ivec3 corner, int brick) { return corner - 1 + (ivec3(brick, brick >> 1, brick >> 2) & 1); }
ivec3 levelExtentOf(int level) { return (uExtentVoxels + ((1 << level) - 1)) >> level; }
float samplesPerVoxel(int level) { return uintBitsToFloat(uint(127 - level) << 23); }

// A brick's own value: coordinates clamped half a sample inside it.
float brickValue(ivec3 brick, uint code, vec3 p) {
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) {
        COUNT_FETCHES(1u);
        return uintBitsToFloat(entry.y);
    }
    int level = int(code);
    ivec3 first = brick << (5 - level);
    ivec3 last = min(ivec3(32 >> level), levelExtentOf(level) - first) - 1;
    precise vec3 at = p * samplesPerVoxel(level) - vec3(first) - 0.5;
    at = clamp(at, vec3(0.0), vec3(last));
    ivec3 origin = slotOrigin(entry, 5 - level);
#if FEATURE_HARDWARE
    COUNT_FETCHES(1u);
    return storedFromFiltered(textureLod(uVoxels, (vec3(origin) + at + 0.5) * uTexelSize, 0.0).r);
#else
    ivec3 low = ivec3(at);
    precise vec3 f = at - vec3(low);
    return trilinearInSlot(origin + low, origin + min(low + 1, last), f);
#endif
}

float fieldValue(vec3 position) {
    Place place = placeOf(position);
    uvec2 corner = cornerTexel(place.corner);
    int near = nearAxes(corner, place.offset);
#if FEATURE_COUNTING
    if (near != 0) ++gBlended;
#endif
#if !FEATURE_HARDWARE
    if ((corner.y & kAgreeBit) != 0u) {
        int level = int((corner.y >> 13) & 7u);
        ivec3 last = levelExtentOf(level) - 1;
        precise vec3 at = place.p * samplesPerVoxel(level) - 0.5;
        at = clamp(at, vec3(0.0), vec3(last));
        ivec3 low = ivec3(at);
        precise vec3 f = at - vec3(low);
        return trilinearOverBricks(low, min(low + 1, last), f, 5 - level);
    }
#endif
    precise float sum = 0.0;
    precise float weights = 0.0;
    int subset = 0;
    do { // the current brick, then every brick across some of the near axes
        TURN;
        int n = place.current ^ subset;
        float weight = cornerWeight(corner, n, near, place.offset);
        if (weight > 0.0) {
            sum = sum + weight * brickValue(brickOf(place.corner, n), codeOf(corner, n), place.p);
            weights = weights + weight;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    if (near == 0) return sum;
    precise float value = sum / weights;
    return value;
}

// Distance of samples, voxels, with the weights of their values; empty bricks count as the finest level.
float localPitch(vec3 position) {
    Place place = placeOf(position);
    uvec2 corner = cornerTexel(place.corner);
    int near = (corner.y & kAgreeBit) != 0u ? 0 : nearAxes(corner, place.offset);
    precise float sum = 0.0;
    precise float weights = 0.0;
    int subset = 0;
    do {
        TURN;
        int n = place.current ^ subset;
        float weight = cornerWeight(corner, n, near, place.offset);
        uint code = codeOf(corner, n);
        sum = sum + weight * float(1 << (code == kCodeEmpty ? uint(uFinest) : code));
        weights = weights + weight;
        subset = (subset - near) & near;
    } while (subset != 0);
    precise float pitch = sum / weights;
    return pitch;
}
