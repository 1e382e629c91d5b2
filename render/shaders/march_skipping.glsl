// march_skipping.glsl: leaps over strides that are proven empty; twin of render/occupancy.h.
// Needs FEATURE_SKIPPING, common_ray.glsl, march_strides.glsl. Gives beginSkipping(ray), isOccupied(p),
// nextOccupied(ray, i, n, p).

#if FEATURE_SKIPPING
uniform usampler3D uSkipping; // two words a texel: see render/distance_map.h
uniform ivec3 uSkippingLast;  // voxel that no position is beyond
uniform int uSkippingShift;   // log2 of a box's edge, voxels

const float kLeapMargin = 1.0 / 64.0; // voxels: far more than positions are rounded by

vec3 gPerStep;       // 1 / step, 0 where the ray runs along the box
vec3 gLeaveOffset;   // from a box's side to where a leap ends, less the entry
ivec3 gAscends;      // 1 where it does
bool gOctantHigh;    // its byte of an empty box's texel: in which word, and from which bit
int gOctantBit;

void beginSkipping(Ray ray) {
    bvec3 up = greaterThan(ray.step, vec3(0.0));
    bvec3 moves = notEqual(ray.step, vec3(0.0));
    gAscends = ivec3(up);
    gPerStep = mix(vec3(0.0), 1.0 / ray.step, moves);
    gLeaveOffset = mix(vec3(kLeapMargin), vec3(-kLeapMargin), up) - ray.entry;
    gOctantHigh = up.z;
    gOctantBit = 8 * (gAscends.x | gAscends.y << 1);
}

ivec3 voxelAt(vec3 p) { return clamp(ivec3(floor(p)), ivec3(0), uSkippingLast); }
uvec2 skippingTexel(ivec3 voxel) { return texelFetch(uSkipping, voxel >> uSkippingShift, 0).xy; }
bool isOccupiedBox(uvec2 texel) { return (texel.y & 0x80000000u) != 0u; }

// Of an occupied box: whether the voxel's block can show anything.
bool isOccupiedBlock(uvec2 texel, ivec3 voxel) {
    ivec3 block = (voxel >> (uSkippingShift - 2)) & 3;
    int bit = min(block.x | block.y << 2 | block.z << 4, 62);
    return ((bit < 32 ? texel.x : texel.y) >> (bit & 31) & 1u) != 0u;
}

bool isOccupied(vec3 p) {
    ivec3 voxel = voxelAt(p);
    uvec2 texel = skippingTexel(voxel);
    return isOccupiedBox(texel) && isOccupiedBlock(texel, voxel);
}

// Where the ray's next stride starts whose middle may show something: leaps until then, in a loop of its own, because
// a turn of it is cheap beside the caller's. p: the middle of the stride of n segments from i. Takes what it
// leaps from left. Leaps that were cut short end where a stride starts.
int nextOccupied(Ray ray, int i, int n, vec3 p, inout int left, inout uint iterations) {
    while (true) {
        ivec3 voxel = voxelAt(p);
        uvec2 texel = skippingTexel(voxel);
        int shift = uSkippingShift;
        int reach = int((gOctantHigh ? texel.y : texel.x) >> gOctantBit & 127u);
        if (isOccupiedBox(texel)) {
            if (isOccupiedBlock(texel, voxel)) return i;
            shift -= 2;
            reach = 1;
        }
        ivec3 side = ((voxel >> shift) + mix(ivec3(1 - reach), ivec3(reach), equal(gAscends, ivec3(1)))) << shift;
        vec3 leave = (vec3(side) + gLeaveOffset) * gPerStep; // in segments from the entry
        leave = mix(leave, vec3(kMaxFloat), equal(gPerStep, vec3(0.0)));
        float beyond = ceil(min(min(leave.x, leave.y), leave.z) - 0.5);
        if (!(beyond < float(ray.count))) return ray.count;
        i = max(i + n, strideStart(ray, max(int(beyond), 0)));
        if (left <= 0 || gTurns >= kMostTurns || i >= ray.count) return i;
        --left;
        ++gTurns;
        ++iterations;
        n = strideAt(ray, i);
        p = stridePosition(ray, i, strideLength(ray, i, n));
    }
}
#else
void beginSkipping(Ray ray) {}
bool isOccupied(vec3 p) { return true; }
int nextOccupied(Ray ray, int i, int n, vec3 p, inout int left, inout uint iterations) { return i; }
#endif
