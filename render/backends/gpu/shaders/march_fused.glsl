// march_fused.glsl: a ray of a lattice in one of several volumes (docs/sampling.md, "Several volumes").
// Needs FEATURE_FUSED, FEATURE_OWN_CUTS, FEATURE_SKIPPING, common_ray.glsl, march_skipping.glsl. Gives inVolume(ray), looksInto(inside, at,
// next), uVolumes, uFusion, uUnitMm.

#include "leaf_fusion.h"

uniform int uVolumes;                 // VOLUMES, which compilers would unroll loops by
uniform int uFusion;                  // kFusion...
OF_VOLUME mat3 uFromLattice;          // linear part: the volume's voxels from those of the lattice
OF_VOLUME vec3 uLatticeOffset;        // and the place of the lattice's origin
OF_VOLUME vec3 uVolumeExtent;         // voxels
OF_VOLUME float uUnitMm;              // unit distance of its function

#if FEATURE_OWN_CUTS
// Of all volumes: slabs of bodies that cut a volume alone, as CutSlab of render/contract/scene_numbers.h.
uniform vec3 uCutNormals[MOST_CUT_SLABS];
uniform vec2 uCutEnds[MOST_CUT_SLABS]; // low, high
uniform int uCutBodies[MOST_CUT_SLABS]; // 1: the last of a body; 2: whose outside is kept
OF_VOLUME int uFirstCut;
OF_VOLUME int uCutCount;

// As isKept() of render/contract/leaves.h.
bool isKept(vec3 p) {
    bool kept = true;
    bool inside = true;
    TURNS(uCutCount);
    for (int n = uFirstCut; n < uFirstCut + uCutCount; ++n) {
        precise float along = uCutNormals[n].x * p.x + uCutNormals[n].y * p.y + uCutNormals[n].z * p.z;
        inside = inside && uCutEnds[n].x <= along && along <= uCutEnds[n].y;
        if ((uCutBodies[n] & 1) != 0) {
            kept = kept && ((uCutBodies[n] & 2) != 0 ? !inside : inside);
            inside = true;
        }
    }
    return kept;
}
#endif

// The same ray in the voxels of the volume at hand; its direction is no unit vector there.
Ray inVolume(Ray ray) {
    precise Ray inside = ray;
    inside.entry = transformed(uFromLattice, ray.entry) + uLatticeOffset;
    inside.step = transformed(uFromLattice, ray.step);
    inside.direction = transformed(uFromLattice, ray.direction);
    return inside;
}

// True if the volume at hand may show something at a place of the ray, in segments from its entry. Else next is the
// segment from which on it could.
bool looksInto(Ray inside, float at, out float next) {
    const float kAround = 2.0; // segments around the box's border, in which rounding decides: they are looked at one by one
    vec3 p = placeAlong(inside.entry, inside.step, at);
    next = 0.0;
    if (all(greaterThanEqual(p, vec3(0.0))) && all(lessThan(p, uVolumeExtent))) {
#if FEATURE_OWN_CUTS
        if (!isKept(p)) return false;
#endif
#if FEATURE_SKIPPING
        vec3 box;
        vec3 edge;
        int reach;
        beginSkipping(inside);
        bool isEmpty = emptyBoxAt(p, box, edge, reach);
        if (isEmpty) next = ceil(leaves(box, edge, reach) - 0.5);
        return !isEmpty;
#else
        return true;
#endif
    }
    precise float enters = -kMaxFloat;
    precise float goes = kMaxFloat;
    bool misses = false;
    for (int axis = 0; axis < 3; ++axis)
        misses = clip(inside.entry[axis], inside.step[axis], 0.0, uVolumeExtent[axis], enters, goes) || misses;
    TURNS(3);
    if (misses || enters > goes || at > goes + kAround) next = kMaxFloat;
    else if (at < enters - kAround) next = floor(enters - kAround);
    return false;
}
