// sampler_cubic.glsl: the gradient of the cubic B-spline of samples (docs/sampling.md, "Value"); twin of
// cubicDifferences() and interblockCubic() in render/contract/sampler.h and of cubicGradient() in render/contract/leaves.h.
// Needs sampler_current_brick.glsl, centralDifferences(). Gives what sampler_gradient.glsl says.

const uint kGradientValues = 64u;
const float kMostCubicPitch = 8.0; // voxels

struct CubicWeights {
    vec4 value; // of the samples -1, 0, 1, 2
    vec3 step;  // of the differences between each and the next
};

CubicWeights cubicWeights(float f) {
    precise float g = 1.0 - f;
    precise float ff = f * f;
    precise float gg = g * g;
    precise float first = (1.0 / 6.0) * gg * g;
    precise float last = (1.0 / 6.0) * ff * f;
    precise float low = (2.0 / 3.0) - ff * (1.0 - 0.5 * f);
    precise float high = ((1.0 - first) - low) - last;
    precise float middle = 0.5 + f * g;
    return CubicWeights(vec4(first, low, high, last), vec3(0.5 * gg, middle, 0.5 * ff));
}

float cubicValue(CubicWeights w, vec4 v) {
    precise float sum = w.value.x * v.x + w.value.y * v.y + w.value.z * v.z + w.value.w * v.w;
    return sum;
}

float cubicStep(CubicWeights w, vec4 v) {
    precise float sum = w.step.x * (v.y - v.x) + w.step.y * (v.z - v.y) + w.step.z * (v.w - v.z);
    return sum;
}

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
            steps[y] = cubicStep(wx, row);
            values[y] = cubicValue(wx, row);
        }
        alongX[z] = cubicValue(wy, steps);
        alongY[z] = cubicStep(wy, values);
        smooth_[z] = cubicValue(wy, values);
    }
    precise vec3 g = vec3(cubicValue(wz, alongX), cubicValue(wz, alongY), cubicStep(wz, smooth_)) * (1.0 / h);
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
