// march_skipping.glsl: leaps over strides that are proven empty; twin of render/occupancy.h.
// Needs FEATURE_SKIPPING, common_ray.glsl, sampler_atlas.glsl, march_strides.glsl. Gives isOccupied(p),
// nextOccupied(ray, i, n, p).

#if FEATURE_SKIPPING
uniform usampler3D uDistance; // per cell of 8^3 voxels: 0 occupied, else Chebyshev distance to the nearest such
uniform ivec3 uCells;

// i where the cell at p (middle of the stride of n segments from i) is occupied; else where the first stride
// starts whose middle may lie beyond the box of cells that is empty. Every cell's proof reaches half a voxel
// further than the cell, far more than a rounded position can stray.
int nextOccupied(Ray ray, int i, int n, vec3 p) {
    ivec3 cell = clamp(ivec3(floor(p)) >> 3, ivec3(0), uCells - 1);
    int reach = int(texelFetch(uDistance, cell, 0).r);
    if (reach == 0) return i;
    vec3 low = vec3((cell - (reach - 1)) * 8);
    vec3 high = vec3((cell + reach) * 8);
    float leave = kMaxFloat; // in segments from the entry
    gTurns += 3;
    for (int axis = 0; axis < 3; ++axis) {
        float d = ray.step[axis];
        if (d > 0.0) leave = min(leave, (high[axis] - ray.entry[axis]) / d);
        if (d < 0.0) leave = min(leave, (low[axis] - ray.entry[axis]) / d);
    }
    int beyond = int(min(ceil(leave - 0.5), float(ray.count)));
    if (beyond >= ray.count) return ray.count;
    return max(i + n, strideStart(ray, beyond));
}

bool isOccupied(vec3 p) {
    ivec3 cell = clamp(ivec3(floor(p)) >> 3, ivec3(0), uCells - 1);
    return texelFetch(uDistance, cell, 0).r == 0u;
}
#else
bool isOccupied(vec3 p) { return true; }
int nextOccupied(Ray ray, int i, int n, vec3 p) { return i; }
#endif
