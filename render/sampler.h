// render/sampler.h: the field of docs/sampling.md on the CPU: the C++ twin of shaders/sampler_field.glsl and
// sampler_interblock.glsl in exact mode, and the only code here that turns a position into a value or a
// gradient. Positions in level-0 voxels, values as stored, gradients in stored units per voxel.
//
// Samples of one level: glm::ivec3 extent() const; Real at(ivec3) (stored value).
// Samples of mixed levels: const LevelMap& map() const; Real at(int level, ivec3) (stored value of a resident
// brick's sample); Real mean(ivec3 brick).
#pragma once

#include "render/level_map.h"

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

/// Stored value at p of the field whose samples are all of one level.
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

/// Central differences of a field, offset half a pitch.
template <typename Real, typename Value>
glm::vec<3, Real> centralDifferences(const Value& value, const glm::vec<3, Real>& p, Real pitch) {
    const Real h = Real(0.5) * pitch;
    glm::vec<3, Real> g(0);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec<3, Real> offset(0);
        offset[axis] = h;
        g[axis] = (value(p + offset) - value(p - offset)) / pitch;
    }
    return g;
}

template <typename Real, typename Samples>
glm::vec<3, Real> fieldGradient(Samples& samples, const glm::vec<3, Real>& p, Real samplesPerVoxel) {
    return centralDifferences(
        [&](const glm::vec<3, Real>& at) { return fieldValue(samples, at, samplesPerVoxel); }, p,
        Real(1) / samplesPerVoxel);
}

/// One level of samples of mixed levels, empty bricks reading as their mean.
template <typename Samples> struct LevelOfSamples {
    Samples& samples;
    int level;
    glm::ivec3 extent() const { return (samples.map().extentVoxels + ((1 << level) - 1)) >> level; }
    auto at(const glm::ivec3& i) {
        const glm::ivec3 brick = i >> (5 - level);
        return level == kLevelCount - 1 || samples.isEmpty(brick) ? samples.mean(brick)
                                                                  : samples.at(level, i);
    }
};

/// A brick's own value at p: trilinear between its samples, coordinates clamped half a sample inside it.
template <typename Real, typename Samples>
Real brickValue(Samples& samples, const glm::ivec3& brick, std::uint32_t code, const glm::vec<3, Real>& p) {
    if (code + 1 >= std::uint32_t{kLevelCount}) // empty, or the coarsest level's one sample
        return static_cast<Real>(samples.mean(brick));
    LevelOfSamples<Samples> level{samples, static_cast<int>(code)};
    const glm::ivec3 first = brick << (5 - level.level);
    const glm::ivec3 last = glm::min(glm::ivec3(kBrickExtent >> level.level), level.extent() - first) - 1;
    const Real samplesPerVoxel = Real(1) / static_cast<Real>(1 << level.level);
    const glm::vec<3, Real> at = glm::clamp(p * samplesPerVoxel - glm::vec<3, Real>(first) - Real(0.5),
                                            glm::vec<3, Real>(0), glm::vec<3, Real>(last));
    const glm::ivec3 low(at);
    const glm::ivec3 high = glm::min(low + 1, last);
    return trilinear(level, first + low, first + high, at - glm::vec<3, Real>(low));
}

/// Stored value at p of the field of mixed levels.
template <typename Real, typename Samples>
Real interblockValue(Samples& samples, const glm::vec<3, Real>& position) {
    const LevelMap& map = samples.map();
    const CornerPlace<Real> place = cornerPlace(position, glm::vec<3, Real>(map.extentVoxels), map.bricks);
    const BrickCorner& corner = map.at(place.corner);
    if (corner.agree()) {
        LevelOfSamples<Samples> level{samples, corner.commonLevel()};
        return fieldValue(level, place.p, Real(1) / static_cast<Real>(1 << level.level));
    }
    const int near = nearAxes(corner, place.offset);
    Real sum(0), weights(0);
    int subset = 0;
    do { // the home brick, then every brick across some of the near axes
        const int n = place.home ^ subset;
        const Real weight = cornerWeight(corner, n, near, place.offset, map.edgeFunction, map.finest);
        if (weight > Real(0)) {
            const glm::ivec3 brick = place.corner - 1 + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2);
            sum = sum + weight * brickValue(samples, brick, corner.code(n), place.p);
            weights = weights + weight;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    return near == 0 ? sum : sum / weights;
}

/// Distance of samples at p, voxels, with the weights of their values; empty bricks count as the finest
/// level.
template <typename Real, typename Samples>
Real interblockPitch(Samples& samples, const glm::vec<3, Real>& position) {
    const LevelMap& map = samples.map();
    const CornerPlace<Real> place = cornerPlace(position, glm::vec<3, Real>(map.extentVoxels), map.bricks);
    const BrickCorner& corner = map.at(place.corner);
    const int near = corner.agree() ? 0 : nearAxes(corner, place.offset);
    Real sum(0), weights(0);
    int subset = 0;
    do {
        const int n = place.home ^ subset;
        const Real weight = cornerWeight(corner, n, near, place.offset, map.edgeFunction, map.finest);
        const std::uint32_t code = corner.code(n);
        sum = sum + weight * static_cast<Real>(1 << (code == BrickCorner::kEmpty ? map.finest : code));
        weights = weights + weight;
        subset = (subset - near) & near;
    } while (subset != 0);
    return sum / weights;
}

/// Central differences of the field of mixed levels, offset half the local pitch.
template <typename Real, typename Samples>
glm::vec<3, Real> interblockGradient(Samples& samples, const glm::vec<3, Real>& p) {
    return centralDifferences([&](const glm::vec<3, Real>& at) { return interblockValue(samples, at); }, p,
                              interblockPitch(samples, p));
}

} // namespace tessera
