// tests/render/plan/choose_levels_test.cpp: levels as a picture gets them.
#include "render/plan/choose_levels.h"

#include "bricking/statistics/statistics.h"
#include "core/scene/preset.h"
#include "render/picture/render_scene.h"
#include "render/plan/frame_plan.h"
#include "tests/support/scene_fixture.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;

// A picture so small that some bricks may be coarse without loss. One level for all is chosen if it fits and
// takes few more pages: at most a quarter more, or at most one for every hundred rays that are seen in
// bricks. Otherwise the mix is chosen; no error is predicted for either.
TEST(BestLevels, AreOneLevelWhereAMixGainsNothing) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const StoreReader store(storePath("torso"), ram);
    const VolumeInfo& info = store.info();
    const Statistics statistics = loadStatistics(store, ram, 0);
    const TransferTable table = makeTable(presetFunction("bone-1", summarise(statistics, info)));
    LevelChooser chooser(store, ram, 0);
    chooser.setFunction(statistics, table, Culling::unlit);
    std::size_t mixes = 0, kept = 0, forRays = 0;
    for (const int edge : {6, 8, 10, 12, 16, 24, 32, 40, 48}) {
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
        double rays = 0;
        for (std::size_t b = 0; b < mix.levels.size(); ++b)
            if (mix.levels[b] != Selection::kEmpty)
                rays += static_cast<double>(chooser.weights().area[b]) * static_cast<double>(visible[b]);
        const bool few = 4 * (all - pages) <= pages;
        const bool gains = 100 * static_cast<double>(all - pages) <= rays;
        EXPECT_EQ(best.selection.uniform(), mix.uniform() || few || gains) << edge;
        kept += !best.selection.uniform();
        forRays += !mix.uniform() && gains && !few;
        if (mix.uniform() || all == pages)
            continue;
        ++mixes;
        // With no page to spare it stays as it is.
        EXPECT_EQ(bestLevels(chooser, statistics.brickMean, all - 1, visible).selection.levels, mix.levels);
    }
    EXPECT_GT(mixes, 1u);
    EXPECT_GT(kept, 0u);
    EXPECT_GT(forRays, 0u);
}

// With a largest allowed error, whatever the budget, the finest level for all is chosen on two conditions.
// Its strides take less time than those of a sufficient mix, and loading its bricks costs no more than that
// gains.
TEST(LevelsWithin, AreTheFinestWhereThatIsDrawnSooner) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const StoreReader store(storePath("torso"), ram);
    const auto levelsOf = [&](double maxError, int edge, std::size_t gpuBytes) {
        Scene scene = sceneOn(store.info(), "bone-1", 0, glm::ivec2(edge));
        scene.quality.maxError = maxError;
        MemoryBudget gpu("GPU memory", "--gpu-memory", gpuBytes), own("RAM", "--ram", std::size_t{512} << 20);
        RenderOptions options;
        options.engine = EngineKind::native;
        return renderScene(scene, store, own, gpu, options);
    };
    constexpr std::size_t kAmple = std::size_t{1} << 30, kTight = std::size_t{2} << 20;
    for (const std::size_t budget : {kAmple, kTight}) {
        const RenderResult exact = levelsOf(12, 96, budget);
        EXPECT_EQ(exact.bricksOfLevel[0], exact.residentBricks);
        EXPECT_GT(exact.residentBricks, 20u);
        EXPECT_EQ(exact.passes > 1, budget == kTight);
        ASSERT_TRUE(exact.predictedError);
        EXPECT_EQ(exact.predictedError->mean, 0);
    }
    const RenderResult rough = levelsOf(110, 96, kAmple);
    EXPECT_GT(rough.bricksOfLevel[0], 0u);
    EXPECT_LT(rough.bricksOfLevel[0], rough.residentBricks) << "far fewer strides";
    const RenderResult small = levelsOf(12, 12, kAmple);
    EXPECT_LT(small.bricksOfLevel[0], small.residentBricks) << "few rays";
}

// Coarse samples reach further than a brick's neighbour: then bricks beside the picture are read.
TEST(LevelsWithin, LeaveNothingOutWhereSamplesReachFar) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const StoreReader store(storePath("sphere"), ram);
    const glm::ivec2 size(12);
    Scene scene = sceneOn(store.info(), "auto", 0, size);
    Camera camera = fitCamera(store.info(), View::anterior, Projection::parallel, size);
    camera.parallelScale *= 0.1;
    scene.camera = camera;
    RenderOptions options;
    options.engine = EngineKind::native;
    int coarse = 0, fine = 0;
    for (const double maxError : {0.0, 1.0, 12.0, 100.0, 200.0}) {
        scene.quality.maxError = maxError;
        Budgets budgets;
        const RenderResult r = renderScene(scene, store, budgets.ram, budgets.gpu, options);
        if (r.level > 2) {
            ++coarse;
            EXPECT_EQ(r.unseenBricks, 0u) << maxError;
        } else {
            fine += r.unseenBricks > 0;
        }
    }
    EXPECT_GT(coarse, 0);
    EXPECT_GT(fine, 0);
}

// A camera close to the volume: bricks that no ray comes near are left out, those that are left are of one
// level, and no pixel shows it.
TEST(BestLevels, LeaveOutWhatNoRayComesNear) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20);
    const StoreReader store(storePath("torso"), ram);
    const VolumeInfo& info = store.info();
    Scene scene = sceneOn(info, "soft-tissue", 0, glm::ivec2(48));
    Camera camera = fitCamera(info, View::anterior, Projection::perspective, glm::ivec2(48));
    camera.position = camera.focalPoint + 0.15 * (camera.position - camera.focalPoint);
    scene.camera = camera;
    scene.shading.on = true;
    for (const EngineKind engine : {EngineKind::native, EngineKind::mirror}) {
        RenderOptions options;
        options.engine = engine;
        Budgets mine, all;
        const RenderResult close = renderScene(scene, store, mine.ram, mine.gpu, options);
        options.levels = LevelChoice::oneForAll;
        const RenderResult whole = renderScene(scene, store, all.ram, all.gpu, options);
        EXPECT_GT(close.unseenBricks, 4u);
        EXPECT_EQ(close.bricksOfLevel[0], close.residentBricks) << "one level";
        EXPECT_EQ(close.residentBricks + close.unseenBricks, whole.residentBricks);
        EXPECT_EQ(close.emptyBricks, whole.emptyBricks);
        EXPECT_EQ(close.image.pixels, whole.image.pixels);
    }
    scene.quality.maxError = 12;
    RenderOptions options;
    options.engine = EngineKind::native;
    Budgets budgets;
    const RenderResult within = renderScene(scene, store, budgets.ram, budgets.gpu, options);
    EXPECT_GT(within.unseenBricks, 4u);
    EXPECT_EQ(within.bricksOfLevel[0], within.residentBricks);
}

} // namespace
} // namespace tessera
