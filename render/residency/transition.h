// render/residency/transition.h: the order of moves from the levels that bricks have in the atlas to the
// chosen ones: which brick moves next, and to which level. A pure function, used by
// render/interactive/interactive_renderer.cpp.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// A brick that gets another level.
struct Move {
    std::uint32_t brick = 0;
    std::uint8_t level = 0; // kLevelCount-1: its mean
};

/// Most urgent first:
/// - moves that free memory: bricks that go to their mean (those out of sight), then those that become
///   coarser;
/// - then coarse levels: a brick without samples first gets those of `coarse`, if that is coarser than its
///   goal. So a complete picture comes soon;
/// - then by gain, largest first; bricks of one chunk stay together.
/// @param resident, wanted  levels, [z][y][x] over bricks; the same bricks are empty
/// @param gain  per brick: benefit of a finer level
/// @param coarse  a level; kLevelCount-1: no brick takes a coarse one first
std::vector<Move> movesTo(const Selection& resident, const Selection& wanted, std::span<const float> gain,
                          int coarse);

/// Chunks for moves, each once, in the moves' order; at most `most`.
std::vector<ChunkKey> chunksOf(std::span<const Move> moves, const glm::ivec3& bricks, std::size_t most);

} // namespace tessera
