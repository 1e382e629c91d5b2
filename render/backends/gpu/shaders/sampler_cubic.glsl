// sampler_cubic.glsl: the gradient of the cubic B-spline of samples (docs/sampling.md, "Value"); as
// cubicDifferences() and interblockCubic() in render/contract/sampler.h have it. Needs sampler_current_brick.glsl,
// centralDifferences(). Gives the functions that sampler_gradient.glsl names.

#include "leaf_cubic.h"

const uint kGradientValues = 64u;
const float kMostCubicPitch = 8.0; // voxels

float valueOf(CubicWeights w, vec4 v) { return cubicValue(w, v.x, v.y, v.z, v.w); }
float stepOf(CubicWeights w, vec4 v) { return cubicStep(w, v.x, v.y, v.z, v.w); }

// Of the lattice of this pitch, per voxel.
vec3 cubicDifferences(vec3 p, float pitch) {
    precise float h = min(pitch, kMostCubicPitch);
    precise vec3 at = (1.0 / h) * p - 0.5;
    vec3 cell = floor(at);
    precise vec3 part = at - cell;
    CubicWeights wx = cubicWeights(part.x), wy = cubicWeights(part.y), wz = cubicWeights(part.z);
    vec4 alongX;
    vec4 alongY;
    vec4 smooth_;
    for (int z = 0; z < 4; ++z) {
        TURNS(5);
        vec4 steps;
        vec4 values;
        for (int y = 0; y < 4; ++y) {
            vec4 row;
            for (int x = 0; x < 4; ++x) {
                TURN;
                precise vec3 sampleAt = h * (cell + (vec3(x, y, z) - 0.5));
                float value = currentBrickValue(sampleAt);
                ONCE (!inCurrentBrick(sampleAt)) value = fieldValue(sampleAt);
                row[x] = value;
            }
            steps[y] = stepOf(wx, row);
            values[y] = valueOf(wx, row);
        }
        alongX[z] = valueOf(wy, steps);
        alongY[z] = stepOf(wy, values);
        smooth_[z] = valueOf(wy, values);
    }
    precise vec3 g = vec3(valueOf(wz, alongX), valueOf(wz, alongY), stepOf(wz, smooth_)) * (1.0 / h);
    return g;
}

#if FEATURE_MIXED
// Of the level that has most weight, as far as that is more than all others have, and central differences for the rest.
vec3 fieldGradient(vec3 p) {
    float share = 1.0;
    float pitch = currentBrickPitch();
    ONCE (!inCurrentBrick(p)) {
        Place place = placeOf(p);
        uvec2 corner = cornerTexel(place.corner);
        bool agree = (corner.y & kAgreeBit) != 0u;
        int near = agree ? 0 : nearAxes(corner, place.offset);
        precise float ofLevel[6] = float[6](0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        precise float all_ = 0.0;
        int subset = 0;
        do {
            TURN;
            int n = place.current ^ subset;
            uint code = codeOf(corner, n);
            if (code < 6u) {
                float weight = cornerWeight(corner, n, near, place.offset);
                ofLevel[code] = ofLevel[code] + weight;
                all_ = all_ + weight;
            }
            subset = (subset - near) & near;
        } while (subset != 0);
        int most = 0;
        for (int level = 1; level < 6; ++level)
            if (ofLevel[level] > ofLevel[most]) most = level;
        TURNS(5);
        precise float more = 2.0 * (ofLevel[most] / all_) - 1.0;
        bool one = agree || !(all_ > 0.0);
        share = one ? 1.0 : more;
        pitch = float(1 << (agree ? int((corner.y >> 13) & 7u) : all_ > 0.0 ? most : uFinest));
    }
    vec3 central = vec3(0.0);
    vec3 cubic = vec3(0.0);
    ONCE (share < 1.0) central = centralDifferences(p);
    if (share > 0.0) cubic = cubicDifferences(p, pitch);
    precise vec3 between = central + share * (cubic - central);
    return share >= 1.0 ? cubic : share <= 0.0 ? central : between;
}
#else
vec3 fieldGradient(vec3 p) { return cubicDifferences(p, currentBrickPitch()); }
#endif
