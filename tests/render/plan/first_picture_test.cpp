// tests/render/plan/first_picture_test.cpp: what a first picture is planned by: bounds of a volume's cells
// from its bricks, and a coarser level as a volume. The picture itself is the same with it and without.
#include "bricking/cache/level_source.h"
#include "bricking/import/importer.h"
#include "bricking/statistics/coarse_statistics.h"
#include "core/base/program_folders.h"
#include "core/image/image.h"
#include "render/interactive/interactive_renderer.h"
#include "render/picture/render_scene.h"
#include "render/plan/planner.h"
#include "render/plan/quick_level.h"
#include "tests/support/formula_source.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <span>
#include <vector>

namespace tessera::test {
namespace {

const glm::ivec3 kLong(170, 60, 75); // level 1 is the quick one

/// A ball in noise that is not seen.
struct Ball {
    Ball() {
        VolumeInfo info;
        info.extentVoxels = kLong;
        info.type = ValueType::f32;
        info.patientFromVoxel = patientFromVoxelOf({3, -8, 20}, {0.8, 0, 0}, {0, 0.9, 0.2}, {0, 0, 1.7});
        FormulaSource source(info, [](const glm::dvec3& p) {
            const double noise = std::sin(p.x * 12.9898 + p.y * 78.233 + p.z * 37.719) * 43758.5453;
            return 300 - 10 * glm::length(p - glm::dvec3(110, 30, 40)) + 20 * (noise - std::floor(noise));
        });
        ImportOptions options;
        options.durable = false;
        importToStore(source, folder / "ball.zarr", ram, options);
        store = std::make_unique<StoreReader>(folder / "ball.zarr", ram);
        scene.volumes.resize(1);
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{60, 0}, {120, 0.5}}, {});
        scene.imageSize = {90, 70};
        scene.quality.pixels.samples = 1;
    }
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20}, gpu{"GPU memory", "--gpu-memory", 64 << 20};
    ScratchFolder folder;
    std::unique_ptr<StoreReader> store;
    Scene scene;
};

TEST(FirstPictures, BricksBoundTheirCells) {
    Ball ball;
    const Statistics all = loadStatistics(*ball.store, ball.ram, 2);
    const auto coarse = loadCoarseStatistics(*ball.store, ball.ram, 2);
    ASSERT_TRUE(coarse);
    EXPECT_EQ(coarse->histogram, all.histogram);
    EXPECT_EQ(coarse->brickMean, all.brickMean);
    EXPECT_EQ(coarse->wideMin, all.wideMin);
    EXPECT_EQ(coarse->wideMax, all.wideMax);
    EXPECT_EQ(std::pair(coarse->lowest, coarse->highest), std::pair(all.lowest, all.highest));
    const auto bounds = [](const std::vector<float>& low, const std::vector<float>& high,
                           const std::vector<float>& inLow, const std::vector<float>& inHigh) {
        ASSERT_EQ(low.size(), inLow.size());
        for (std::size_t i = 0; i < low.size(); ++i)
            EXPECT_TRUE(low[i] <= inLow[i] && inHigh[i] <= high[i]) << i;
    };
    bounds(coarse->cellMin, coarse->cellMax, all.cellMin, all.cellMax);
    bounds(coarse->brickMin, coarse->brickMax, all.brickMin, all.brickMax);
    // They are no wider than their brick's.
    EXPECT_EQ(*std::min_element(coarse->cellMin.begin(), coarse->cellMin.end()), all.lowest);
    std::size_t narrow = 0;
    for (std::size_t i = 0; i < coarse->cellMin.size(); ++i)
        narrow += coarse->cellMax[i] - coarse->cellMin[i] < 0.8f * (all.highest - all.lowest);
    EXPECT_GT(narrow, coarse->cellMin.size() / 2);
}

