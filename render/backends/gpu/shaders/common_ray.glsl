// common_ray.glsl: one pixel's ray and its segments in voxel space; in float as render/contract/ray.h has them.
// Needs FEATURE_PLACES, FEATURE_SLABS. Gives raySlot(at), rayPlace(at), rayPhase(at), Ray makeRay(place, phase), strideLength, stridePosition, strideEnd,
// segmentStart.

#include "common_leaves.glsl"
#include "leaf_ray.h"

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

float rayPhase(ivec2 at) { return uPhased == 0 ? 0.0 : phaseOf(at.x, at.y); }

const float kMaxFloat = 3.402823466e38;

struct Ray {
    vec3 entry, step; // voxels
    vec3 direction;   // unit, voxel space
    float segmentMm, tail;
    int count; // 0: misses the volume
};

// A ray through a place in pixels.
Ray makeRay(vec2 pixel, float phase) {
    precise Ray ray;
    ray.count = 0;
    ray.entry = vec3(0.0);
    ray.step = vec3(0.0);
    ray.segmentMm = 0.0;
    ray.tail = 1.0;
    precise vec3 base;
    precise float distance;
    lineThrough(pixel.x, pixel.y, uImageSize.x, uImageSize.y, uCentre, uRight, uUp, uToCentre, uPerspective != 0, base,
                ray.direction, distance);
    float mmPerVoxel = length3(transformed(uPatientFromVoxel, ray.direction));
    precise float t0 = uPerspective != 0 ? -distance : -kMaxFloat;
    precise float t1 = kMaxFloat;
    for (int axis = 0; axis < 3; ++axis)
        if (clip(base[axis], ray.direction[axis], 0.0, uExtent[axis], t0, t1)) return ray;
#if FEATURE_SLABS
    if (!(t1 > t0)) return ray;
    for (int n = 0; n < uSlabs; ++n) {
        float o = dot3(uSlabNormal[n], base);
        float d = dot3(uSlabNormal[n], ray.direction);
        if (clip(o, d, uSlabEnds[n].x, uSlabEnds[n].y, t0, t1) || t1 < t0) return ray;
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
    ray.entry = placeAlong(base, ray.direction, first);
    ray.step = uSegmentVoxels * ray.direction;
    ray.segmentMm = uSegmentVoxels * mmPerVoxel;
    return ray;
}

#if FEATURE_INTERVALS
uniform int uHullSamples; // segments of an interval; 0: as many as the ray's own need
// An interval of a ray as a ray of its own; as partOf() in render/contract/ray_cuts.h.
Ray partOf(Ray ray, vec2 interval) {
    precise Ray part = ray;
    if (ray.count == 0) return part;
    if (interval.y < interval.x) {
        part.count = 0;
        return part;
    }
    precise float segments = (interval.y - interval.x) / uSegmentVoxels;
    part.entry = placeAlong(ray.entry, ray.direction, interval.x);
    if (uHullSamples > 0) {
        precise float longer = segments / float(uHullSamples);
        part.step = longer * ray.step;
        part.segmentMm = longer * ray.segmentMm;
        part.count = uHullSamples;
        part.tail = 1.0;
        return part;
    }
    part.count = max(int(ceil(segments)), 1);
    part.tail = segments - float(part.count - 1);
    return part;
}
#endif

// Segments in the stride of n that starts at segment i: n, or the remainder before the exit.
float strideLength(Ray ray, int i, int n) {
    precise float length = i + n >= ray.count ? float(ray.count - 1 - i) + ray.tail : float(n);
    return length;
}

vec3 stridePosition(Ray ray, int i, float length) {
    return placeAlong(ray.entry, ray.step, strideMiddle(float(i), length));
}

vec3 strideEnd(Ray ray, int i, float length) {
    precise float segments = float(i) + length;
    return placeAlong(ray.entry, ray.step, segments);
}

vec3 segmentStart(Ray ray, int i) {
    return placeAlong(ray.entry, ray.step, float(i));
}
