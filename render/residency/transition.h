// render/residency/transition.h: the order of moves from the levels that bricks have in the atlas to the
// chosen ones: which brick moves next, and to which level. A pure function;
// render/interactive/interactive_renderer.cpp walks it.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// A brick that is to have another level.
struct Move {
    std::uint32_t brick = 0;
    std::uint8_t level = 0; // kLevelCount-1: its mean
};

/// Most urgent first:
/// - what gives room back: bricks that go to their mean (those out of sight do), then those that become
///   coarser;
/// - then coarse levels: a brick that has no samples yet first gets those of `coarse`, if that is coarser
///   than its goal. So a whole picture is there soon;
/// - then by gain, most first; bricks of one chunk stay together.
/// @param resident, wanted  levels, [z][y][x] over bricks; the same bricks are empty
/// @param gain  per brick: what is won by making it finer
/// @param coarse  a level; kLevelCount-1: no brick takes a coarse one first
std::vector<Move> movesTo(const Selection& resident, const Selection& wanted, std::span<const float> gain,
                          int coarse);

/// Chunks that moves need, each once, in the moves' order; at most `most`.
std::vector<ChunkKey> chunksOf(std::span<const Move> moves, const glm::ivec3& bricks, std::size_t most);

} // namespace tessera
