// sampler_light.glsl: light of voxels: the field of sampler_field.glsl over the planes of light, which lie in the same slots;
// as NativeField::received() and StoredLight have it. Always by texels and float arithmetic: there are no filtered fetches of it.
// Needs FEATURE_VOXEL_LIGHT, FEATURE_EMISSION, sampler_field.glsl, march_lights.glsl. Gives receivedLight(p).

#if FEATURE_VOXEL_LIGHT
uniform sampler3D uLightTexels;   // a component a channel, at the texels of the atlas
uniform sampler3D uLightStanding; // of bricks that stand as one value
uniform int uOcclusionChannel;    // -1: none
uniform int uLightChannel[kMostLights];
#if FEATURE_EMISSION
uniform int uAmbientChannels; // of light from all sides: one for all colours, or the first three
#endif

vec4 lightTexels(vec4 texel) { return floor(texel * 65535.0 + 0.5); }
vec4 lightAt(ivec3 at) {
    COUNT_FETCHES(1u);
    return lightTexels(texelFetch(uLightTexels, at, 0));
}
vec4 standingLight(ivec3 brick) {
    COUNT_FETCHES(1u);
    return lightTexels(texelFetch(uLightStanding, brick, 0));
}

vec4 mixLight(vec4 v000, vec4 v100, vec4 v010, vec4 v110, vec4 v001, vec4 v101, vec4 v011, vec4 v111, vec3 f) {
#define OF(c) trilinear(v000.c, v100.c, v010.c, v110.c, v001.c, v101.c, v011.c, v111.c, f.x, f.y, f.z)
    return vec4(OF(x), OF(y), OF(z), OF(w));
#undef OF
}

vec4 latticeLight(ivec3 i, int shift) {
    ivec3 brick = i >> shift;
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) return standingLight(brick);
    return lightAt(slotOrigin(entry, shift) + (i & ((1 << shift) - 1)));
}

// Between samples of one level, whichever bricks they are in.
vec4 lightOverBricks(ivec3 low, ivec3 high, vec3 f, int shift) {
    return mixLight(latticeLight(low, shift), latticeLight(ivec3(high.x, low.yz), shift),
                    latticeLight(ivec3(low.x, high.y, low.z), shift), latticeLight(ivec3(high.xy, low.z), shift),
                    latticeLight(ivec3(low.xy, high.z), shift), latticeLight(ivec3(high.x, low.y, high.z), shift),
                    latticeLight(ivec3(low.x, high.yz), shift), latticeLight(high, shift), f);
}

#if FEATURE_MIXED
vec4 brickLight(ivec3 brick, uint code, vec3 p) {
    uvec2 entry = brickEntry(brick);
    if ((entry.x & kEntryValue) != 0u) return standingLight(brick);
    int level = int(code);
    ivec3 first = brick << (5 - level);
    ivec3 last = min(ivec3(32 >> level), levelExtentOf(level) - first) - 1;
    precise vec3 at = p * samplesPerVoxel(level) - vec3(first) - 0.5;
    at = clamp(at, vec3(0.0), vec3(last));
    ivec3 low = ivec3(at);
    ivec3 high = min(low + 1, last);
    precise vec3 f = at - vec3(low);
    ivec3 o = slotOrigin(entry, 5 - level);
    return mixLight(lightAt(o + low), lightAt(o + ivec3(high.x, low.yz)), lightAt(o + ivec3(low.x, high.y, low.z)),
                    lightAt(o + ivec3(high.xy, low.z)), lightAt(o + ivec3(low.xy, high.z)),
                    lightAt(o + ivec3(high.x, low.y, high.z)), lightAt(o + ivec3(low.x, high.yz)), lightAt(o + high), f);
}

vec4 lightTexelsAt(vec3 position) {
    Place place = placeOf(position);
    uvec2 corner = cornerTexel(place.corner);
    if ((corner.y & kAgreeBit) != 0u) {
        int level = int((corner.y >> 13) & 7u);
        ivec3 last = levelExtentOf(level) - 1;
        precise vec3 at = place.p * samplesPerVoxel(level) - 0.5;
        at = clamp(at, vec3(0.0), vec3(last));
        ivec3 low = ivec3(at);
        precise vec3 f = at - vec3(low);
        return lightOverBricks(low, min(low + 1, last), f, 5 - level);
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
            sum = sum + weight * brickLight(brickOf(place.corner, n), codeOf(corner, n), place.p);
            weights = weights + weight;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    if (near == 0) return sum;
    precise vec4 value = sum / weights;
    return value;
}
#else
vec4 lightTexelsAt(vec3 p) {
    precise vec3 at = p * uSamplesPerVoxel - 0.5;
    at = clamp(at, vec3(0.0), vec3(uLevelExtent - 1));
    ivec3 low = ivec3(at);
    precise vec3 f = at - vec3(low);
    return lightOverBricks(low, min(low + 1, uLevelExtent - 1), f, uBrickShift);
}
#endif

ReceivedLight receivedLight(vec3 p) {
    precise vec4 light = lightTexelsAt(p) * (1.0 / 16384.0);
    ReceivedLight received = allLight();
    if (uOcclusionChannel >= 0) received.fromAllSides = vec3(light[uOcclusionChannel]);
#if FEATURE_EMISSION
    if (uAmbientChannels > 1) received.fromAllSides = light.rgb;
#endif
    TURNS(4);
    for (int i = 0; i < kMostLights; ++i)
        if (uLightChannel[i] >= 0) received.from[i] = light[uLightChannel[i]];
    return received;
}
#elif FEATURE_LIGHTS
ReceivedLight receivedLight(vec3 p) { return allLight(); }
#endif
