// sampler_channels.glsl: planes beside the values: the field of sampler_field.glsl over texels of up to four channels, which lie
// in the same slots. Always by texels and float arithmetic: there are no filtered fetches of them.
// Needs sampler_field.glsl. Gives channelsAt(texels, standing, p).

#if FEATURE_VOXEL_LIGHT || FEATURE_LABELS
vec4 channelTexels(vec4 texel) { return floor(texel * 65535.0 + 0.5); }
vec4 texelsAt(sampler3D texels, ivec3 at) {
    COUNT_FETCHES(1u);
    return channelTexels(texelFetch(texels, at, 0));
}
vec4 standingTexels(sampler3D standing, ivec3 brick) {
    COUNT_FETCHES(1u);
    return channelTexels(texelFetch(standing, brick, 0));
}

vec4 mixTexels(vec4 v000, vec4 v100, vec4 v010, vec4 v110, vec4 v001, vec4 v101, vec4 v011, vec4 v111, vec3 f) {
#define OF(c) trilinear(v000.c, v100.c, v010.c, v110.c, v001.c, v101.c, v011.c, v111.c, f.x, f.y, f.z)
    return vec4(OF(x), OF(y), OF(z), OF(w));
#undef OF
}

vec4 latticeTexels(sampler3D texels, sampler3D standing, ivec3 i, int shift) {
    ivec3 brick = i >> shift;
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) return standingTexels(standing, brick);
    return texelsAt(texels, slotOrigin(entry, shift) + (i & ((1 << shift) - 1)));
}

// Between samples of one level, whichever bricks they are in.
#if LOOP_OVER_CORNERS
vec4 texelsOverBricks(sampler3D texels, sampler3D standing, ivec3 low, ivec3 high, vec3 f, int shift) {
    CORNERS(vec4, v, low, high, at, latticeTexels(texels, standing, at, shift))
    return mixTexels(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], f);
}
#else
vec4 texelsOverBricks(sampler3D texels, sampler3D standing, ivec3 low, ivec3 high, vec3 f, int shift) {
    return mixTexels(latticeTexels(texels, standing, low, shift), latticeTexels(texels, standing, ivec3(high.x, low.yz), shift),
                    latticeTexels(texels, standing, ivec3(low.x, high.y, low.z), shift), latticeTexels(texels, standing, ivec3(high.xy, low.z), shift),
                    latticeTexels(texels, standing, ivec3(low.xy, high.z), shift), latticeTexels(texels, standing, ivec3(high.x, low.y, high.z), shift),
                    latticeTexels(texels, standing, ivec3(low.x, high.yz), shift), latticeTexels(texels, standing, high, shift), f);
}
#endif

#if FEATURE_MIXED
vec4 brickTexels(sampler3D texels, sampler3D standing, ivec3 brick, uint code, vec3 p) {
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) return standingTexels(standing, brick);
    int level = int(code);
    ivec3 first = brick << (5 - level);
    ivec3 last = min(ivec3(32 >> level), levelExtentOf(level) - first) - 1;
    precise vec3 at = p * samplesPerVoxel(level) - vec3(first) - 0.5;
    at = clamp(at, vec3(0.0), vec3(last));
    ivec3 low = ivec3(at);
    ivec3 high = min(low + 1, last);
    precise vec3 f = at - vec3(low);
    ivec3 o = slotOrigin(entry, 5 - level);
#if LOOP_OVER_CORNERS
    CORNERS(vec4, v, low, high, inside, texelsAt(texels, o + inside))
    return mixTexels(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], f);
#else
    return mixTexels(texelsAt(texels, o + low), texelsAt(texels, o + ivec3(high.x, low.yz)), texelsAt(texels, o + ivec3(low.x, high.y, low.z)),
                    texelsAt(texels, o + ivec3(high.xy, low.z)), texelsAt(texels, o + ivec3(low.xy, high.z)),
                    texelsAt(texels, o + ivec3(high.x, low.y, high.z)), texelsAt(texels, o + ivec3(low.x, high.yz)), texelsAt(texels, o + high), f);
#endif
}

vec4 channelsAt(sampler3D texels, sampler3D standing, vec3 position) {
    Place place = placeOf(position);
    uvec2 corner = cornerTexel(place.corner);
    if ((corner.y & kAgreeBit) != 0u) {
        int level = int((corner.y >> 13) & 7u);
        ivec3 last = levelExtentOf(level) - 1;
        precise vec3 at = place.p * samplesPerVoxel(level) - 0.5;
        at = clamp(at, vec3(0.0), vec3(last));
        ivec3 low = ivec3(at);
        precise vec3 f = at - vec3(low);
        return texelsOverBricks(texels, standing, low, min(low + 1, last), f, 5 - level);
    }
    int near = nearAxes(corner, place.offset);
    precise vec4 sum = vec4(0.0);
    precise float weights = 0.0;
    int subset = 0;
    do {
        TURN;
        int n = place.current ^ subset;
        float weight = cornerWeight(corner, n, near, place.offset);
        if (weight > 0.0) {
            sum = sum + weight * brickTexels(texels, standing, brickOf(place.corner, n), codeOf(corner, n), place.p);
            weights = weights + weight;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    if (near == 0) return sum;
    precise vec4 value = sum / weights;
    return value;
}
#else
vec4 channelsAt(sampler3D texels, sampler3D standing, vec3 p) {
    precise vec3 at = p * uSamplesPerVoxel - 0.5;
    at = clamp(at, vec3(0.0), vec3(uLevelExtent - 1));
    ivec3 low = ivec3(at);
    precise vec3 f = at - vec3(low);
    return texelsOverBricks(texels, standing, low, min(low + 1, uLevelExtent - 1), f, uBrickShift);
}
#endif
#endif