TEST(FirstPictures, ALevelIsAVolume) {
    Ball ball;
    const auto coarse = loadCoarseStatistics(*ball.store, ball.ram, 1);
    ASSERT_TRUE(coarse);
    const VolumeInfo& info = ball.store->info();
    for (int level = 0; level < kLevelCount; ++level) {
        const LevelSource source(*ball.store, level);
        const glm::ivec3 extent = source.info().extentVoxels;
        EXPECT_EQ(extent, levelExtent(kLong, level));
        // A sample's middle is that of the voxels below it.
        const glm::dvec4 middle = source.info().patientFromVoxel * glm::dvec4(2.5, 1.5, 0.5, 1),
                         below = info.patientFromVoxel *
                                 glm::dvec4(glm::dvec3(2.5, 1.5, 0.5) * std::exp2(level), 1);
        EXPECT_LT(glm::distance(middle, below), 1e-9);
        const Statistics bounds = boundsOfLevel(*coarse, info, level, ball.ram, 2);
        ASSERT_EQ(bounds.cells, cellGrid(extent));
        std::vector<std::byte> chunk(source.chunkBytes()), same(chunk.size());
        const glm::ivec3 grid = chunkGrid(extent, 0);
        for (std::size_t c = 0; c < cellCount(grid); ++c) {
            const glm::ivec3 at = gridPosition(c, grid);
            source.readChunk({0, at.x, at.y, at.z}, chunk);
            ball.store->readChunk({level, at.x, at.y, at.z}, same);
            EXPECT_EQ(std::memcmp(chunk.data(), same.data(), chunk.size()), 0);
            for (std::size_t i = 0; i < cellCount(glm::ivec3(kChunkExtent)); ++i) {
                const glm::ivec3 sample = at * kChunkExtent + gridPosition(i, glm::ivec3(kChunkExtent));
                if (glm::any(glm::greaterThanEqual(sample, extent)))
                    continue;
                float value = 0;
                std::memcpy(&value, chunk.data() + i * sizeof value, sizeof value);
                // Of its cell, and of those whose ghost layer has it.
                const glm::ivec3 low = glm::max(sample - 1, glm::ivec3(0)) / kCellExtent,
                                 high = glm::min(sample + 1, extent - 1) / kCellExtent;
                for (const glm::ivec3& cell : {low, high}) {
                    const std::size_t n = linearIndex(cell, bounds.cells);
                    ASSERT_TRUE(bounds.cellMin[n] <= value && value <= bounds.cellMax[n]) << level;
                }
            }
        }
    }
}

TEST(FirstPictures, AreFramedAsTheirPictures) {
    Ball ball;
    ASSERT_EQ(quickLevel(kLong), 1);
    for (const Projection projection : {Projection::perspective, Projection::parallel}) {
        FittedView view;
        view.projection = projection;
        ball.scene.camera = view;
        const FrameContext context(ball.ram, ball.gpu, 2);
        const auto cameraOf = [&](LevelChoice choice, bool isCoarse) {
            const Planner p = planScene(ball.scene, *ball.store, TextureLimits{}, context, choice);
            EXPECT_EQ(p.isCoarse, isCoarse);
            return p.view.camera;
        };
        const Camera coarse = cameraOf(LevelChoice::quick, true),
                     fine = cameraOf(LevelChoice::perBrick, false);
        const double far = glm::distance(fine.position, fine.focalPoint);
        EXPECT_LT(glm::distance(coarse.focalPoint, fine.focalPoint), 0.03 * far);
        EXPECT_NEAR(coarse.parallelScale, fine.parallelScale, 0.05 * fine.parallelScale);
        EXPECT_NEAR(glm::distance(coarse.position, coarse.focalPoint), far, 0.05 * far);
    }
}

TEST(FirstPictures, InteractiveOnesHaveTheCoarseLevel) {
    Ball ball;
    RenderOptions native;
    native.engine = EngineKind::native;
    native.threads = 2;
    for (const bool isCoarse : {true, false}) {
        const auto engine = makeEngine(native, ball.ram, ball.gpu);
        InteractiveOptions options;
        options.threads = 2;
        options.coarse = isCoarse;
        InteractiveRenderer renderer(ball.scene, *ball.store, *engine, ball.ram, ball.gpu, options);
        EXPECT_EQ(renderer.isCoarse(), isCoarse);
        InteractiveRenderer::Progress progress;
        for (int turn = 0; turn < 2000 && !progress.converged; ++turn)
            progress = renderer.advance(InteractiveRenderer::Clock::now() + std::chrono::milliseconds(20));
        ASSERT_TRUE(progress.converged);
        EXPECT_EQ(renderer.resident().finest(), isCoarse ? 1 : 0);
        if (isCoarse) {
            EXPECT_TRUE(renderer.resident().uniform());
        }
        EXPECT_FALSE(isBlank(renderer.picture()));
    }
}

TEST(FirstPictures, ChangeNothing) {
    Ball ball;
    const auto draw = [&](const std::function<void(const Image&, double)>& first) {
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = 2;
        options.verify = Verify::none;
        options.onFirstPicture = first;
        return renderScene(ball.scene, *ball.store, ball.ram, ball.gpu, options);
    };
    const RenderResult alone = draw({});
    Image coarse;
    const RenderResult after = draw([&](const Image& image, double) { coarse = image; });
    EXPECT_EQ(after.image.pixels, alone.image.pixels);
    ASSERT_EQ(coarse.pixels.size(), alone.image.pixels.size());
    EXPECT_NE(coarse.pixels, alone.image.pixels);
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < coarse.pixels.size(); ++i) {
        difference += std::abs(static_cast<double>(coarse.pixels[i].a - alone.image.pixels[i].a));
        sum += static_cast<double>(alone.image.pixels[i].a);
    }
    EXPECT_GT(sum, 100);
    EXPECT_LT(difference, 0.15 * sum);
}

} // namespace
} // namespace tessera::test
