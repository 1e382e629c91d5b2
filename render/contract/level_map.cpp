// render/contract/level_map.cpp: see level_map.h.
#include "render/contract/level_map.h"

#include <algorithm>

namespace tessera {
namespace {

/// Level whose half sample is the wider reach of an edge; -1: none. The same cases as edgeReach().
int widestLevel(std::uint32_t a, std::uint32_t b, EdgeFunction function, std::uint32_t finest) {
    if (a == BrickCorner::kOutside || b == BrickCorner::kOutside)
        return -1;
    if (a == BrickCorner::kEmpty || b == BrickCorner::kEmpty)
        return static_cast<int>(a != BrickCorner::kEmpty ? a : b != BrickCorner::kEmpty ? b : finest);
    switch (function) {
    case EdgeFunction::nearest:
        return -1;
    case EdgeFunction::minimum:
        return static_cast<int>(std::min(a, b));
    case EdgeFunction::split:
    case EdgeFunction::maximum:
        break;
    }
    return static_cast<int>(std::max(a, b));
}

/// Reach along an axis: the widest of its four edges.
std::uint32_t reachOf(const BrickCorner& corner, int axis, EdgeFunction function, std::uint32_t finest) {
    int widest = -1;
    for (int brick = 0; brick < 8; ++brick)
        if ((brick & (1 << axis)) == 0)
            widest = std::max(
                widest, widestLevel(corner.code(brick), corner.code(brick | (1 << axis)), function, finest));
    return widest < 0 ? BrickCorner::kNoReach : static_cast<std::uint32_t>(widest);
}

std::uint32_t factsOf(const LevelMap& map, const Selection& selection, const glm::ivec3& brick) {
    const int own = selection.levels[linearIndex(brick, selection.bricks)];
    auto facts = static_cast<std::uint32_t>(own);
    for (int face = 0; face < 6; ++face) {
        const int axis = face % 3, u = (axis + 1) % 3, v = (axis + 2) % 3;
        int widest = -1;
        bool finer = false;
        for (int n = 0; n < 4; ++n) {
            glm::ivec3 at = brick;
            at[axis] += face / 3;
            at[u] += n & 1;
            at[v] += n >> 1;
            const BrickCorner& corner = map.at(at);
            if (corner.reachCode(axis) != BrickCorner::kNoReach)
                widest = std::max(widest, static_cast<int>(corner.reachCode(axis)));
            finer = finer || corner.finestLevel() < own;
        }
        glm::ivec3 beyond = brick;
        beyond[axis] += face < 3 ? -1 : 1;
        const bool border = beyond[axis] < 0 || beyond[axis] >= selection.bricks[axis];
        const std::uint32_t reach = widest >= 0 ? static_cast<std::uint32_t>(widest) : border ? 7u : 6u;
        facts |= reach << (3 + 3 * face);
        facts |= (finer ? 1u : 0u) << (21 + face);
    }
    return facts;
}

BrickCorner cornerOf(const Selection& selection, const glm::ivec3& at, EdgeFunction function,
                     std::uint32_t finest) {
    BrickCorner corner;
    std::uint32_t low = BrickCorner::kOutside, high = 0;
    bool anyEmpty = false;
    for (int n = 0; n < 8; ++n) {
        const glm::ivec3 brick = at - 1 + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2);
        std::uint32_t code = BrickCorner::kOutside;
        if (glm::all(glm::greaterThanEqual(brick, glm::ivec3(0))) &&
            glm::all(glm::lessThan(brick, selection.bricks)))
            code = selection.levels[linearIndex(brick, selection.bricks)];
        corner.codes |= code << (4 * n);
        if (code == BrickCorner::kEmpty)
            anyEmpty = true;
        else if (code != BrickCorner::kOutside) {
            low = std::min(low, code);
            high = std::max(high, code);
        }
    }
    const bool allEmpty = low == BrickCorner::kOutside;
    if (allEmpty)
        low = high = finest;
    for (int axis = 0; axis < 3; ++axis)
        corner.facts |= reachOf(corner, axis, function, finest) << (4 * axis);
    // Beside empty bricks only the finest level: two of them blend over the finest level's half sample.
    if (low == high && (!anyEmpty || low == finest) && function != EdgeFunction::nearest)
        corner.facts |= BrickCorner::kAgreeBit | low << 13;
    corner.facts |= (allEmpty ? std::uint32_t{kLevelCount} : low) << 16;
    return corner;
}

} // namespace

int mostStride(const Selection& selection, const Quality& quality) {
    if (quality.sampling == Sampling::full || quality.sampling == Sampling::hulls)
        return 0;
    int most = selection.coarsest();
    while (most > 0 && quality.stepVoxels * (1 << most) > kBrickExtent / 2)
        --most;
    return most;
}

LevelMap makeLevelMap(const Selection& selection, const glm::ivec3& extentVoxels, const Quality& quality,
                      MemoryBudget& ram) {
    LevelMap map;
    map.extentVoxels = extentVoxels;
    map.bricks = selection.bricks;
    map.edgeFunction = quality.edgeFunction;
    map.finest = static_cast<std::uint32_t>(selection.finest());
    map.mostStride = mostStride(selection, quality);
    map.charge = ram.charge(LevelMap::bytes(selection.bricks), "the level map");
    map.corners.resize(cellCount(map.cornerGrid()));
    glm::ivec3 at(0);
    std::size_t n = 0;
    for (at.z = 0; at.z <= map.bricks.z; ++at.z)
        for (at.y = 0; at.y <= map.bricks.y; ++at.y)
            for (at.x = 0; at.x <= map.bricks.x; ++at.x)
                map.corners[n++] = cornerOf(selection, at, map.edgeFunction, map.finest);
    map.facts.resize(cellCount(map.bricks));
    n = 0;
    for (at.z = 0; at.z < map.bricks.z; ++at.z)
        for (at.y = 0; at.y < map.bricks.y; ++at.y)
            for (at.x = 0; at.x < map.bricks.x; ++at.x)
                map.facts[n++] = factsOf(map, selection, at);
    return map;
}

} // namespace tessera
