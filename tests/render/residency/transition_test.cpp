// tests/render/residency/transition_test.cpp: in which order bricks move to the levels that were chosen for
// them.
#include "render/residency/transition.h"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <random>
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

// However many bricks a chunk holds, it is read once, when its first brick moves; means need none.
TEST(Moves, ChunksAreNamedOnceInTheOrderOfMoves) {
    const glm::ivec3 bricks(8, 1, 1);
    const std::vector<Move> all = {{6, 2}, {0, 1}, {3, kMean}, {4, 2}, {1, 1},
                                   {5, 2}, {2, 0}, {7, 2},     {3, 1}};
    const std::vector<ChunkKey> expected = {{2, 1, 0, 0}, {1, 0, 0, 0}, {0, 2, 0, 0}, {1, 1, 0, 0}};
    for (std::size_t most = 0; most <= 6; ++most) {
        const std::vector<ChunkKey> chunks = chunksOf(all, bricks, most);
        ASSERT_EQ(chunks.size(), std::min<std::size_t>(most, 4));
        EXPECT_TRUE(std::equal(chunks.begin(), chunks.end(), expected.begin())) << most;
    }
}

// Any two selections: every brick that changes moves once and comes to its level, or to the coarse one
// before.
TEST(Moves, BringEveryBrickToItsLevel) {
    std::mt19937 random(7);
    for (int turn = 0; turn < 200; ++turn) {
        std::vector<std::uint8_t> from, to;
        std::vector<float> gain;
        for (int b = 0; b < 40; ++b) {
            const bool empty = random() % 5 == 0;
            from.push_back(empty ? kNoLevel : static_cast<std::uint8_t>(random() % kLevelCount));
            to.push_back(empty ? kNoLevel : static_cast<std::uint8_t>(random() % kLevelCount));
            gain.push_back(static_cast<float>(random() % 10));
        }
        const int coarse = 1 + static_cast<int>(random() % kMean);
        std::vector<int> moved(40, 0);
        int phase = 0;
        for (const auto& [brick, level] : moves(row(from), row(to), gain, coarse)) {
            ++moved[brick];
            const int was = from[brick], goal = to[brick];
            const bool first = was == kMean && goal < coarse && coarse < kMean;
            EXPECT_EQ(level, first ? coarse : goal);
            const int mine = level == kMean ? 0 : level > was ? 1 : first ? 2 : 3;
            EXPECT_GE(mine, phase) << "what frees memory is first, then coarse levels";
            phase = mine;
        }
        for (std::size_t b = 0; b < 40; ++b)
            EXPECT_EQ(moved[b], from[b] != to[b]) << b;
    }
}

// As after packing anew: a brick that has no samples takes its own level at once, or it would never come.
TEST(Moves, WithoutACoarseLevelBricksGoStraight) {
    const Selection from = row({kMean, kMean, kNoLevel, kMean}), to = row({0, 4, kNoLevel, 2});
    EXPECT_EQ(moves(from, to, {3, 2, 0, 1}, kMean), (Moves{{0, 0}, {1, 4}, {3, 2}}));
    EXPECT_TRUE(moves(to, to, {3, 2, 0, 1}, kMean).empty());
}

} // namespace
} // namespace tessera
