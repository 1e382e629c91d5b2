// sampler_gradient.glsl: gradients of the field (docs/sampling.md, "Value"), as FEATURE_FORWARD_GRADIENT,
// FEATURE_SOBEL_GRADIENT, FEATURE_ANALYTIC_GRADIENT, FEATURE_HALF_CENTRAL_GRADIENT, FEATURE_CUBIC_GRADIENT say, else
// by central differences over a pitch to either side; as render/contract/sampler.h has them.
// Needs FEATURE_FUSED, sampler_current_brick.glsl. Gives fieldGradient(p): p in level-0 voxels, stored units per voxel;
// normalGradient(p), which is shaded, and SMOOTHS, true where that is another; and kGradientValues, how many values of the field
// one takes.

#if FEATURE_FUSED
uniform int uAxes; // 3, which compilers would unroll loops by: some compile every fetch once for each volume
#else
#define uAxes 3
#endif
const float kMostReach = 16.0; // voxels: no difference reaches further to a side, so the 27 bricks around suffice

#if FEATURE_ANALYTIC_GRADIENT
#include "sampler_slope.glsl"

const uint kGradientValues = 1u; // the samples of one

vec3 fieldGradient(vec3 p) {
    vec3 slope = currentBrickSlope(p);
    ONCE (!inCurrentBrick(p)) slope = fieldSlope(p);
    return slope;
}
#elif FEATURE_FORWARD_GRADIENT || FEATURE_SOBEL_GRADIENT
// From the brick at hand where no other has weight.
float valueNear(vec3 p) {
    float value = currentBrickValue(p);
    ONCE (!inCurrentBrick(p)) value = fieldValue(p);
    return value;
}

#if FEATURE_FORWARD_GRADIENT
const uint kGradientValues = 4u;

vec3 fieldGradient(vec3 p) {
    precise float h = 0.5 * (inCurrentBrick(p) ? currentBrickPitch() : localPitch(p));
    float here = valueNear(p);
    vec3 ahead;
    TURNS(3);
    for (int axis = 0; axis < uAxes; ++axis) {
        vec3 offset = vec3(0.0);
        offset[axis] = h;
        precise vec3 at = p + offset;
        ahead[axis] = valueNear(at);
    }
    precise vec3 g = (ahead - here) / h;
    return g;
}
#else
const uint kGradientValues = 27u;
uniform float uNormalReach; // of normals, pitches

vec3 sobelOver(float reach, vec3 p) {
    precise float h = min(reach * (inCurrentBrick(p) ? currentBrickPitch() : localPitch(p)), kMostReach);
    float here = valueNear(p);
    precise vec3 sum = vec3(0.0);
    for (int n = 0; n < 27; ++n) {
        TURN;
        vec3 side = vec3(ivec3(n % 3, n / 3 % 3, n / 9) - 1);
        precise vec3 at = p + h * side;
        precise float difference = valueNear(at) - here; // exactly 0 where all are the same
        vec3 across = 2.0 - abs(side);
        vec3 weights = side * across.yzx * across.zxy; // whole numbers
        sum = sum + weights * difference;
    }
    precise vec3 g = sum / (32.0 * h);
    return g;
}
vec3 fieldGradient(vec3 p) { return sobelOver(1.0, p); }
vec3 normalGradient(vec3 p) { return sobelOver(uNormalReach, p); }
#define SMOOTHS (uNormalReach > 1.0)
#endif
#else
// Central differences of this very field.
vec3 centralDifferences(vec3 p) {
    precise float pitch = inCurrentBrick(p) ? currentBrickPitch() : localPitch(p);
#if FEATURE_HALF_CENTRAL_GRADIENT
    precise float h = 0.5 * pitch;
#else
    precise float h = min(pitch, kMostReach);
#endif
    // A compiler for SIMD lanes runs both sides of a branch, but a loop only as long as a lane needs it. So the six
    // values are taken from the brick at hand. Those where other bricks have weight are taken again, one by one.
    vec3 ahead;
    vec3 behind;
    int outside = 0; // bits: ahead along x, y, z, then behind
    for (int axis = 0; axis < uAxes; ++axis) {
        vec3 offset = vec3(0.0);
        offset[axis] = h;
        precise vec3 up = p + offset;
        precise vec3 down = p - offset;
        ahead[axis] = currentBrickValue(up);
        behind[axis] = currentBrickValue(down);
        outside |= int(!inCurrentBrick(up)) << axis | int(!inCurrentBrick(down)) << (axis + 3);
    }
    TURNS(3);
    for (; outside != 0; outside &= outside - 1) {
        TURN;
        int turn = findLSB(outside);
        bvec3 axis = equal(ivec3(turn >= 3 ? turn - 3 : turn), ivec3(0, 1, 2));
        precise vec3 at = p + mix(vec3(0.0), vec3(turn < 3 ? h : -h), axis);
        float value = fieldValue(at);
        if (turn < 3) ahead = mix(ahead, vec3(value), axis);
        else behind = mix(behind, vec3(value), axis);
    }
    precise vec3 g = (ahead - behind) / (2.0 * h);
    return g;
}

#if FEATURE_CUBIC_GRADIENT
#include "sampler_cubic.glsl"
#else
const uint kGradientValues = 6u;

vec3 fieldGradient(vec3 p) { return centralDifferences(p); }
#endif
#endif

#ifndef SMOOTHS
#define SMOOTHS false
vec3 normalGradient(vec3 p) { return fieldGradient(p); }
#endif
