// sampler_home.glsl: the brick that a ray is in. A ray stays for many samples; what they share is looked up once,
// and where no other brick has weight a value is one fetch. The same values as fieldValue(), bit for bit in exact
// mode. Needs sampler_field.glsl. Gives enterHome(p), leaveHome(), inHome(p), homeValue(p),
// homePitch(); for strides gHomeStride, gStartLow, gStartHigh; for counting gHomeNumber.

const float kFar = 1e9;
vec3 gHomeLow = vec3(kFar), gHomeHigh = vec3(-kFar); // voxels: between them no other brick has weight
float gHomeScale, gHomeValue;                        // texel = position * scale + offset; or all one value
bool gHomeIsValue = true;
#if FEATURE_VISIBILITY
int gHomeNumber = -1; // of the brick, [z][y][x]
#endif
#if FEATURE_HARDWARE
vec3 gHomeOffset, gFirstTexel, gLastTexel;
#else
ivec3 gHomeFirst, gHomeLast, gHomeOrigin;            // samples
#endif
#if FEATURE_MIXED
uniform usampler3D uFacts; // one texel per brick: see render/contract/level_map.h
uniform int uMostStride;   // no stride above 2^this
uniform float uStepVoxels; // length of a segment
vec3 gStartLow = vec3(kFar), gStartHigh = vec3(-kFar); // voxels: where no finer brick limits the stride
int gHomeStride = 0;
float gHomePitch = 1.0;

// How far from a face other bricks have weight; beyond the volume's border there is nothing.
float faceReach(uint facts, int face) {
    uint code = (facts >> (3 + 3 * face)) & 7u;
    return code == 7u ? -kFar : code == 6u ? 0.0 : halfSample(code);
}
float faceLimit(uint facts, int face, float reach) { return ((facts >> (21 + face)) & 1u) != 0u ? reach : 0.0; }
#endif

void enterHome(vec3 position) {
#if FEATURE_MIXED
    vec3 p = clamp(position, vec3(0.0), vec3(uExtentVoxels));
    ivec3 brick = min(ivec3(p) >> 5, uBricks - 1);
    uint facts = texelFetch(uFacts, brick, 0).x;
    uint code = facts & 7u;
    vec3 low = vec3(faceReach(facts, 0), faceReach(facts, 1), faceReach(facts, 2));
    vec3 high = vec3(faceReach(facts, 3), faceReach(facts, 4), faceReach(facts, 5));
    gHomeStride = min(int(code), uMostStride);
    float reach = max(halfSample(min(code, 5u)), uStepVoxels * float(1 << gHomeStride));
    gStartLow = vec3(brick * 32) + vec3(faceLimit(facts, 0, reach), faceLimit(facts, 1, reach), faceLimit(facts, 2, reach));
    gStartHigh = vec3(brick * 32 + 32) - vec3(faceLimit(facts, 3, reach), faceLimit(facts, 4, reach), faceLimit(facts, 5, reach));
    gHomePitch = float(1 << (code == kCodeEmpty ? uint(uFinest) : code));
    int level = code < 5u ? int(code) : 0;
    ivec3 extent = levelExtentOf(level);
    gHomeScale = samplesPerVoxel(level);
#else
    vec3 p = clamp(position * uSamplesPerVoxel, vec3(0.0), vec3(uLevelExtent - 1));
    ivec3 brick = ivec3(p) >> uBrickShift;
    ivec3 extent = uLevelExtent;
    int level = 5 - uBrickShift;
    vec3 low = mix(vec3(0.5 * uVoxelsPerSample), vec3(-kFar), equal(brick, ivec3(0)));
    vec3 high = mix(vec3(0.5 * uVoxelsPerSample), vec3(-kFar),
                    greaterThanEqual((brick + 1) << uBrickShift, uLevelExtent));
    gHomeScale = uSamplesPerVoxel;
#endif
    gHomeLow = vec3(brick * 32) + low;
    gHomeHigh = vec3(brick * 32 + 32) - high;
    uvec2 entry = brickEntry(brick);
#if FEATURE_VISIBILITY
    ivec3 bricks = textureSize(uIndex, 0);
    gHomeNumber = (brick.z * bricks.y + brick.y) * bricks.x + brick.x;
#endif
    gHomeIsValue = (entry.x & kEntryValue) != 0u;
    gHomeValue = uintBitsToFloat(entry.y);
    ivec3 first = brick << (5 - level);
    ivec3 origin = slotOrigin(entry, 5 - level);
    ivec3 last = min(ivec3(32 >> level), extent - first) - 1;
#if FEATURE_HARDWARE
    gHomeOffset = vec3(origin - first);
    gFirstTexel = vec3(origin) + 0.5;
    gLastTexel = gFirstTexel + vec3(last);
#else
    gHomeFirst = first;
    gHomeLast = last;
    gHomeOrigin = origin;
#endif
}

// Until another brick is entered.
void leaveHome() {
    gHomeLow = vec3(kFar);
    gHomeHigh = vec3(-kFar);
}

bool inHome(vec3 p) { return all(greaterThanEqual(p, gHomeLow)) && all(lessThan(p, gHomeHigh)); }

float homeValue(vec3 p) {
#if FEATURE_HARDWARE
    COUNT_FETCHES(1u);
    vec3 texel = clamp(p * gHomeScale + gHomeOffset, gFirstTexel, gLastTexel);
    float value = storedFromFiltered(textureLod(uVoxels, texel * uTexelSize, 0.0).r);
    return gHomeIsValue ? gHomeValue : value;
#else
    if (gHomeIsValue) return gHomeValue;
    precise vec3 at = p * gHomeScale - vec3(gHomeFirst) - 0.5;
    at = clamp(at, vec3(0.0), vec3(gHomeLast));
    ivec3 low = ivec3(at);
    precise vec3 f = at - vec3(low);
    return trilinearInSlot(gHomeOrigin + low, gHomeOrigin + min(low + 1, gHomeLast), f);
#endif
}

#if FEATURE_MIXED
float homePitch() { return gHomePitch; }
#else
float homePitch() { return uVoxelsPerSample; }
#endif
