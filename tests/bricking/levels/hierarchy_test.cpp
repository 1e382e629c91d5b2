// tests/bricking/levels/hierarchy_test.cpp: hierarchical selections, for comparison: costs that a hand
// counts, and the printed table.
#include "tests/bench/lod/hierarchy.h"
#include "tests/support/bricking_test_volumes.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using bench::BlockGrid;
using bench::Need;
using test::mixed;

TEST(Hierarchy, CostsWhatAHandCounts) {
    // 8x8 blocks of 8x8 samples: one boundary block in a corner, one interior block in the opposite one.
    BlockGrid grid{2, {8, 8, 1}, 8, std::vector<Need>(64, Need::outside)};
    grid.needs[0] = Need::boundary;
    grid.needs[63] = Need::interior;
    const auto flat = bench::flatCost(grid);
    EXPECT_EQ(flat.samples, 62u + 64u + 4u);
    EXPECT_EQ(flat.ignored, 62u);
    // All children: 3 of depth 1 (one interior, two outside), 3 of depth 2, 4 of depth 3.
    const auto all = bench::hierarchyCost(grid, true);
    EXPECT_EQ(all.levels[0].blocks, 0u);
    EXPECT_EQ(all.levels[1].blocks, 3u);
    EXPECT_EQ(all.levels[2].blocks, 3u);
    EXPECT_EQ(all.levels[3].blocks, 4u);
    EXPECT_EQ(all.samples, 640u);
    EXPECT_EQ(all.ignored, 64u * 8);
    // Partly: the root stays, one node of each depth on the way to the corner, and the interior's.
    const auto part = bench::hierarchyCost(grid, false);
    EXPECT_EQ(part.levels[0].blocks, 1u);
    EXPECT_EQ(part.levels[1].blocks, 2u);
    EXPECT_EQ(part.levels[2].blocks, 1u);
    EXPECT_EQ(part.levels[3].blocks, 1u);
    EXPECT_EQ(part.ignored, 0u);
    EXPECT_EQ(bench::fullSamples(grid), 4096u);
    // If every block is at the boundary all schemes cost the same.
    grid.needs.assign(64, Need::boundary);
    for (const auto& cost :
         {bench::flatCost(grid), bench::hierarchyCost(grid, true), bench::hierarchyCost(grid, false)})
        EXPECT_EQ(cost.samples, 4096u);
}

/// The printed table, all three schemes.
TEST(Hierarchy, Table21) {
    const BlockGrid grid = bench::table21Grid();
    const auto expectBlocks = [](const bench::SelectionCost& cost, std::array<std::size_t, 4> blocks,
                                 std::size_t samples) {
        for (std::size_t level = 0; level < 4; ++level)
            EXPECT_EQ(cost.levels[level].blocks, blocks[level]) << level;
        EXPECT_EQ(cost.samples, samples);
    };
    expectBlocks(bench::hierarchyCost(grid, true), {0, 1, 3, 36}, 2560);
    expectBlocks(bench::hierarchyCost(grid, false), {1, 3, 9, 22}, 2240);
    expectBlocks(bench::flatCost(grid), {38, 4, 0, 22}, 1462);
}

TEST(Hierarchy, FlatNeverNeedsMore) {
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
        const int dimensions = trial % 2 == 0 ? 2 : 3;
        const glm::ivec3 blocks(1 + static_cast<int>(mixed(trial) % 19),
                                1 + static_cast<int>(mixed(trial + 999) % 11),
                                dimensions == 3 ? 1 + static_cast<int>(mixed(trial + 99) % 9) : 1);
        BlockGrid grid{dimensions, blocks, 8, {}};
        for (std::size_t b = 0; b < cellCount(blocks); ++b)
            grid.needs.push_back(static_cast<Need>(mixed(trial * 7919 + b / (1 + trial % 5)) % 3));
        const auto flat = bench::flatCost(grid);
        for (const bool allChildren : {true, false}) {
            const auto tree = bench::hierarchyCost(grid, allChildren);
            EXPECT_LE(flat.samples - flat.ignored, tree.samples - tree.ignored);
        }
    }
}

} // namespace
} // namespace tessera
