// sampler_slope.glsl: the derivative of the field itself: of trilinear interpolation, and of the blends between
// bricks of mixed levels; as the "slopes" of render/contract/sampler.h. Needs sampler_current_brick.glsl, FEATURE_MIXED.
// Gives fieldSlope(p), and currentBrickSlope(p) where inCurrentBrick(p): stored units per voxel.

// xyz: derivative along the lattice's axes, per sample; w: the value.
vec4 asVector(CellSlope s) { return vec4(s.x, s.y, s.z, s.value); }

// Between texels of one slot.
vec4 slopeInSlot(ivec3 low, ivec3 high, vec3 f) {
    return asVector(trilinearSlope(texelValue(low), texelValue(ivec3(high.x, low.yz)),
                          texelValue(ivec3(low.x, high.y, low.z)), texelValue(ivec3(high.xy, low.z)),
                          texelValue(ivec3(low.xy, high.z)), texelValue(ivec3(high.x, low.y, high.z)),
                          texelValue(ivec3(low.x, high.yz)), texelValue(high), f.x, f.y, f.z));
}

// Between samples of one level, whichever bricks they are in. shift: log2 of the samples per brick edge
vec4 slopeOverBricks(ivec3 low, ivec3 high, vec3 f, int shift) {
    return asVector(trilinearSlope(latticeValue(low, shift), latticeValue(ivec3(high.x, low.yz), shift),
                          latticeValue(ivec3(low.x, high.y, low.z), shift),
                          latticeValue(ivec3(high.xy, low.z), shift),
                          latticeValue(ivec3(low.xy, high.z), shift),
                          latticeValue(ivec3(high.x, low.y, high.z), shift),
                          latticeValue(ivec3(low.x, high.yz), shift), latticeValue(high, shift), f.x, f.y, f.z));
}

// Beyond the outermost samples the field is constant along that axis.
vec4 perVoxel(vec4 slope, vec3 at, vec3 inside, float samplesPerVoxel) {
    return vec4(mix(vec3(0.0), slope.xyz * samplesPerVoxel, equal(at, inside)), slope.w);
}

#if FEATURE_MIXED
vec4 brickSlope(ivec3 brick, uint code, vec3 p) {
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) return vec4(vec3(0.0), uintBitsToFloat(entry.y));
    int level = int(code);
    ivec3 first = brick << (5 - level);
    ivec3 last = min(ivec3(32 >> level), levelExtentOf(level) - first) - 1;
    precise vec3 at = p * samplesPerVoxel(level) - vec3(first) - 0.5;
    vec3 inside = clamp(at, vec3(0.0), vec3(last));
    ivec3 low = ivec3(inside);
    precise vec3 f = inside - vec3(low);
    ivec3 origin = slotOrigin(entry, 5 - level);
    return perVoxel(slopeInSlot(origin + low, origin + min(low + 1, last), f), at, inside, samplesPerVoxel(level));
}

vec3 fieldSlope(vec3 position) {
    Place place = placeOf(position);
    uvec2 corner = cornerTexel(place.corner);
    if ((corner.y & kAgreeBit) != 0u) {
        int level = int((corner.y >> 13) & 7u);
        ivec3 last = levelExtentOf(level) - 1;
        precise vec3 at = place.p * samplesPerVoxel(level) - 0.5;
        vec3 inside = clamp(at, vec3(0.0), vec3(last));
        ivec3 low = ivec3(inside);
        precise vec3 f = inside - vec3(low);
        return perVoxel(slopeOverBricks(low, min(low + 1, last), f, 5 - level), at, inside,
                        samplesPerVoxel(level)).xyz;
    }
    int near = nearAxes(corner, place.offset);
    // The value is sum / weights; values count from the current brick's, so that equal ones have no slope at all.
    precise float sum = 0.0;
    precise float weights = 0.0;
    precise vec3 sumSlope = vec3(0.0);
    precise vec3 weightsSlope = vec3(0.0);
    float current = 0.0;
    int subset = 0;
    do {
        TURN;
        int n = place.current ^ subset;
        vec3 edgeSlopes;
        precise vec3 edge = edgeWeights(corner, n, near, place.offset, edgeSlopes);
        precise float weight = edge.x * edge.y * edge.z;
        if (codeOf(corner, n) != kCodeOutside && weight > 0.0) {
            vec4 brick = brickSlope(brickOf(place.corner, n), codeOf(corner, n), place.p);
            if (subset == 0) current = brick.w;
            precise float value = brick.w - current;
            precise vec3 weightSlope = edgeSlopes * (edge.yzx * edge.zxy);
            sum = sum + weight * value;
            sumSlope = sumSlope + (weightSlope * value + weight * brick.xyz);
            weights = weights + weight;
            weightsSlope = weightsSlope + weightSlope;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    precise vec3 slope = (sumSlope - (sum / weights) * weightsSlope) / weights;
    return slope;
}
#else
vec3 fieldSlope(vec3 p) {
    precise vec3 at = p * uSamplesPerVoxel - 0.5;
    vec3 inside = clamp(at, vec3(0.0), vec3(uLevelExtent - 1));
    ivec3 low = ivec3(inside);
    ivec3 high = min(low + 1, uLevelExtent - 1);
    precise vec3 f = inside - vec3(low);
    return perVoxel(slopeOverBricks(low, high, f, uBrickShift), at, inside, uSamplesPerVoxel).xyz;
}
#endif

vec3 currentBrickSlope(vec3 p) {
    if (gBrickIsValue) return vec3(0.0);
#if FEATURE_HARDWARE
    precise vec3 at = p * gBrickScale + gBrickOffset - 0.5; // from the atlas' own first texel
    vec3 inside = clamp(at, gFirstTexel - 0.5, gLastTexel - 0.5);
    ivec3 last = ivec3(gLastTexel);
    ivec3 low = ivec3(inside);
#else
    precise vec3 at = p * gBrickScale - vec3(gBrickFirst) - 0.5;
    vec3 inside = clamp(at, vec3(0.0), vec3(gBrickLast));
    ivec3 low = ivec3(inside);
#endif
    precise vec3 f = inside - vec3(low);
#if FEATURE_HARDWARE
    return perVoxel(slopeInSlot(low, min(low + 1, last), f), at, inside, gBrickScale).xyz;
#else
    return perVoxel(slopeInSlot(gBrickOrigin + low, gBrickOrigin + min(low + 1, gBrickLast), f), at, inside,
                    gBrickScale).xyz;
#endif
}
