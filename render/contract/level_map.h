// render/contract/level_map.h: the level map: a selection's levels as rays meet them. One texel per brick
// corner names the eight bricks around it. The CPU makes it; the mirror and the GPU ray caster read it alike.
#pragma once

#include "bricking/levels/selection.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/contract/leaves.h"

#include <array>
#include <bit>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

// The eight bricks around a brick corner, and the blend of their samples there: interblock interpolation of
// any mix of levels (docs/sampling.md, "Value"; course notes 2.10.2). In float
// shaders/sampler_interblock.glsl does the same operations in the same order.

/// The eight bricks around a corner, as one texel of the level map. Brick number n lies at corner - 1 + (n&1,
/// n>>1&1, n>>2).
struct BrickCorner {
    static constexpr std::uint32_t kEmpty = Selection::kEmpty, kOutside = 7;
    static constexpr std::uint32_t kNoReach = 15, kAgreeBit = 1u << 12;

    std::uint32_t codes = 0; // four bits a brick: its level, kEmpty, or kOutside of the volume
    /// Bits 0-11, four an axis: r where bricks of the axis' other side have weight within 2^r / 2 voxels, or
    /// kNoReach. Bit 12: all inside share one level, so that the field is plain trilinear interpolation of
    /// it. Bits 13-15: that level. Bits 16-18: the finest level here; kLevelCount where all are empty.
    std::uint32_t facts = 0;

    std::uint32_t code(int brick) const { return (codes >> (4 * brick)) & 15u; }
    bool agree() const { return (facts & kAgreeBit) != 0; }
    int commonLevel() const { return static_cast<int>((facts >> 13) & 7u); }
    int finestLevel() const { return static_cast<int>((facts >> 16) & 7u); }
    std::uint32_t reachCode(int axis) const { return (facts >> (4 * axis)) & 15u; }
    friend bool operator==(const BrickCorner&, const BrickCorner&) = default;
};

static_assert(BrickCorner::kEmpty == static_cast<std::uint32_t>(leaf::kEmptyCode) &&
              BrickCorner::kOutside == static_cast<std::uint32_t>(leaf::kOutsideCode));
static_assert(static_cast<int>(EdgeFunction::nearest) == leaf::kNearestEdge &&
              static_cast<int>(EdgeFunction::minimum) == leaf::kMinimumEdge &&
              static_cast<int>(EdgeFunction::maximum) == leaf::kMaximumEdge);

/// Half a sample of a level, in voxels: exact.
template <typename Real> Real halfSample(std::uint32_t level) {
    return static_cast<Real>(std::bit_cast<float>((126u + level) << 23));
}

/// The reach of a brick's edge weight into its own side and into the other's, voxels, between two facing
/// bricks. Towards an empty brick it is always the other's half sample. Between two empty ones it is the
/// finest level's, so that a volume of one level stays plain trilinear everywhere.
template <typename Real> struct EdgeReach { Real own = 0, other = 0; };
template <typename Real>
EdgeReach<Real> edgeReach(std::uint32_t own, std::uint32_t other, EdgeFunction function,
                          std::uint32_t finest) {
    if (function == EdgeFunction::nearest && own != BrickCorner::kEmpty && other != BrickCorner::kEmpty)
        return {};
    const auto reach = [&](bool ahead) {
        return halfSample<Real>(leaf::edgeLevel(own, other, ahead, static_cast<int>(function), finest));
    };
    return {reach(true), reach(false)};
}

/// Weight of a brick against the one it faces.
/// @param into  voxels from their boundary into its own side
template <typename Real> Real edgeWeight(const EdgeReach<Real>& reach, Real into, bool upperSide) {
    const Real r = into >= Real(0) ? reach.own : reach.other;
    return r == Real(0) ? leaf::edgeStep(into, upperSide) : leaf::edgeWeight(into, Real(1) / r);
}

/// Derivative of edgeWeight() along its axis' coordinate.
template <typename Real> Real edgeWeightSlope(const EdgeReach<Real>& reach, Real into, bool upperSide) {
    const Real r = into >= Real(0) ? reach.own : reach.other;
    return leaf::edgeSlope(into, r, upperSide);
}

/// The place of a point among the eight bricks around its nearest brick corner.
template <typename Real> struct CornerPlace {
    glm::ivec3 corner{0};
    glm::vec<3, Real> p{0};      // voxels
    glm::vec<3, Real> offset{0}; // voxels from the corner, within half a brick inside the volume
    int current = 0;             // number of the brick that p lies in
};
template <typename Real>
CornerPlace<Real> cornerPlace(const glm::vec<3, Real>& position, const glm::vec<3, Real>& extentVoxels,
                              const glm::ivec3& bricks) {
    CornerPlace<Real> place;
    place.p = position;
    for (int axis = 0; axis < 3; ++axis) {
        const Real inVolume = glm::clamp(position[axis], Real(0), extentVoxels[axis]);
        const int brick = std::min(static_cast<int>(inVolume) >> 5, bricks[axis] - 1);
        const Real inside = place.p[axis] - static_cast<Real>(brick * kBrickExtent);
        const bool lower =
            inside < Real(kBrickExtent / 2); // nearer to its lower corner: it is the upper brick there
        place.corner[axis] = brick + (lower ? 0 : 1);
        place.offset[axis] = lower ? inside : inside - Real(kBrickExtent);
        place.current |= (lower ? 1 : 0) << axis;
    }
    return place;
}

