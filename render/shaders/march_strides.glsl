// march_strides.glsl: how many segments a ray takes at once; twin of render/strides.h.
// Needs FEATURE_MIXED, common_ray.glsl, sampler_interblock.glsl. Gives strideAt(ray, i), strideStart(ray, i).

#if FEATURE_MIXED
uniform int uMostStride; // no stride above 2^this
uniform int uNaive;      // 1: as the brick at hand, whatever its neighbours

int strideExponent(uvec2 corner, Place place) {
    int k = min(int(codeOf(corner, place.home)), uMostStride); // an empty brick counts as coarser than all
    if (uNaive != 0 || k <= int((corner.y >> 16) & 7u)) return k;
    // Where a finer brick can have weight under any edge function, or where the stride itself can reach it.
    float reach = max(halfSample(min(codeOf(corner, place.home), 5u)), uSegmentVoxels * float(1 << k));
    bvec3 isNear = lessThan(abs(place.offset), vec3(reach));
    int near = int(isNear.x) | int(isNear.y) << 1 | int(isNear.z) << 2;
    gTurns += 7;
    for (int other = 1; other < 8; ++other)
        if ((other & ~near) == 0) k = min(k, int(codeOf(corner, place.home ^ other)));
    return k;
}

int strideAt(Ray ray, int i) {
    if (uMostStride == 0) return 1;
    Place place = placeOf(segmentStart(ray, i));
    int k = strideExponent(cornerTexel(place.corner), place);
    return 1 << (i == 0 ? k : min(k, findLSB(i)));
}

int strideStart(Ray ray, int i) {
    for (int k = uMostStride; k > 0; --k) {
        ++gTurns;
        int start = i & ~((1 << k) - 1);
        if (start + strideAt(ray, start) > i) return start;
    }
    return i;
}
#else
uniform int uStride; // segments, a power of two

int strideAt(Ray ray, int i) { return uStride; }
int strideStart(Ray ray, int i) { return i & ~(uStride - 1); }
#endif
