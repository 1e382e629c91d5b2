// tests/bricking/levels/selection_test.cpp: the choice of levels: budgets kept as pages cost them, and the
// choice against every possible choice where there are few.
#include "tests/support/bricking_selection_tools.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace tessera {
namespace {

using test::plainWeights;
using test::randomErrors;

double weightedError(const Selection& s, const LevelErrors& e, const ViewWeights& w) {
    double sum = 0;
    for (std::size_t b = 0; b < s.levels.size(); ++b)
        if (s.levels[b] != Selection::kEmpty)
            sum += static_cast<double>(w.area[b]) * static_cast<double>(e.errors[b][s.levels[b]]);
    return sum;
}

/// Few bricks, and more than one task takes.
class SelectBricks : public testing::TestWithParam<glm::ivec3> {};
INSTANTIATE_TEST_SUITE_P(Grids, SelectBricks, testing::Values(glm::ivec3(13, 9, 7), glm::ivec3(23, 21, 19)));

TEST_P(SelectBricks, KeepTheBudgetAndNothingFinerThanAPixelShows) {
    const glm::ivec3 bricks = GetParam();
    const LevelErrors e = randomErrors(bricks, 1);
    const ViewWeights w = plainWeights(bricks, 2);
    const std::vector<float> means(e.shows.size(), 3.5f);
    double last = std::numeric_limits<double>::infinity();
    for (const std::size_t pages : {0, 1, 2, 3, 5, 8, 13, 50, 200, 100000}) {
        const Selection s = selectLevels(e, w, means, pages);
        EXPECT_LE(pagesOf(s), pages);
        std::array<std::size_t, kLevelCount + 1> counts{};
        for (std::size_t b = 0; b < s.levels.size(); ++b) {
            ++counts[s.levels[b]];
            EXPECT_EQ(s.levels[b] == Selection::kEmpty, e.shows[b] == 0);
            EXPECT_GE(s.levels[b], w.finest[b]);
        }
        EXPECT_EQ(counts, s.counts);
        EXPECT_EQ(s.means, means);
        EXPECT_EQ(s.bricks, bricks);
        std::size_t expected = 0;
        for (int level = 0; level < 5; ++level)
            expected += static_cast<std::size_t>(
                std::ceil(static_cast<double>(counts[static_cast<std::size_t>(level)]) / std::pow(8, level)));
        EXPECT_EQ(pagesOf(s), expected);
        EXPECT_LT(weightedError(s, e, w), last) << pages; // every one of these budgets buys something
        last = weightedError(s, e, w);
        for (const int threads : {1, 2, 7})
            EXPECT_EQ(selectLevels(e, w, means, pages, {}, threads).levels, s.levels);
        if (pages == 0) {
            EXPECT_EQ(s.counts[5] + s.counts[6], s.levels.size());
        }
        if (pages == 100000) {
            for (std::size_t b = 0; b < s.levels.size(); ++b)
                EXPECT_EQ(s.levels[b], e.shows[b] ? w.finest[b] : Selection::kEmpty);
        }
    }
}

/// Every combination of levels of five bricks that fits, against the greedy choice.
TEST(SelectLevels, IsCloseToTheBestOfAllChoices) {
    const glm::ivec3 bricks(5, 1, 1);
    double greedy = 0, best = 0, uniformLevel = 0;
    for (std::uint64_t trial = 0; trial < 60; ++trial) {
        const LevelErrors e = randomErrors(bricks, 1000 * trial, false);
        ViewWeights w = plainWeights(bricks, 77 * trial);
        std::fill(w.finest.begin(), w.finest.end(), std::uint8_t{0});
        const std::vector<float> means(5);
        const std::size_t pages = 1 + trial % 4;
        double least = std::numeric_limits<double>::infinity();
        for (int n = 0; n < 7776; ++n) {
            Selection s;
            int rest = n;
            for (int b = 0; b < 5; ++b, rest /= 6) {
                s.levels.push_back(static_cast<std::uint8_t>(rest % 6));
                ++s.counts[static_cast<std::size_t>(rest % 6)];
            }
            if (pagesOf(s) <= pages)
                least = std::min(least, weightedError(s, e, w));
        }
        const double ours = weightedError(selectLevels(e, w, means, pages), e, w);
        EXPECT_GE(ours, least - 1e-9);
        greedy += ours;
        best += least;
        uniformLevel += weightedError(selectUniform(e, means, pages), e, w);
    }
    EXPECT_LT(greedy, 1.05 * best); // five bricks, at most four pages: the hardest case for a greedy choice
    EXPECT_LT(greedy, uniformLevel);
}

TEST(SelectLevels, LeavesOutWhatTheViewAndTheFunctionDoNotNeed) {
    const glm::ivec3 bricks(4, 1, 1);
    LevelErrors e = randomErrors(bricks, 3, false);
    e.errors[2] = {}; // homogeneous: its mean is as good as its voxels
    ViewWeights w = plainWeights(bricks, 4);
    w.area = {100, 0, 100, 100};
    w.finest = {0, 0, 0, 1};
    const std::vector<float> means(4);
    const Selection s = selectLevels(e, w, means, 100);
    EXPECT_EQ(s.levels, (std::vector<std::uint8_t>{0, 5, 5, 1}));
    const std::vector<float> hidden = {0, 1, 1, 1};
    EXPECT_EQ(selectLevels(e, w, means, 100, hidden).levels, (std::vector<std::uint8_t>{5, 5, 5, 1}));
    // All that can be seen, however little it is predicted to matter.
    EXPECT_EQ(selectForError(e, w, means, 0).levels, (std::vector<std::uint8_t>{0, 5, 0, 1}));
}

TEST(SelectForError, MeetsTheErrorAndTakesNoMoreThanItNeeds) {
    const glm::ivec3 bricks(9, 8, 7);
    const LevelErrors e = randomErrors(bricks, 5);
    const ViewWeights w = plainWeights(bricks, 6);
    const std::vector<float> means(e.shows.size());
    std::size_t last = std::numeric_limits<std::size_t>::max();
    for (const double error : {0.0, 0.5, 1.0, 3.0, 8.0, 100.0}) {
        const Selection s = selectForError(e, w, means, error);
        const PredictedError predicted = predictError(s, e, w);
        EXPECT_LE(predicted.p99, error * (1 + 1e-9));
        EXPECT_GE(predicted.p99, error == 1.0 || error == 3.0 ? 0.5 * error : 0); // and uses what it may
        EXPECT_LE(predicted.mean, error);
        EXPECT_LE(pagesOf(s), last);
        last = pagesOf(s);
        if (error == 0.0) {
            EXPECT_EQ(predicted.mean, 0);
        }
    }
    EXPECT_EQ(last, 0u); // an error that every mean meets costs nothing
    const PredictedError coarse = predictError(selectLevels(e, w, means, 0), e, w);
    const PredictedError fine = predictError(selectLevels(e, w, means, 40), e, w);
    EXPECT_LT(fine.mean, coarse.mean);
    EXPECT_LE(fine.p99, coarse.p99);
    EXPECT_GT(coarse.p99, coarse.mean);
}

TEST(PredictError, IsThatOfItsModel) {
    LevelErrors e;
    e.bricks = {2, 1, 1};
    e.shows = {1, 1};
    e.errors = {{0, 1, 1, 1, 1, 2}, {0, 1, 1, 1, 1, 2}};
    ViewWeights w;
    w.area = {30, 10};
    w.finest = {0, 0};
    Selection s;
    s.levels = {5, 0};
    EXPECT_NEAR(predictError(s, e, w).mean, 0.75 * 2, 1e-12);
    EXPECT_NEAR(predictError(s, e, w).p99, 2 * std::log(75.0), 1e-6); // 0.75 exp(-x / 2) = 0.01
    const std::vector<float> visibility = {0.5f, 1.5f};
    EXPECT_NEAR(predictError(s, e, w, visibility).mean, 1, 1e-12);
    w.finest = {1, 0}; // the error of level 1 cannot be seen
    EXPECT_NEAR(predictError(s, e, w).mean, 0.75 * std::sqrt(3.0), 1e-7);
    s.levels = {1, 0};
    EXPECT_EQ(predictError(s, e, w).p99, 0);
}

TEST(SelectUniform, TakesTheFinestLevelThatFits) {
    const LevelErrors e = randomErrors({10, 10, 1}, 7, false);
    const std::vector<float> means(100);
    EXPECT_EQ(selectUniform(e, means, 100).counts[0], 100u);
    EXPECT_EQ(selectUniform(e, means, 99).counts[1], 100u);
    EXPECT_EQ(selectUniform(e, means, 2).counts[2], 100u);
    EXPECT_EQ(selectUniform(e, means, 1).counts[3], 100u);
    EXPECT_EQ(selectUniform(e, means, 0).counts[5], 100u);
}

} // namespace
} // namespace tessera
