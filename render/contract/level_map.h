// render/contract/level_map.h: the level map: a selection's levels as rays meet them. One texel per brick
// corner names the eight bricks around it. The CPU makes it; the mirror and the GPU ray caster read it alike.
#pragma once

#include "core/base/budget.h"
#include "render/contract/brick_corner.h"

#include <vector>

namespace tessera {

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
