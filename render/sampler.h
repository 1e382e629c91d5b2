// render/sampler.h: the field of docs/sampling.md on the CPU: the C++ twin of shaders/sampler_field.glsl in
// exact mode, and the only code here that turns a position into a value or a gradient. A Samples type offers:
// glm::ivec3 extent() const (samples of its level) and Real at(ivec3) (stored value).
#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace tessera {

template <typename Real, typename Samples>
Real trilinear(Samples& samples, const glm::ivec3& low, const glm::ivec3& high, const glm::vec<3, Real>& f) {
    const auto at = [&](int x, int y, int z) { return static_cast<Real>(samples.at({x, y, z})); };
    const Real v000 = at(low.x, low.y, low.z), v100 = at(high.x, low.y, low.z);
    const Real v010 = at(low.x, high.y, low.z), v110 = at(high.x, high.y, low.z);
    const Real v001 = at(low.x, low.y, high.z), v101 = at(high.x, low.y, high.z);
    const Real v011 = at(low.x, high.y, high.z), v111 = at(high.x, high.y, high.z);
    const Real a = v000 + f.x * (v100 - v000), b = v010 + f.x * (v110 - v010);
    const Real c = v001 + f.x * (v101 - v001), d = v011 + f.x * (v111 - v011);
    const Real e = a + f.y * (b - a), g = c + f.y * (d - c);
    return e + f.z * (g - e);
}

/// Stored value at p (level-0 voxels) of the field whose samples are all of one level.
/// @param samplesPerVoxel  2^-level, exact
template <typename Real, typename Samples>
Real fieldValue(Samples& samples, const glm::vec<3, Real>& p, Real samplesPerVoxel) {
    const glm::ivec3 last = samples.extent() - 1;
    const glm::vec<3, Real> at =
        glm::clamp(p * samplesPerVoxel - Real(0.5), glm::vec<3, Real>(0), glm::vec<3, Real>(last));
    const glm::ivec3 low(at); // not negative, so this is floor
    const glm::ivec3 high = glm::min(low + 1, last);
    return trilinear(samples, low, high, at - glm::vec<3, Real>(low));
}

/// Central differences of this very field, offset half a sample; stored units per sample pitch, voxel space.
template <typename Real, typename Samples>
glm::vec<3, Real> fieldGradient(Samples& samples, const glm::vec<3, Real>& p, Real samplesPerVoxel) {
    const Real h = Real(0.5) / samplesPerVoxel;
    glm::vec<3, Real> g(0);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec<3, Real> offset(0);
        offset[axis] = h;
        g[axis] = fieldValue(samples, p + offset, samplesPerVoxel) -
                  fieldValue(samples, p - offset, samplesPerVoxel);
    }
    return g;
}

} // namespace tessera
