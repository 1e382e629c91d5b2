// render/level_map.cpp: see level_map.h.
#include "render/level_map.h"

#include <algorithm>

namespace tessera {
namespace {

/// Reach along an axis: the widest of its four edges, as a level whose half sample it is.
std::uint32_t reachOf(const BrickCorner& corner, int axis, EdgeFunction function, std::uint32_t finest) {
    int widest = -1;
    for (int brick = 0; brick < 8; ++brick) {
        if (brick & (1 << axis))
            continue;
        const std::uint32_t a = corner.code(brick), b = corner.code(brick | (1 << axis));
        if (a == BrickCorner::kOutside || b == BrickCorner::kOutside)
            continue;
        const EdgeReach<double> reach = edgeReach<double>(a, b, function, finest);
        for (const double r : {reach.own, reach.other})
            for (int level = widest + 1; level < kLevelCount; ++level)
                if (r == halfSample<double>(static_cast<std::uint32_t>(level)))
                    widest = level;
    }
    return widest < 0 ? BrickCorner::kNoReach : static_cast<std::uint32_t>(widest);
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
    if (quality.sampling == Sampling::full)
        return 0;
    int most = selection.coarsest();
    while (most > 0 && quality.stepVoxels * (1 << most) > kBrickExtent / 2)
        --most;
    return most;
}

LevelMap makeLevelMap(const Selection& selection, const glm::ivec3& extentVoxels, const Quality& quality,
                      Ledger& ram) {
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
    return map;
}

} // namespace tessera
