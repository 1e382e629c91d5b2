// march_strides.glsl: the number of segments that a ray takes at once: the same as render/contract/strides.h, for
// shaders.
// Needs FEATURE_MIXED, FEATURE_FUSED, common_ray.glsl, sampler_field.glsl. Gives strideAt(ray, i), strideStart(ray, i), and for the
// brick at hand startsInCurrentBrick(ray, i), currentBrickStride(i).

#if FEATURE_MIXED && !FEATURE_FUSED
uniform int uNaive; // 1: as the brick at hand, whatever its neighbours

int strideExponent(uvec2 corner, Place place) {
    int k = min(int(codeOf(corner, place.current)), uMostStride); // an empty brick counts as coarser than all
    if (uNaive != 0 || k <= int((corner.y >> 16) & 7u)) return k;
    // True where a finer brick can have weight under any edge function, or where the stride itself can reach it.
    float reach = max(halfSample(min(codeOf(corner, place.current), 5u)), uSegmentVoxels * float(1 << k));
    bvec3 isNear = lessThan(abs(place.offset), vec3(reach));
    int near = int(isNear.x) | int(isNear.y) << 1 | int(isNear.z) << 2;
    TURNS(7);
    for (int other = 1; other < 8; ++other)
        if ((other & ~near) == 0) k = min(k, int(codeOf(corner, place.current ^ other)));
    return k;
}

int alignment(int i) { return i == 0 ? 31 : findLSB(i); }

int strideAt(Ray ray, int i) {
    Place place = placeOf(segmentStart(ray, i));
    return 1 << min(strideExponent(cornerTexel(place.corner), place), alignment(i));
}

int strideStart(Ray ray, int i) {
    Place place = placeOf(segmentStart(ray, i));
    // A stride never reaches into a brick that is finer than itself, unless it reads no neighbours.
    int k = uNaive != 0 ? uMostStride : min(uMostStride, int(codeOf(cornerTexel(place.corner), place.current)));
    for (; k > 0; --k) {
        TURN;
        int start = i & ~((1 << k) - 1);
        if (start + strideAt(ray, start) > i) return start;
    }
    return i;
}

int currentBrickStride(int i) { return 1 << min(gBrickStride, alignment(i)); }
bool startsInCurrentBrick(Ray ray, int i) {
    vec3 start = segmentStart(ray, i);
    return all(greaterThanEqual(start, gStartLow)) && all(lessThan(start, gStartHigh));
}
#else
uniform int uStride; // segments, a power of two

int strideAt(Ray ray, int i) { return uStride; }
int strideStart(Ray ray, int i) { return i & ~(uStride - 1); }
int currentBrickStride(int i) { return uStride; }
bool startsInCurrentBrick(Ray ray, int i) { return true; }
#endif
