// tests/bricking/levels/choice_test.cpp: the parts of a choice of levels: culling under either sign of the
// rescale slope and with either number of layers, and one level within a budget. Also the chooser, which has
// to pass on losses by filtering and occlusion.
#include "bricking/levels/level_chooser.h"
#include "tests/support/bricking_selection_tools.h"
#include "tests/support/recorded_numbers.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using test::unitInfo;
using test::whiteAbove150;

/// Of four bricks in a row with the given values; each sees its neighbours' in its second layer only.
Statistics statisticsOf(const std::vector<float>& values) {
    Statistics s;
    s.bricks = {static_cast<int>(values.size()), 1, 1};
    s.brickMean = s.brickMin = s.brickMax = s.wideMin = s.wideMax = values;
    for (std::size_t i = 0; i < values.size(); ++i)
        for (const std::size_t beside : {i - 1, i + 1})
            if (beside < values.size()) {
                s.wideMin[i] = std::min(s.wideMin[i], values[beside]);
                s.wideMax[i] = std::max(s.wideMax[i], values[beside]);
            }
    return s;
}

std::vector<int> shown(const Selection& s) {
    std::vector<int> out;
    for (const std::uint8_t level : s.levels)
        out.push_back(level == Selection::kEmpty ? 0 : 1);
    return out;
}

TEST(CullBricks, LitOnesShowByTwoLayersUnlitByOne) {
    const Statistics statistics = statisticsOf({0, 0, 200, 0});
    const VolumeInfo info = unitInfo({128, 32, 32});
    const TransferTable table = whiteAbove150(1);
    EXPECT_EQ(shown(cullBricks(statistics, table, info, 0, Culling::unlit)), (std::vector<int>{0, 0, 1, 0}));
    EXPECT_EQ(shown(cullBricks(statistics, table, info, 0, Culling::lit)), (std::vector<int>{0, 1, 1, 1}));
    EXPECT_EQ(shown(cullBricks(statistics, table, info, 0, Culling::none)), (std::vector<int>{1, 1, 1, 1}));
}

// A brick from 100 to 255 as stored is 155 to 0: it reaches what shows with one of its ends.
TEST(CullBricks, ANegativeSlopeTurnsTheRangeOver) {
    Statistics statistics = statisticsOf({100, 200, 200, 200});
    statistics.brickMax[0] = 255;
    VolumeInfo info = unitInfo({128, 32, 32});
    info.rescaleSlope = -1;
    info.rescaleIntercept = 255;
    statistics.brickMin[3] = 50; // 205 to 202, a few of the table's entries
    statistics.brickMax[3] = 53;
    EXPECT_EQ(shown(cullBricks(statistics, whiteAbove150(1), info, 0, Culling::unlit)),
              (std::vector<int>{1, 0, 0, 1}));
}

TEST(SelectOneLevel, LeavesRoomForWhatTheSceneTakesBesides) {
    const Statistics statistics = statisticsOf({200, 200, 200, 0});
    const PackedBytes packed =
        [](const auto& counts) { // 32 KiB a brick, an eighth of it for each level coarser
            std::size_t bytes = 0, one = 1 << 15;
            for (std::size_t level = 0; level < kLevelCount; ++level, one /= 8)
                bytes += counts[level] * one;
            return bytes;
        };
    const auto levelWithin = [&](std::size_t available, std::size_t fixed) {
        const Selection s = selectOneLevel(statistics, whiteAbove150(1), unitInfo({128, 32, 32}), available,
                                           packed, Culling::unlit, "--gpu-memory", fixed);
        EXPECT_EQ(s.counts[Selection::kEmpty], 1u);
        return s.finest();
    };
    const std::size_t whole = 3 << 15;
    EXPECT_EQ(levelWithin(whole, 0), 0);
    EXPECT_EQ(levelWithin(whole, 1), 1);
    EXPECT_EQ(levelWithin(whole + 1, 1), 0);
    EXPECT_EQ(levelWithin(whole / 8 - 1, 0), 2);
    EXPECT_THROW(levelWithin(100, 101), InputError);
}

class Chooser : public ::testing::Test {
  protected:
    /// A white sheet, one voxel thin, in every second brick: averaging loses it.
    static constexpr glm::ivec3 kExtent{96, 64, 64};
    Chooser() {
        test::HashSource source(unitInfo(kExtent),
                                [](int x, int, int z) { return x % 64 == 13 || z == 40 ? 255.0 : 0.0; });
        ImportOptions options;
        options.durable = false;
        importToStore(source, scratch_ / "v.zarr", ram_, options);
    }
    ScratchFolder scratch_;
    MemoryBudget ram_{"RAM", "--ram", std::size_t{256} << 20};
};