/// Axes, as bits, along which bricks of the other side have weight.
template <typename Real> int nearAxes(const BrickCorner& corner, const glm::vec<3, Real>& offset) {
    int near = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t reach = corner.reachCode(axis);
        if (reach != BrickCorner::kNoReach && std::abs(offset[axis]) < halfSample<Real>(reach))
            near |= 1 << axis;
    }
    return near;
}

/// Weight of one of the eight before normalisation: the product of its edge weights along the near axes.
template <typename Real>
Real cornerWeight(const BrickCorner& corner, int brick, int near, const glm::vec<3, Real>& offset,
                  EdgeFunction function, std::uint32_t finest) {
    Real weight(1);
    const std::uint32_t own = corner.code(brick);
    if (own == BrickCorner::kOutside)
        return Real(0);
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t other = corner.code(brick ^ (1 << axis));
        if ((near & (1 << axis)) == 0 || other == BrickCorner::kOutside)
            continue;
        const bool upper = (brick & (1 << axis)) != 0;
        weight = weight * edgeWeight(edgeReach<Real>(own, other, function, finest),
                                     upper ? offset[axis] : -offset[axis], upper);
    }
    return weight;
}

/// Derivative of cornerWeight().
template <typename Real>
glm::vec<3, Real> cornerWeightSlope(const BrickCorner& corner, int brick, int near,
                                    const glm::vec<3, Real>& offset, EdgeFunction function,
                                    std::uint32_t finest) {
    glm::vec<3, Real> weights(1), slopes(0);
    const std::uint32_t own = corner.code(brick);
    for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t other = corner.code(brick ^ (1 << axis));
        if ((near & (1 << axis)) == 0 || other == BrickCorner::kOutside)
            continue;
        const bool upper = (brick & (1 << axis)) != 0;
        const EdgeReach<Real> reach = edgeReach<Real>(own, other, function, finest);
        weights[axis] = edgeWeight(reach, upper ? offset[axis] : -offset[axis], upper);
        slopes[axis] = edgeWeightSlope(reach, upper ? offset[axis] : -offset[axis], upper);
    }
    return {slopes.x * (weights.y * weights.z), slopes.y * (weights.z * weights.x),
            slopes.z * (weights.x * weights.y)};
}

/// Largest k such that a ray may stride over 2^k segments from a place (docs/sampling.md, "Ray").
/// @param strideVoxels  length of a segment, voxels
/// @param most  no stride above 2^most is wanted
template <typename Real>
int strideExponent(const BrickCorner& corner, const CornerPlace<Real>& place, Sampling sampling,
                   Real segmentVoxels, int most) {
    const std::uint32_t current = corner.code(place.current);
    int k = std::min(static_cast<int>(current), most); // an empty brick counts as coarser than all
    if (sampling == Sampling::naive || k <= corner.finestLevel())
        return k;
    // True where a finer brick can have weight under any edge function, or where the stride itself can reach
    // it.
    const Real reach = glm::max(halfSample<Real>(std::min(current, std::uint32_t{kLevelCount - 1})),
                                segmentVoxels * static_cast<Real>(1 << k));
    int near = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(place.offset[axis]) < reach)
            near |= 1 << axis;
    for (int other = 1; other < 8; ++other)
        if ((other & ~near) == 0)
            k = std::min(k, static_cast<int>(corner.code(place.current ^ other)));
    return k;
}

struct LevelMap {
    glm::ivec3 extentVoxels{0}, bricks{0};
    EdgeFunction edgeFunction = EdgeFunction::split;
    std::uint32_t finest = 0;         // level of the selection
    int mostStride = 0;               // no stride above 2^this
    std::vector<BrickCorner> corners; // [z][y][x] over bricks + 1
    /// [z][y][x] over bricks. Bits 0-2 are the brick's code. Then come three bits a face (low x, y, z, high
    /// x, y, z). They hold the widest reach of the face's four corners along its axis as a level, 6 where
    /// there is none, 7 at the volume's border. From bit 21 on one bit a face says that a brick at one of
    /// these corners is finer.
    std::vector<std::uint32_t> facts;
    Charge charge;

    glm::ivec3 cornerGrid() const { return bricks + 1; }
    const BrickCorner& at(const glm::ivec3& corner) const {
        return corners[linearIndex(corner, cornerGrid())];
    }
    /// Of the brick that p lies in; an empty one counts as the finest.
    template <typename Real> int levelAt(const glm::vec<3, Real>& p) const {
        const auto place = cornerPlace(p, glm::vec<3, Real>(extentVoxels), bricks);
        const std::uint32_t code = at(place.corner).code(place.current);
        return static_cast<int>(code == BrickCorner::kEmpty ? finest : code);
    }
    static std::size_t bytes(const glm::ivec3& bricks) {
        return sizeof(BrickCorner) * cellCount(bricks + 1) + sizeof(std::uint32_t) * cellCount(bricks);
    }
};

/// Largest k such that a ray may ever stride over 2^k segments: the coarsest level in use, half a
/// brick at most.
int mostStride(const Selection& selection, const Quality& quality);

LevelMap makeLevelMap(const Selection& selection, const glm::ivec3& extentVoxels, const Quality& quality,
                      MemoryBudget& ram);

} // namespace tessera
