// sampler_current_brick.glsl: the brick that a ray is in. A ray stays for many samples; their common data are read
// once, and where no other brick has weight a value is one fetch. The same values as fieldValue(), bit for bit in
// exact mode. Needs sampler_field.glsl. Gives enterBrick(p), leaveBrick(), inCurrentBrick(p), currentBrickValue(p),
// currentBrickPitch(); for strides gBrickStride, gStartLow, gStartHigh; for counting gBrickNumber.

const float kFar = 1e9;
vec3 gBrickLow = vec3(kFar), gBrickHigh = vec3(-kFar); // voxels: between them no other brick has weight
float gBrickScale, gBrickValue;                        // texel = position * scale + offset; or all one value
bool gBrickIsValue = true;
#if FEATURE_VISIBILITY
int gBrickNumber = -1; // of the brick, [z][y][x]
#endif
#if FEATURE_HARDWARE
vec3 gBrickOffset, gFirstTexel, gLastTexel;
#else
ivec3 gBrickFirst, gBrickLast, gBrickOrigin;            // samples
#endif
#if FEATURE_MIXED
OF_VOLUME TEXELS_R32UI uFacts; // one texel per brick: see render/contract/level_map.h
OF_VOLUME int uMostStride; // no stride above 2^this
uniform float uStepVoxels; // length of a segment
vec3 gStartLow = vec3(kFar), gStartHigh = vec3(-kFar); // voxels: where no finer brick limits the stride
int gBrickStride = 0;
float gBrickPitch = 1.0;

// The distance from a face within which other bricks have weight; beyond the volume's border there is nothing.
float faceReach(uint facts, int face) {
    uint code = (facts >> (3 + 3 * face)) & 7u;
    return code == 7u ? -kFar : code == 6u ? 0.0 : halfSample(code);
}
float faceLimit(uint facts, int face, float reach) { return ((facts >> (21 + face)) & 1u) != 0u ? reach : 0.0; }
#endif

void enterBrick(vec3 position) {
#if FEATURE_MIXED
    vec3 p = clamp(position, vec3(0.0), vec3(uExtentVoxels));
    ivec3 brick = min(ivec3(p) >> 5, uBricks - 1);
    uint facts = texelAt(uFacts, brick).x;
    uint code = facts & 7u;
    vec3 low = vec3(faceReach(facts, 0), faceReach(facts, 1), faceReach(facts, 2));
    vec3 high = vec3(faceReach(facts, 3), faceReach(facts, 4), faceReach(facts, 5));
    gBrickStride = min(int(code), uMostStride);
    float reach = max(halfSample(min(code, 5u)), uStepVoxels * float(1 << gBrickStride));
    gStartLow = vec3(brick * 32) + vec3(faceLimit(facts, 0, reach), faceLimit(facts, 1, reach), faceLimit(facts, 2, reach));
    gStartHigh = vec3(brick * 32 + 32) - vec3(faceLimit(facts, 3, reach), faceLimit(facts, 4, reach), faceLimit(facts, 5, reach));
    gBrickPitch = float(1 << (code == kCodeEmpty ? uint(uFinest) : code));
    int level = code < 5u ? int(code) : 0;
    ivec3 extent = levelExtentOf(level);
    gBrickScale = samplesPerVoxel(level);
#else
    vec3 p = clamp(position * uSamplesPerVoxel, vec3(0.0), vec3(uLevelExtent - 1));
    ivec3 brick = ivec3(p) >> uBrickShift;
    ivec3 extent = uLevelExtent;
    int level = 5 - uBrickShift;
    vec3 low = mix(vec3(0.5 * uVoxelsPerSample), vec3(-kFar), equal(brick, ivec3(0)));
    vec3 high = mix(vec3(0.5 * uVoxelsPerSample), vec3(-kFar),
                    greaterThanEqual((brick + 1) << uBrickShift, uLevelExtent));
    gBrickScale = uSamplesPerVoxel;
#endif
    gBrickLow = vec3(brick * 32) + low;
    gBrickHigh = vec3(brick * 32 + 32) - high;
    uvec2 entry = brickEntry(brick);
#if FEATURE_VISIBILITY
    ivec3 bricks = texelsExtent(uIndex);
    gBrickNumber = (brick.z * bricks.y + brick.y) * bricks.x + brick.x;
#endif
    gBrickIsValue = (entry.x & kEntryValue) != 0u;
    gBrickValue = uintBitsToFloat(entry.y);
    ivec3 first = brick << (5 - level);
    ivec3 origin = slotOrigin(entry, 5 - level);
    ivec3 last = min(ivec3(32 >> level), extent - first) - 1;
#if FEATURE_HARDWARE
    gBrickOffset = vec3(origin - first);
    gFirstTexel = vec3(origin) + 0.5;
    gLastTexel = gFirstTexel + vec3(last);
#else
    gBrickFirst = first;
    gBrickLast = last;
    gBrickOrigin = origin;
#endif
}

// Until another brick is entered.
void leaveBrick() {
    gBrickLow = vec3(kFar);
    gBrickHigh = vec3(-kFar);
}

bool inCurrentBrick(vec3 p) { return all(greaterThanEqual(p, gBrickLow)) && all(lessThan(p, gBrickHigh)); }

float currentBrickValue(vec3 p) {
#if FEATURE_HARDWARE
    COUNT_FETCHES(1u);
    vec3 texel = clamp(p * gBrickScale + gBrickOffset, gFirstTexel, gLastTexel);
    float value = storedFromFiltered(textureLod(uVoxels, texel * uTexelSize, 0.0).r);
    return gBrickIsValue ? gBrickValue : value;
#else
    if (gBrickIsValue) return gBrickValue;
    precise vec3 at = p * gBrickScale - vec3(gBrickFirst) - 0.5;
    at = clamp(at, vec3(0.0), vec3(gBrickLast));
    ivec3 low = ivec3(at);
    precise vec3 f = at - vec3(low);
    return trilinearInSlot(gBrickOrigin + low, gBrickOrigin + min(low + 1, gBrickLast), f);
#endif
}

#if FEATURE_MIXED
float currentBrickPitch() { return gBrickPitch; }
#else
float currentBrickPitch() { return uVoxelsPerSample; }
#endif
