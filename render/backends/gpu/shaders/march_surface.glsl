// march_surface.glsl: where a ray meets isosurfaces (docs/sampling.md, "Isosurfaces"): the cubic of a cell, where it
// turns, the places of its crossings; twin of render/contract/cell_roots.h and of nextPlane() in render/backends/mirror/mirror_surfaces.h.
// Needs common_ray.glsl, sampler_current_brick.glsl. Gives Cubic, cubicThrough, cubicAt, Parts, monotoneParts,
// bracketedRoot, nextPlane(start, step, w, pitch), valueAt(p), unitNormal(gradient, direction), and the uniforms.

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
    precise vec3 g = uVoxelFromPatientTransposed[0] * gradient.x + uVoxelFromPatientTransposed[1] * gradient.y +
                     uVoxelFromPatientTransposed[2] * gradient.z;
    precise vec3 d = uPatientFromVoxel[0] * direction.x + uPatientFromVoxel[1] * direction.y +
                     uPatientFromVoxel[2] * direction.z;
    float length = length3(g);
    if (!(length > 0.0)) return vec3(0.0);
    precise float facing = g.x * d.x + g.y * d.y + g.z * d.z;
    precise vec3 normal = g * ((facing > 0.0 ? -1.0 : 1.0) / length);
    return normal;
}
#endif

struct Cubic { float c0, c1, c2, c3; };

float cubicAt(Cubic f, float u) {
    precise float v = f.c0 + u * (f.c1 + u * (f.c2 + u * f.c3));
    return v;
}

// Through its values at 0, 1/3, 2/3, 1.
Cubic cubicThrough(float v0, float v1, float v2, float v3) {
    precise float d1 = v1 - v0;
    precise float d2 = v2 - v1;
    precise float d3 = v3 - v2;
    precise float e1 = d2 - d1;
    precise float e2 = d3 - d2;
    precise float f = e2 - e1;
    precise float c1 = 3.0 * (d1 - 0.5 * e1 + f * (1.0 / 3.0));
    precise float c2 = 4.5 * (e1 - f);
    precise float c3 = 4.5 * f;
    return Cubic(v0, c1, c2, c3);
}

// Whether it can take the value of a surface in [0,1], its value at 1 given: not where all of its Bernstein coefficients are
// on one side, by more than rounding makes of them. A test that spares the search; what is found does not depend on it.
bool mayCross(Cubic f, float v1) {
    const float kSlack = 1.0 / 65536.0;
    float first = f.c0 + f.c1 * (1.0 / 3.0);
    float second = f.c0 + (2.0 * f.c1 + f.c2) * (1.0 / 3.0);
    float low = min(min(f.c0, first), min(second, v1));
    float high = max(max(f.c0, first), max(second, v1));
    float slack = kSlack * max(abs(low), abs(high));
    bool may = !(low <= high); // no numbers
    for (int surface = 0; surface < uSurfaces; ++surface) {
        TURN;
        float isovalue = uIsovalues[surface];
        may = may || (low - slack <= isovalue && isovalue <= high + slack);
    }
    return may;
}

// Where a cubic is monotone: from 0 to x, to y, to 1; count of these parts.
struct Parts {
    int count;
    float x, y;
};

Parts monotoneParts(Cubic f) {
    Parts parts = Parts(1, 1.0, 1.0);
    float most = max(max(abs(f.c1), abs(f.c2)), abs(f.c3));
    if (!(most > 0.0)) return parts; // constant
    precise float a = 3.0 * (f.c3 / most); // a u^2 + 2 b u + c, scaled so that no product overflows
    precise float b = f.c2 / most;
    precise float c = f.c1 / most;
    precise float square = b * b - a * c;
    if (!(square > 0.0)) return parts;
    float root = sqrt(square);
    precise float q = b < 0.0 ? root - b : -root - b;
    precise float r1 = a == 0.0 ? 2.0 : q / a;
    precise float r2 = c / q;
    float low = min(r1, r2);
    float high = max(r1, r2);
    bool lowCounts = low > 0.0 && low < 1.0;
    bool highCounts = high > 0.0 && high < 1.0 && high > low;
    parts.x = lowCounts ? low : highCounts ? high : 1.0;
    parts.y = lowCounts && highCounts ? high : 1.0;
    parts.count = 1 + int(lowCounts) + int(highCounts);
    return parts;
}

const int kRootTurns = 23;
const float kRootTolerance = 1.0 / 4194304.0;

// Of f - isovalue in [a,b], on whose ends it takes fa and fb, of unlike sides. ITP: never outside of the bracket.
float bracketedRoot(Cubic f, float isovalue, float a, float b, float fa, float fb) {
    if (fa == 0.0) return a;
    if (fb == 0.0) return b;
    precise float pull = 0.2 / (b - a);
    float reach = 1.0;
    for (int turn = 0; turn < kRootTurns; ++turn) {
        TURN;
        precise float width = b - a;
        if (!(width > 2.0 * kRootTolerance)) break;
        precise float middle = a + 0.5 * width;
        precise float falsi = a + width * (fa / (fa - fb));
        precise float delta = pull * width * width;
        precise float towards = middle - falsi;
        precise float ahead = falsi + delta;
        precise float behind = falsi - delta;
        float u = towards > delta ? ahead : towards < -delta ? behind : middle;
        precise float most = reach - 0.5 * width;
        precise float above = middle + most;
        precise float below = middle - most;
        if (u - middle > most) u = above;
        if (u - middle < -most) u = below;
        if (!(u > a && u < b)) u = middle;
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

const float kPlaneMargin = 1.0 / 2048.0; // voxels

// Where the ray first meets a plane of sample centres of this pitch beyond w, in segments from start.
float nextPlane(vec3 start, vec3 step, float w, float pitch) {
    float next = kMaxFloat;
    precise float least = w + kPlaneMargin / uSegmentVoxels;
    TURNS(3);
    for (int axis = 0; axis < 3; ++axis) {
        float d = step[axis];
        if (d == 0.0) continue;
        precise float x = (start[axis] + w * d) / pitch - 0.5;
        float ahead = d > 0.0 ? 1.0 : -1.0;
        precise float plane = (d > 0.0 ? floor(x) : ceil(x)) + ahead;
        precise float at = ((plane + 0.5) * pitch - start[axis]) / d;
        precise float after = ((plane + ahead + 0.5) * pitch - start[axis]) / d;
        if (!(at > least)) at = after;
        next = min(next, at);
    }
    return next;
}
