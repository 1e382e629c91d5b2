// tests/render/residency/transition_test.cpp: in which order bricks move to the levels that were chosen for
// them.
#include "render/residency/transition.h"

#include <array>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

namespace tessera {
namespace {

constexpr std::uint8_t kMean = kLevelCount - 1, kNoLevel = Selection::kEmpty;

/// Bricks in a row of chunks of their own at level 0; two share a chunk at level 1, four at level 2.
Selection row(std::vector<std::uint8_t> levels) {
    Selection s;
    s.bricks = {static_cast<int>(levels.size()), 1, 1};
    s.levels = std::move(levels);
    return s;
}
using Moves = std::vector<std::pair<std::uint32_t, int>>;
Moves moves(const Selection& from, const Selection& to, const std::vector<float>& gain, int coarse) {
    Moves out;
    for (const Move& m : movesTo(from, to, gain, coarse))
        out.emplace_back(m.brick, m.level);
    return out;
}

TEST(Moves, WhatGivesRoomBackGoesFirstThenCoarseLevelsThenTheMostGain) {
    const Selection from = row({0, kMean, 1, 0, kNoLevel, kMean, 2, 2, 3});
    const Selection to = row({2, 0, kMean, 0, kNoLevel, 3, 0, 1, 1});
    const std::vector<float> gain = {0, 9, 0, 0, 0, 8, 1, 5, 3};
    // To the mean; coarser; the coarse level of 1, which its own is finer than; 5 wants a coarser one than
    // that, so goes straight; then by gain.
    EXPECT_EQ(moves(from, to, gain, 2), (Moves{{2, kMean}, {0, 2}, {1, 2}, {5, 3}, {7, 1}, {8, 1}, {6, 0}}));
}

TEST(Moves, BricksOfOneChunkStayTogether) {
    const Selection from = row({2, 2, 2, 2}), to = row({1, 1, 1, 1});
    EXPECT_EQ(moves(from, to, {1, 7, 6, 5}, 3), (Moves{{0, 1}, {1, 1}, {2, 1}, {3, 1}}));
    EXPECT_EQ(moves(from, to, {1, 2, 6, 5}, 3), (Moves{{2, 1}, {3, 1}, {0, 1}, {1, 1}}));
    const std::vector<Move> all = movesTo(from, to, std::vector<float>{1, 2, 6, 5}, 3);
    const std::vector<ChunkKey> chunks = chunksOf(all, from.bricks, 10);
    ASSERT_EQ(chunks.size(), 2u);
    EXPECT_EQ(chunks[0], (ChunkKey{1, 1, 0, 0}));
    EXPECT_EQ(chunks[1], (ChunkKey{1, 0, 0, 0}));
    EXPECT_EQ(chunksOf(all, from.bricks, 1).size(), 1u);
}

// As after packing anew: a brick that has no samples takes its own level at once, or it would never come.
TEST(Moves, WithoutACoarseLevelBricksGoStraight) {
    const Selection from = row({kMean, kMean, kNoLevel, kMean}), to = row({0, 4, kNoLevel, 2});
    EXPECT_EQ(moves(from, to, {3, 2, 0, 1}, kMean), (Moves{{0, 0}, {1, 4}, {3, 2}}));
    EXPECT_TRUE(moves(to, to, {3, 2, 0, 1}, kMean).empty());
}

} // namespace
} // namespace tessera
