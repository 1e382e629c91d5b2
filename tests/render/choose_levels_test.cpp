// tests/render/choose_levels_test.cpp: levels as a picture gets them.
#include "render/plan/choose_levels.h"

#include "bricking/statistics/statistics.h"
#include "core/preset.h"
#include "render/plan/scene_plan.h"
#include "tests/support/scene_fixture.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;

// A picture so small that some bricks may be coarse without a loss: one level for all where that fits and
// takes at most a quarter more pages, else the mix; and no error is predicted for either.
TEST(BestLevels, AreOneLevelWhereAMixGainsNothing) {
    Ledger ram("RAM", "--ram", std::size_t{512} << 20);
    const StoreReader store(storePath("torso"), ram);
    const VolumeInfo& info = store.info();
    const Statistics statistics = loadStatistics(store, ram, 0);
    const TransferTable table = makeTable(presetFunction("bone", summarise(statistics, info)));
    LevelChooser chooser(store, ram, 0);
    chooser.setFunction(statistics, table, Culling::unlit);
    std::size_t mixes = 0;
    for (const int edge : {12, 16, 24, 32, 40, 48}) {
        chooser.setCamera(fitCamera(info, View::anterior, Projection::perspective, glm::ivec2(edge)),
                          glm::ivec2(edge));
        const std::vector<float> visible = chooser.predictedVisibility();
        const Selection mix = chooser.best(statistics.brickMean, 4096, visible);
        ASSERT_EQ(chooser.predict(mix, visible).mean, 0);
        const std::size_t pages = pagesFor(mix.counts);
        std::array<std::size_t, kLevelCount + 1> counts{};
        counts[static_cast<std::size_t>(mix.finest())] = mix.shownBricks();
        const std::size_t all = pagesFor(counts);
        const BestLevels best = bestLevels(chooser, statistics.brickMean, 4096, visible);
        EXPECT_EQ(best.error.mean, 0);
        EXPECT_EQ(best.selection.finest(), mix.finest());
        EXPECT_EQ(best.selection.shownBricks(), mix.shownBricks());
        EXPECT_EQ(best.selection.uniform(), mix.uniform() || 4 * (all - pages) <= pages) << edge;
        if (mix.uniform() || all == pages)
            continue;
        ++mixes;
        // With no page to spare it stays as it is.
        EXPECT_EQ(bestLevels(chooser, statistics.brickMean, all - 1, visible).selection.levels, mix.levels);
    }
    EXPECT_GT(mixes, 1u);
}

} // namespace
} // namespace tessera
