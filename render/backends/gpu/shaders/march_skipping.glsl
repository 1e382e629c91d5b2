// march_skipping.glsl: leaps over strides that are proven empty: the same as render/empty_space/occupancy.h, for
// shaders. For rays that keep one value, leaps over those that cannot change it: the same as
// render/empty_space/value_bounds.h.
// Needs FEATURE_SKIPPING, FEATURE_ENDS, common_ray.glsl, march_strides.glsl. Gives beginSkipping(ray), isOccupied(p),
// and nextOccupied(ray, i, n, p, left, iterations). For segments that are given by their ends it gives nextShown(ray,
// i, left, iterations). For those that may hold isosurfaces it gives nextNotClear(ray, i, left, iterations),
// mayHoldSurface(a, b); with FEATURE_VALUES nextContributing(ray, i, n, p, kept).

#if FEATURE_VALUES
const int kGreatest = 1; // Reduction of core/scene/mode.h
const int kLeast = 2;
const int kMean = 3;
uniform int uReduction;
#endif

#if FEATURE_SKIPPING
#if FEATURE_VALUES
uniform TEXELS_R32F uBrickBounds; // places of the table that no value lies beyond
uniform TEXELS_R32F uCellBounds;
uniform int uBoundsOfCells; // 0: there are none
#else
OF_VOLUME TEXELS_RG32UI uSkipping; // two words a texel: see render/empty_space/distance_map.h
OF_VOLUME int uSkippingShift;   // log2 of a box's edge, voxels
#endif
OF_VOLUME ivec3 uSkippingLast; // voxel that no position is beyond

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

// The ray's exit from a box, less a margin, in segments from its entry: the smallest box and how many of them it is.
float leaves(vec3 box, vec3 edge, int reach) {
    vec3 side = (box + mix(vec3(1 - reach), vec3(reach), equal(gAscends, ivec3(1)))) * edge;
    vec3 leave = (side + gLeaveOffset) * gPerStep;
    leave = mix(leave, vec3(kMaxFloat), equal(gPerStep, vec3(0.0)));
    return min(min(leave.x, leave.y), leave.z);
}

#if FEATURE_VALUES
bool tells(float bound, float kept) { return uReduction == kLeast ? bound < kept : bound > kept; }
// i itself if the stride of n segments from i, whose middle is p, can change the ray's result. Otherwise the start of
// the first stride whose middle may lie beyond the box that cannot.
int nextContributing(Ray ray, int i, int n, vec3 p, float kept) {
    ivec3 voxel = voxelAt(p);
    int shift = 5;
    if (tells(texelAt(uBrickBounds, voxel >> 5).x, kept)) {
        shift = 3;
        if (uBoundsOfCells == 0 || tells(texelAt(uCellBounds, voxel >> 3).x, kept)) return i;
    }
    float beyond = ceil(leaves(vec3(voxel >> shift), vec3(1 << shift), 1) - 0.5);
    if (!(beyond < float(ray.count))) return ray.count;
    return max(i + n, strideStart(ray, max(int(beyond), 0)));
}
#else
uvec2 skippingTexel(ivec3 voxel) { return texelAt(uSkipping, voxel >> uSkippingShift).xy; }
bool isOccupiedBox(uvec2 texel) { return (texel.y & 0x80000000u) != 0u; }

int blockBit(ivec3 voxel) {
    ivec3 block = (voxel >> (uSkippingShift - 2)) & 3;
    return min(block.x | block.y << 2 | block.z << 4, 62);
}
// Of an occupied box: whether the block can show anything.
bool isOccupiedBlock(uvec2 texel, int bit) { return ((bit < 32 ? texel.x : texel.y) >> (bit & 31) & 1u) != 0u; }

bool isOccupied(vec3 p) {
    ivec3 voxel = voxelAt(p);
    uvec2 texel = skippingTexel(voxel);
    return isOccupiedBox(texel) && isOccupiedBlock(texel, blockBit(voxel));
}

// The empty box around p, as far as a ray may leap. Gives number and edge of the smallest box there, and how many of
// them along each axis the ray goes on in. False if something can show.
bool emptyBoxAt(vec3 p, out vec3 box, out vec3 edge, out int reach) {
    ivec3 voxel = voxelAt(p);
    uvec2 texel = skippingTexel(voxel);
    box = vec3(voxel >> uSkippingShift);
    edge = vec3(1 << uSkippingShift);
    reach = int((gOctantHigh ? texel.y : texel.x) >> gOctantBit & 127u);
    if (isOccupiedBox(texel)) {
        box = vec3(voxel >> (uSkippingShift - 2));
        edge *= 0.25;
        reach = 1;
        if (isOccupiedBlock(texel, blockBit(voxel))) return false;
    }
    return true;
}

