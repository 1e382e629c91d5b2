// tests/bench/lod/hierarchy.h: table 2.1 of the course notes again: what flat and hierarchical
// multiresolution selections cost under the same criterion. In 2 and in 3 dimensions.
//
// The notes number levels from the coarsest. A block of the grid needs level `top` (all its samples) where an
// object's boundary crosses it. In the interior it needs level 1 (two samples an edge), outside level 0. In a
// hierarchy a node of depth d covers 2^(top-d) blocks an edge with as many samples as one block.
// - Flat: every block stores the samples of its own need.
// - Hierarchy 1: a node whose blocks need more is replaced by all its children.
// - Hierarchy 2: a node gets only the children whose blocks need more, and goes when it has got all of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera::bench {

enum class Need : std::uint8_t { outside, interior, boundary };

struct BlockGrid {
    int dimensions = 3;
    glm::ivec3 blocks{1};    // z is 1 in two dimensions
    int blockExtent = 8;     // samples an edge at the finest level: a power of two
    std::vector<Need> needs; // [z][y][x]
};

struct LevelCost {
    std::size_t blocks = 0, samples = 0;
};
struct SelectionCost {
    std::vector<LevelCost> levels; // as the notes number them: 0 coarsest
    std::size_t samples = 0;       // of all levels
    std::size_t ignored = 0;       // of these, samples that stand for nothing but the outside
};

SelectionCost flatCost(const BlockGrid& grid);
SelectionCost hierarchyCost(const BlockGrid& grid, bool allChildren);
/// Samples of the data at full resolution.
std::size_t fullSamples(const BlockGrid& grid);

/// The needs of an object: a block is boundary where some but not all of its samples are inside.
/// @param inside  of the sample at a position, in samples
BlockGrid gridOfShape(int dimensions, const glm::ivec3& blocks, int blockExtent,
                      const std::function<bool(const glm::ivec3&)>& inside);

/// A shape with the counts of table 2.1: 22 blocks at the boundary, 4 inside, 38 outside, one quarter of the
/// picture empty and one node of every other quarter. (The figure itself is not in the text of the notes.)
BlockGrid table21Grid();

} // namespace tessera::bench
