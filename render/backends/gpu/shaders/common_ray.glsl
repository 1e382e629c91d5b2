// common_ray.glsl: one pixel's ray and its segments in voxel space; twin of render/contract/ray.h, operation by operation.
// Needs FEATURE_PLACES, FEATURE_SLABS. Gives raySlot(at), rayPlace(at), rayPhase(at), Ray makeRay(place, phase), strideLength, stridePosition, strideEnd,
// segmentStart.

uniform vec3 uCentre, uRight, uUp, uToCentre; // voxels
uniform mat3 uPatientFromVoxel;               // linear part, mm per voxel
uniform vec3 uExtent;                         // voxels
uniform vec2 uImageSize;                      // pixels
uniform ivec2 uArraySize;                     // of the rays: the picture's, unless FEATURE_PLACES
uniform float uSegmentVoxels;
uniform int uPhased;
uniform int uPerspective;

#if FEATURE_SLABS
const int kMostSlabs = 8;
uniform int uSlabs;
uniform vec3 uSlabNormal[kMostSlabs]; // voxel space
uniform vec2 uSlabEnds[kMostSlabs];   // low, high
uniform int uFlat;                    // 1: one of them is a plane, at which a ray has one sample
#endif
#if FEATURE_INTERVALS
// Of every ray the interval at hand, in voxels from where its drawn part begins; none where it ends before it begins.
layout(std430, binding = BINDING_INTERVALS) readonly buffer Intervals { vec2 uIntervals[]; };
#endif
#if FEATURE_PLACES
layout(std430, binding = BINDING_PLACES) readonly buffer Places { vec2 uPlaces[]; }; // pixels
#endif

// Of the array's ray at column x, row y: its number, and where it goes through the picture.
int raySlot(ivec2 at) { return at.y * uArraySize.x + at.x; }
vec2 rayPlace(ivec2 at) {
#if FEATURE_PLACES
    return uPlaces[raySlot(at)];
#else
    return vec2(at) + 0.5;
#endif
}

// Twin of phaseOf() in render/contract/ray.h.
float rayPhase(ivec2 at) {
    int k = (at.x & 1) + 2 * (at.y & 1) + 4 * (at.x >> 1 & 1);
    return uPhased == 0 ? 0.0 : float(2 * (k & 3) + (k >> 2)) / 8.0 - 0.4375;
}

const float kMaxFloat = 3.402823466e38;

struct Ray {
    vec3 entry, step; // voxels
    vec3 direction;   // unit, voxel space
    float segmentMm, tail;
    int count; // 0: misses the volume
};

float length3(vec3 v) {
    precise float squared = v.x * v.x + v.y * v.y + v.z * v.z;
    return sqrt(squared);
}

// A ray through a place in pixels.
Ray makeRay(vec2 pixel, float phase) {
    precise Ray ray;
    ray.count = 0;
    ray.entry = vec3(0.0);
    ray.step = vec3(0.0);
    ray.segmentMm = 0.0;
    ray.tail = 1.0;
    precise float x = 2.0 * pixel.x / uImageSize.x - 1.0;
    precise float y = 1.0 - 2.0 * pixel.y / uImageSize.y;
    precise vec3 offset = x * uRight + y * uUp;
    precise vec3 along = uPerspective != 0 ? uToCentre + offset : uToCentre;
    precise float distance = length3(along);
    precise vec3 base = uCentre + offset;
    ray.direction = along / distance;
    precise vec3 mm = uPatientFromVoxel[0] * ray.direction.x + uPatientFromVoxel[1] * ray.direction.y +
                      uPatientFromVoxel[2] * ray.direction.z;
    precise float mmPerVoxel = length3(mm);
    precise float t0 = uPerspective != 0 ? -distance : -kMaxFloat;
    precise float t1 = kMaxFloat;
    for (int axis = 0; axis < 3; ++axis) {
        precise float o = base[axis];
        precise float d = ray.direction[axis];
        if (d == 0.0) {
            if (o < 0.0 || o > uExtent[axis]) return ray;
            continue;
        }
        precise float a = (0.0 - o) / d;
        precise float b = (uExtent[axis] - o) / d;
        t0 = max(t0, min(a, b));
        t1 = min(t1, max(a, b));
    }
#if FEATURE_SLABS
    if (!(t1 > t0)) return ray;
    for (int n = 0; n < uSlabs; ++n) {
        vec3 normal = uSlabNormal[n];
        float low = uSlabEnds[n].x;
        float high = uSlabEnds[n].y;
        precise float o = normal.x * base.x + normal.y * base.y + normal.z * base.z;
        precise float d = normal.x * ray.direction.x + normal.y * ray.direction.y + normal.z * ray.direction.z;
        if (d == 0.0) {
            if (o < low || o > high || !(low < high)) return ray;
            continue;
        }
        precise float a = (low - o) / d;
        precise float b = (high - o) / d;
        t0 = max(t0, min(a, b));
        t1 = min(t1, max(a, b));
        if (t1 < t0) return ray;
    }
    if (!(t1 > t0) && !(uFlat != 0 && t1 == t0)) return ray;
#else
    if (!(t1 > t0)) return ray;
#endif
    precise float first = t0 + phase * uSegmentVoxels;
    precise float segments = (t1 - first) / uSegmentVoxels;
    if (!(segments < 16777216.0)) return ray; // NaN, or more than float can count: draws nothing
#if FEATURE_SLABS
    ray.count = uFlat != 0 ? 1 : int(ceil(segments));
#else
    ray.count = int(ceil(segments));
#endif
    ray.tail = segments - float(ray.count - 1);
    ray.entry = base + first * ray.direction;
    ray.step = uSegmentVoxels * ray.direction;
    ray.segmentMm = uSegmentVoxels * mmPerVoxel;
    return ray;
}

#if FEATURE_INTERVALS
// An interval of a ray as a ray of its own; twin of partOf() in render/contract/ray_cuts.h.
Ray partOf(Ray ray, vec2 interval) {
    precise Ray part = ray;
    if (ray.count == 0) return part;
    if (interval.y < interval.x) {
        part.count = 0;
        return part;
    }
    precise float segments = (interval.y - interval.x) / uSegmentVoxels;
    part.entry = ray.entry + interval.x * ray.direction;
    part.count = max(int(ceil(segments)), 1);
    part.tail = segments - float(part.count - 1);
    return part;
}
#endif

// Segments in the stride of n that starts at segment i: n, or what is left before the exit.
float strideLength(Ray ray, int i, int n) {
    precise float length = i + n >= ray.count ? float(ray.count - 1 - i) + ray.tail : float(n);
    return length;
}

vec3 stridePosition(Ray ray, int i, float length) {
    precise vec3 at = ray.entry + (float(i) + 0.5 * length) * ray.step;
    return at;
}

vec3 strideEnd(Ray ray, int i, float length) {
    precise vec3 at = ray.entry + (float(i) + length) * ray.step;
    return at;
}

vec3 segmentStart(Ray ray, int i) {
    precise vec3 at = ray.entry + float(i) * ray.step;
    return at;
}