#if !FEATURE_ENDS
// The start of the ray's next stride whose middle may show something. Leaps until then, in a loop of its own, because
// a turn of it is cheap beside the caller's. p: the middle of the stride of n segments from i. Takes its leaps from
// left. Leaps that were cut short end at the start of a stride.
int nextOccupied(Ray ray, int i, int n, vec3 p, inout int left, inout uint iterations) {
    vec3 box;
    vec3 edge;
    int reach;
    while (emptyBoxAt(p, box, edge, reach)) {
        float beyond = ceil(leaves(box, edge, reach) - 0.5);
        if (!(beyond < float(ray.count))) return ray.count;
        i = max(i + n, strideStart(ray, max(int(beyond), 0)));
        if (left <= 0 || !TURNS_LEFT || i >= ray.count) return i;
        --left;
        TURN;
        ++iterations;
        n = strideAt(ray, i);
        p = stridePosition(ray, i, strideLength(ray, i, n));
    }
    return i;
}
#else
// The same for segments that are given by the field at their ends: as nextShown() in render/empty_space/occupancy.h.
int nextShown(Ray ray, int i, inout int left, inout uint iterations) {
    vec3 box;
    vec3 edge;
    int reach;
    bool isEmpty = emptyBoxAt(segmentStart(ray, i), box, edge, reach);
    while (isEmpty) {
        float beyond = floor(leaves(box, edge, reach));
        if (!(beyond < float(ray.count))) return ray.count;
        i = max(i, strideStart(ray, max(int(beyond), 0)));
        int n = strideAt(ray, i);
        // Empty boxes that touch share a value, so that nothing between the values in both shows.
        vec3 low = (box + vec3(gAscends - 1) * float(reach - 1)) * edge;
        vec3 high = (box + 1.0 + vec3(gAscends) * float(reach - 1)) * edge;
        isEmpty = emptyBoxAt(strideEnd(ray, i, strideLength(ray, i, n)), box, edge, reach);
        bool touches = all(lessThanEqual(box * edge, high)) && all(lessThanEqual(low, (box + 1.0) * edge));
        if (!isEmpty || !touches) return i;
        i += n;
        if (left <= 0 || !TURNS_LEFT || i >= ray.count) return i;
        --left;
        TURN;
        ++iterations;
    }
    return i;
}
#endif

#if FEATURE_SURFACES
uniform TEXELS_RG32UI uSurfaceMap; // of the surfaces alone; in shape as uSkipping

// True if everything between two places is proven empty: the same as isClear() in render/empty_space/occupancy.h.
bool isClear(UINT_TEXELS map, vec3 a, vec3 b) {
    ivec3 from = voxelAt(a);
    ivec3 to = voxelAt(b);
    int shift = uSkippingShift - 2;
    ivec3 first = min(from, to) >> shift;
    ivec3 span = (max(from, to) >> shift) - first;
    if (max(span.x, max(span.y, span.z)) > 1) return false;
    int mask = span.x | span.y << 1 | span.z << 2;
    int corner = 0;
    bool clear = true;
    do {
        TURN;
        ivec3 block = first + (ivec3(corner, corner >> 1, corner >> 2) & 1);
        uvec2 texel = texelAt(map, block >> 2).xy;
        clear = clear && !(isOccupiedBox(texel) && isOccupiedBlock(texel, blockBit(block << shift)));
        corner = (corner - mask) & mask;
    } while (corner != 0 && clear);
    return clear;
}
bool mayHoldSurface(vec3 a, vec3 b) { return !isClear(uSurfaceMap, a, b); }

// For rays that look for surfaces, which can lie anywhere in a stride: the same as nextNotClear() in
// render/empty_space/occupancy.h.
int nextNotClear(Ray ray, int i, inout int left, inout uint iterations) {
    vec3 box;
    vec3 edge;
    int reach;
    while (emptyBoxAt(segmentStart(ray, i), box, edge, reach)) {
        float beyond = floor(leaves(box, edge, reach));
        if (!(beyond < float(ray.count))) return ray.count;
        i = max(i, strideStart(ray, max(int(beyond), 0)));
        int n = strideAt(ray, i);
        if (!isClear(uSkipping, segmentStart(ray, i), strideEnd(ray, i, strideLength(ray, i, n)))) return i;
        i += n;
        if (left <= 0 || !TURNS_LEFT || i >= ray.count) return i;
        --left;
        TURN;
        ++iterations;
    }
    return i;
}
#endif
#endif
#else
void beginSkipping(Ray ray) {}
#if FEATURE_VALUES
int nextContributing(Ray ray, int i, int n, vec3 p, float kept) { return i; }
#endif
bool isOccupied(vec3 p) { return true; }
int nextOccupied(Ray ray, int i, int n, vec3 p, inout int left, inout uint iterations) { return i; }
int nextShown(Ray ray, int i, inout int left, inout uint iterations) { return i; }
int nextNotClear(Ray ray, int i, inout int left, inout uint iterations) { return i; }
bool mayHoldSurface(vec3 a, vec3 b) { return true; }
#endif
