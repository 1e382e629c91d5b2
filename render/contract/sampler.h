// render/contract/sampler.h: the field of docs/sampling.md on the CPU, as
// shaders/sampler_field.glsl, sampler_interblock.glsl, sampler_gradient.glsl and sampler_slope.glsl have it
// in exact mode, from the same leaves (leaves.h). No other code here turns a position into a value or a
// gradient. Positions are in level-0 voxels, values as stored, gradients in stored units per voxel.
//
// Samples of one level: glm::ivec3 extent() const; Real at(ivec3) (stored value); or also cube<2>(ivec3
// first, double* out), the eight from there on at once, x fastest, beyond the outermost that one. Samples of
// mixed levels: const LevelMap& map() const; Real at(int level, ivec3) (stored value of a resident brick's
// sample); Real mean(ivec3 brick).
#pragma once

#include "core/scene/scene.h" // Gradient
#include "render/contract/leaves.h"
#include "render/contract/level_map.h"

#include <array>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace tessera {

/// The samples at the corners of a cell, x fastest.
template <typename Real, typename Samples>
std::array<Real, 8> cellCorners(Samples& samples, const glm::ivec3& low, const glm::ivec3& high) {
    std::array<Real, 8> v;
    if constexpr (requires(double* out) { samples.template cube<2>(low, out); }) {
        double stored[8];
        samples.template cube<2>(low, stored);
        for (std::size_t n = 0; n < 8; ++n)
            v[n] = static_cast<Real>(stored[n]);
    } else {
        for (std::size_t n = 0; n < 8; ++n)
            v[n] = static_cast<Real>(samples.at({(n & 1) != 0 ? high.x : low.x, (n & 2) != 0 ? high.y : low.y,
                                                 (n & 4) != 0 ? high.z : low.z}));
    }
    return v;
}

template <typename Real, typename Samples>
Real trilinear(Samples& samples, const glm::ivec3& low, const glm::ivec3& high, const glm::vec<3, Real>& f) {
    const auto v = cellCorners<Real>(samples, low, high);
    return leaf::trilinear(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], f.x, f.y, f.z);
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

/// No difference reaches further to a side, voxels: so no brick is needed but the 27 around a position.
constexpr int kMostReach = kBrickExtent / 2;

/// Central differences of a field, h to either side.
template <typename Real, typename Value>
glm::vec<3, Real> centralDifferences(const Value& value, const glm::vec<3, Real>& p, Real h) {
    glm::vec<3, Real> g(0);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec<3, Real> offset(0);
        offset[axis] = h;
        g[axis] = (value(p + offset) - value(p - offset)) / (Real(2) * h);
    }
    return g;
}

/// Differences to one side, over half a pitch.
template <typename Real, typename Value>
glm::vec<3, Real> forwardDifferences(const Value& value, const glm::vec<3, Real>& p, Real pitch) {
    const Real h = Real(0.5) * pitch;
    const Real here = value(p);
    glm::vec<3, Real> g(0);
    for (int axis = 0; axis < 3; ++axis) {
        glm::vec<3, Real> offset(0);
        offset[axis] = h;
        g[axis] = (value(p + offset) - here) / h;
    }
    return g;
}

/// Differences over two pitches, smoothed across by 1:2:1 (Sobel's operator in three dimensions): at a
/// sample's centre they are that of its 26 neighbours.
template <typename Real, typename Value>
glm::vec<3, Real> sobelDifferences(const Value& value, const glm::vec<3, Real>& p, Real pitch) {
    const Real h = std::min(pitch, Real(kMostReach));
    const Real here = value(p);
    glm::vec<3, Real> sum(0);
    for (int n = 0; n < 27; ++n) {
        const glm::vec<3, Real> side(glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1);
        const Real difference = value(p + h * side) - here; // exactly 0 where all are the same
        const glm::vec<3, Real> across = Real(2) - glm::abs(side);
        sum = sum + side * glm::vec<3, Real>(across.y, across.z, across.x) *
                        glm::vec<3, Real>(across.z, across.x, across.y) * difference;
    }
    return sum / (Real(32) * h);
}

/// No cubic gradient is of a lattice that is coarser, voxels: for the same reason.
constexpr int kMostCubicPitch = kMostReach / 2;

/// The derivative of the cubic B-spline of a field's values on a lattice: smooth across its cells.
/// @param pitch  of the lattice, a power of two; its points are those of samples of that pitch
template <typename Real, typename Value>
glm::vec<3, Real> cubicDifferences(const Value& value, const glm::vec<3, Real>& p, Real pitch) {
    const Real h = std::min(pitch, Real(kMostCubicPitch));
    const glm::vec<3, Real> at = (Real(1) / h) * p - Real(0.5), cell = glm::floor(at), part = at - cell;
    const auto row = [&](int y, int z, Real(&r)[4]) {
        for (int x = 0; x < 4; ++x)
            r[x] = value(h * (cell + (glm::vec<3, Real>(glm::ivec3(x, y, z)) - Real(0.5))));
    };
    return leaf::cubicGradient<Real, glm::vec<3, Real>>(part.x, part.y, part.z, row) * (Real(1) / h);
}

