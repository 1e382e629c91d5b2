// march_surface.glsl: the places where a ray meets isosurfaces (docs/sampling.md, "Isosurfaces"). The parts of a
// cell's cubic and the places of its crossings are as in render/contract/cell_roots.h. Planes of samples are as in
// render/backends/mirror/mirror_surfaces.h.
// Needs common_ray.glsl, sampler_current_brick.glsl. Gives Parts, monotoneParts, bracketedRoot, nextPlane(start,
// step, w, pitch), valueAt(p), unitNormal(gradient, direction), and the uniforms.

#include "leaf_surface.h"

const int kMostSurfaces = 8;
uniform int uSurfaces;
uniform float uIsovalues[kMostSurfaces]; // stored units, ascending
uniform vec3 uSurfaceColours[kMostSurfaces];
uniform float uSurfaceOpacities[kMostSurfaces];

uniform int uVolumeShows; // 0: the transfer function shows nothing

// From the brick at hand where no other has weight.
float valueAt(vec3 p) {
    float value = currentBrickValue(p);
    ONCE (!inCurrentBrick(p)) value = fieldValue(p);
    return value;
}

#if FEATURE_HITS
vec3 unitNormal(vec3 gradient, vec3 direction) {
    vec3 g = transformed(uVoxelFromPatientTransposed, gradient);
    float length = length3(g);
    return facingNormal(g, transformed(uPatientFromVoxel, direction), length, length > 0.0);
}
#endif

// True if the cubic can take the value of a surface in [0,1], its value at 1 given.
bool mayCross(CellCubic f, float v1) {
    CellRange range = cellRange(f, v1, kMaxFloat);
    bool may = false;
    for (int surface = 0; surface < uSurfaces; ++surface) {
        TURN;
        may = may || mayHold(range, uIsovalues[surface]);
    }
    return may;
}

// The monotone parts of a cubic: from 0 to x, to y, to 1; count of these parts.
struct Parts {
    int count;
    float x, y;
};

Parts monotoneParts(CellCubic f) {
    CellTurns turns = cellTurns(f);
    return Parts(1 + int(turns.first < 1.0) + int(turns.second < 1.0), turns.first, turns.second);
}

const int kRootTurns = 23;
const float kRootTolerance = 1.0 / 4194304.0;

// Of f - isovalue in [a,b], on whose ends it takes fa and fb, of unlike sides.
float bracketedRoot(CellCubic f, float isovalue, float a, float b, float fa, float fb) {
    if (fa == 0.0) return a;
    if (fb == 0.0) return b;
    precise float pull = 0.2 / (b - a);
    float reach = 1.0;
    for (int turn = 0; turn < kRootTurns; ++turn) {
        TURN;
        precise float width = b - a;
        if (!(width > 2.0 * kRootTolerance)) break;
        float u = rootGuess(a, b, fa, fb, pull, reach);
        precise float fu = cubicAt(f, u) - isovalue;
        if (fu == 0.0) return u;
        if ((fu < 0.0) == (fa < 0.0)) {
            a = u;
            fa = fu;
        } else {
            b = u;
            fb = fu;
        }
        reach = 0.5 * reach;
    }
    precise float root = a + 0.5 * (b - a);
    return root;
}

// The first plane of sample centres of this pitch on the ray beyond w, in segments from start.
float nextPlane(vec3 start, vec3 step, float w, float pitch) {
    float next = kMaxFloat;
    precise float least = w + kPlaneMargin / uSegmentVoxels;
    TURNS(3);
    for (int axis = 0; axis < 3; ++axis)
        if (step[axis] != 0.0) next = min(next, planeBehind(start[axis], step[axis], w, pitch, least));
    return next;
}