TEST_F(Chooser, IsItsPartsPutTogether) {
    const StoreReader store(scratch_ / "v.zarr", ram_);
    const Statistics statistics = loadStatistics(store, ram_, 1);
    const TransferTable table = whiteAbove150(2);
    const glm::ivec2 size(40, 30);
    const Camera camera = fitCamera(store.info(), View::left, Projection::perspective, size);
    LevelChooser chooser(store, ram_, 1);
    chooser.setFunction(statistics, table, Culling::unlit);
    chooser.setCamera(camera, size);

    ViewWeights weights = viewWeights(camera, store.info(), size, 1, chooser.shows());
    const ViewWeights before = weights;
    limitPrefilterLoss(chooser.errors(), weights);
    ASSERT_NE(weights.finest, before.finest) << "a scene without anything to lose proves nothing";
    EXPECT_EQ(chooser.weights().finest, weights.finest);
    EXPECT_EQ(chooser.weights().area, weights.area);

    const std::vector<float> visibility = chooser.predictedVisibility();
    const std::vector<float>& means = statistics.brickMean;
    bool matters = false;
    for (const std::size_t pages : {1u, 2u, 4u}) {
        const Selection best = chooser.best(means, pages, visibility);
        EXPECT_EQ(best.levels, selectLevels(chooser.errors(), weights, means, pages, visibility).levels);
        matters = matters || best.levels != chooser.best(means, pages).levels;
        EXPECT_EQ(chooser.predict(best, visibility).p99,
                  predictError(best, chooser.errors(), weights, visibility).p99);
    }
    EXPECT_TRUE(matters) << "a scene in which nothing is hidden proves nothing";
}

/// Labels leave a share of the function's errors, and add those of their borders, of which three tenths stay
/// where a pixel averages them. Their own medium takes light, too.
TEST_F(Chooser, KnowsWhatLabelsLeave) {
    const StoreReader store(scratch_ / "v.zarr", ram_);
    Statistics statistics = loadStatistics(store, ram_, 1);
    const TransferTable table = whiteAbove150(0.05);
    LevelChooser chooser(store, ram_, 1);
    chooser.setFunction(statistics, table, Culling::unlit);
    const LevelErrors plain = chooser.errors();
    statistics.labelledBricks.resize(plain.shows.size());
    for (std::size_t b = 0; b < plain.shows.size(); ++b) {
        const float part = static_cast<float>(b + 1) / static_cast<float>(plain.shows.size());
        statistics.labelledBricks[b] = {part, b == 0 ? 1.5f : 0.3f * part, 0.5f * (1 - part)};
    }
    chooser.setFunction(statistics, table, Culling::unlit);
    const double ofBorders[] = {0, 17, 28, 40, 55, 80}; // level_chooser.cpp says where they were measured
    ASSERT_GT(std::count(plain.shows.begin(), plain.shows.end(), 1), 4);
    for (std::size_t b = 0; b < plain.shows.size(); ++b) {
        const Statistics::LabelledBrick& of = statistics.labelledBricks[b];
        const bool shows = plain.shows[b] != 0;
        const double function = shows ? static_cast<double>(of.function) : 1,
                     borders = shows ? static_cast<double>(of.borders) : 0;
        for (std::size_t level = 0; level < kLevelCount; ++level) {
            const double border = borders * ofBorders[level];
            EXPECT_NEAR(chooser.errors().errors[b][level],
                        function * static_cast<double>(plain.errors[b][level]) + border, 1e-4)
                << b << " " << level;
            EXPECT_NEAR(chooser.errors().biases[b][level],
                        function * static_cast<double>(plain.biases[b][level]) + 0.3 * border, 1e-4)
                << b << " " << level;
        }
        const double through = std::pow(static_cast<double>(plain.transmittances[b]), function) *
                               (shows ? 1 - std::min(1.0, static_cast<double>(of.medium)) : 1);
        EXPECT_NEAR(chooser.errors().transmittances[b], through, 1e-5) << b;
    }
}

/// Finer levels than a pixel shows may be allowed, for bricks that are in the picture.
TEST_F(Chooser, AllowsFinerLevels) {
    const StoreReader store(scratch_ / "v.zarr", ram_);
    const Statistics statistics = loadStatistics(store, ram_, 1);
    LevelChooser chooser(store, ram_, 1);
    chooser.setFunction(statistics, whiteAbove150(0.0001), Culling::none);
    Camera camera = fitCamera(store.info(), View::left, Projection::perspective, {40, 30});
    camera.viewAngle = 60;
    chooser.setCamera(camera, {4, 3});
    const ViewWeights before = chooser.weights();
    chooser.allowSubpixelLevels(1);
    bool changes = false;
    for (std::size_t b = 0; b < before.area.size(); ++b) {
        const int finest = before.area[b] > 0 ? std::max(0, before.finest[b] - 1) : before.finest[b];
        EXPECT_EQ(chooser.weights().finest[b], finest) << b;
        changes = changes || finest != before.finest[b];
    }
    EXPECT_TRUE(changes);
    chooser.allowSubpixelLevels(9);
    for (std::size_t b = 0; b < before.area.size(); ++b)
        if (before.area[b] > 0) {
            EXPECT_EQ(chooser.weights().finest[b], 0);
        }
}

/// Memory that is promised for prediction and choice.
TEST(Chosen, BytesAreThoseOfTheRecord) {
    test::RecordedNumbers record("tests/bricking/levels/recorded/bytes.txt");
    for (const std::size_t bricks : {1u, 1000u, 70000u})
        record.expect("bytes",
                      {static_cast<double>(predictErrorsBytes(bricks)),
                       static_cast<double>(selectLevelsBytes(bricks)),
                       static_cast<double>(LevelChooser::bytes(bricks / 3, bricks))},
                      0, 0.5);
}

} // namespace
} // namespace tessera