/// Differences of a field, of any kind but the analytic one.
template <typename Real, typename Value>
glm::vec<3, Real> differences(Gradient kind, const Value& value, const glm::vec<3, Real>& p, Real pitch) {
    switch (kind) {
    case Gradient::forward:
        return forwardDifferences(value, p, pitch);
    case Gradient::sobel:
        return sobelDifferences(value, p, pitch);
    case Gradient::sobel2:
    case Gradient::sobel4:
        return sobelDifferences(value, p, static_cast<Real>(reachOf(kind)) * pitch);
    case Gradient::centralHalf:
        return centralDifferences(value, p, Real(0.5) * pitch);
    case Gradient::cubic:
        return cubicDifferences(value, p, pitch);
    case Gradient::central:
    case Gradient::analytic:
        break;
    }
    return centralDifferences(value, p, std::min(pitch, Real(kMostReach)));
}

/// The number of values of the field that a gradient takes; the analytic one takes the samples of one.
constexpr int gradientValues(Gradient kind) {
    switch (kind) {
    case Gradient::forward:
        return 4;
    case Gradient::sobel:
    case Gradient::sobel2:
    case Gradient::sobel4:
        return 27;
    case Gradient::analytic:
        return 1;
    case Gradient::cubic:
        return 64;
    case Gradient::central:
    case Gradient::centralHalf:
        break;
    }
    return 6;
}

/// A field's derivative, per voxel, and its value.
template <typename Real> struct Slope {
    glm::vec<3, Real> slope{0};
    Real value = 0;
};

/// Derivative of trilinear(), per sample.
template <typename Real, typename Samples>
Slope<Real> trilinearSlope(Samples& samples, const glm::ivec3& low, const glm::ivec3& high,
                           const glm::vec<3, Real>& f) {
    const auto v = cellCorners<Real>(samples, low, high);
    const auto s = leaf::trilinearSlope(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], f.x, f.y, f.z);
    return {{s.x, s.y, s.z}, s.value};
}

/// Derivative of trilinear interpolation between samples up to `last`, at lattice coordinates. It is 0 along
/// an axis where they lie beyond the outermost sample; at a sample's centre it is that of the cell above.
template <typename Real, typename Samples>
Slope<Real> latticeSlope(Samples& samples, const glm::ivec3& first, const glm::ivec3& last,
                         const glm::vec<3, Real>& at, Real samplesPerVoxel) {
    const glm::vec<3, Real> inside = glm::clamp(at, glm::vec<3, Real>(0), glm::vec<3, Real>(last));
    const glm::ivec3 low(inside);
    const glm::ivec3 high = glm::min(low + 1, last);
    Slope<Real> s = trilinearSlope(samples, first + low, first + high, inside - glm::vec<3, Real>(low));
    for (int axis = 0; axis < 3; ++axis)
        s.slope[axis] = at[axis] == inside[axis] ? s.slope[axis] * samplesPerVoxel : Real(0);
    return s;
}

template <typename Real, typename Samples>
Slope<Real> fieldSlope(Samples& samples, const glm::vec<3, Real>& p, Real samplesPerVoxel) {
    return latticeSlope(samples, glm::ivec3(0), samples.extent() - 1, p * samplesPerVoxel - Real(0.5),
                        samplesPerVoxel);
}

template <typename Real, typename Samples>
glm::vec<3, Real> fieldGradient(Samples& samples, const glm::vec<3, Real>& p, Real samplesPerVoxel,
                                Gradient kind = Gradient::central) {
    if (kind == Gradient::analytic)
        return fieldSlope(samples, p, samplesPerVoxel).slope;
    return differences(
        kind, [&](const glm::vec<3, Real>& at) { return fieldValue(samples, at, samplesPerVoxel); }, p,
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
    do { // the current brick, then every brick across some of the near axes
        const int n = place.current ^ subset;
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

/// Distance of samples at p, voxels, with the weights of their values; empty bricks count as
/// the finest level.
template <typename Real, typename Samples>
Real interblockPitch(Samples& samples, const glm::vec<3, Real>& position) {
    const LevelMap& map = samples.map();
    const CornerPlace<Real> place = cornerPlace(position, glm::vec<3, Real>(map.extentVoxels), map.bricks);
    const BrickCorner& corner = map.at(place.corner);
    const int near = corner.agree() ? 0 : nearAxes(corner, place.offset);
    Real sum(0), weights(0);
    int subset = 0;
    do {
        const int n = place.current ^ subset;
        const Real weight = cornerWeight(corner, n, near, place.offset, map.edgeFunction, map.finest);
        const std::uint32_t code = corner.code(n);
        sum = sum + weight * static_cast<Real>(1 << (code == BrickCorner::kEmpty ? map.finest : code));
        weights = weights + weight;
        subset = (subset - near) & near;
    } while (subset != 0);
    return sum / weights;
}

/// Derivative of brickValue().
template <typename Real, typename Samples>
Slope<Real> brickSlope(Samples& samples, const glm::ivec3& brick, std::uint32_t code,
                       const glm::vec<3, Real>& p) {
    if (code + 1 >= std::uint32_t{kLevelCount})
        return {{}, static_cast<Real>(samples.mean(brick))};
    LevelOfSamples<Samples> level{samples, static_cast<int>(code)};
    const glm::ivec3 first = brick << (5 - level.level);
    const glm::ivec3 last = glm::min(glm::ivec3(kBrickExtent >> level.level), level.extent() - first) - 1;
    const Real samplesPerVoxel = Real(1) / static_cast<Real>(1 << level.level);
    return latticeSlope(level, first, last, p * samplesPerVoxel - glm::vec<3, Real>(first) - Real(0.5),
                        samplesPerVoxel);
}

/// Derivative of interblockValue(), a quotient of blends where levels mix. Not continuous.
template <typename Real, typename Samples>
glm::vec<3, Real> interblockSlope(Samples& samples, const glm::vec<3, Real>& position) {
    const LevelMap& map = samples.map();
    const CornerPlace<Real> place = cornerPlace(position, glm::vec<3, Real>(map.extentVoxels), map.bricks);
    const BrickCorner& corner = map.at(place.corner);
    if (corner.agree()) {
        LevelOfSamples<Samples> level{samples, corner.commonLevel()};
        return fieldSlope(level, place.p, Real(1) / static_cast<Real>(1 << level.level)).slope;
    }
    const int near = nearAxes(corner, place.offset);
    // The value is sum / weights; values count from the current brick's, so that equal ones have no
    // slope at all.
    Real sum(0), weights(0), current(0);
    glm::vec<3, Real> sumSlope(0), weightsSlope(0);
    int subset = 0;
    do {
        const int n = place.current ^ subset;
        const Real weight = cornerWeight(corner, n, near, place.offset, map.edgeFunction, map.finest);
        if (weight > Real(0)) {
            const glm::ivec3 at = place.corner - 1 + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2);
            const Slope<Real> brick = brickSlope(samples, at, corner.code(n), place.p);
            if (subset == 0)
                current = brick.value;
            const Real value = brick.value - current;
            const glm::vec<3, Real> weightSlope =
                cornerWeightSlope(corner, n, near, place.offset, map.edgeFunction, map.finest);
            sum = sum + weight * value;
            sumSlope = sumSlope + (weightSlope * value + weight * brick.slope);
            weights = weights + weight;
            weightsSlope = weightsSlope + weightSlope;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    return (sumSlope - (sum / weights) * weightsSlope) / weights;
}

/// Cubic gradient of the field of mixed levels. It is that of the lattice of the level that has most weight,
/// as far as that is more than all others have. For the rest it is that of central differences. Empty bricks
/// have no level.
template <typename Real, typename Samples>
glm::vec<3, Real> interblockCubic(Samples& samples, const glm::vec<3, Real>& position) {
    const LevelMap& map = samples.map();
    const CornerPlace<Real> place = cornerPlace(position, glm::vec<3, Real>(map.extentVoxels), map.bricks);
    const BrickCorner& corner = map.at(place.corner);
    const auto value = [&](const glm::vec<3, Real>& at) { return interblockValue(samples, at); };
    const auto cubic = [&](int level) {
        return cubicDifferences(value, position, static_cast<Real>(1 << level));
    };
    if (corner.agree())
        return cubic(corner.commonLevel());
    const int near = nearAxes(corner, place.offset);
    std::array<Real, kLevelCount> ofLevel{};
    Real all(0);
    int subset = 0;
    do {
        const int n = place.current ^ subset;
        const std::uint32_t code = corner.code(n);
        if (code < std::uint32_t{kLevelCount}) {
            const Real weight = cornerWeight(corner, n, near, place.offset, map.edgeFunction, map.finest);
            ofLevel[code] = ofLevel[code] + weight;
            all = all + weight;
        }
        subset = (subset - near) & near;
    } while (subset != 0);
    int most = 0;
    for (int level = 1; level < kLevelCount; ++level)
        if (ofLevel[static_cast<std::size_t>(level)] > ofLevel[static_cast<std::size_t>(most)])
            most = level;
    if (!(all > Real(0)))
        return cubic(static_cast<int>(map.finest));
    const Real share = Real(2) * (ofLevel[static_cast<std::size_t>(most)] / all) - Real(1);
    if (share >= Real(1))
        return cubic(most);
    const glm::vec<3, Real> central =
        centralDifferences(value, position, std::min(interblockPitch(samples, position), Real(kMostReach)));
    return share <= Real(0) ? central : central + share * (cubic(most) - central);
}

/// Gradient of the field of mixed levels; differences with the local pitch.
template <typename Real, typename Samples>
glm::vec<3, Real> interblockGradient(Samples& samples, const glm::vec<3, Real>& p,
                                     Gradient kind = Gradient::central) {
    if (kind == Gradient::analytic)
        return interblockSlope(samples, p);
    if (kind == Gradient::cubic)
        return interblockCubic(samples, p);
    return differences(
        kind, [&](const glm::vec<3, Real>& at) { return interblockValue(samples, at); }, p,
        interblockPitch(samples, p));
}

} // namespace tessera
