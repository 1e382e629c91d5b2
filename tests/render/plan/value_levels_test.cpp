// tests/render/plan/value_levels_test.cpp: pictures of single values have one level, as fine as a pixel can
// show, and leave out bricks that no ray comes near while samples reach no further.
#include "render/plan/planner.h"

#include "tests/support/surface_fixture.h" // Stored

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

struct Levels {
    int level = 0;
    std::size_t shown = 0, unseen = 0, pages = 0;
};

class ValueLevels : public testing::Test {
  protected:
    /// @param voxels  across a pixel, of a picture of 3x3 of them in the volume's middle
    Levels levelsOf(double voxels, Mode mode, int samples = 1, std::size_t gpuBytes = std::size_t{64} << 20) {
        Scene scene = stored_.scene({}, 0, 3);
        scene.volumes[0].transferFunction = "auto";
        scene.mode = mode;
        scene.quality.pixels.samples = samples;
        Camera camera = fitCamera(stored_.info, View::anterior, Projection::parallel, {3, 3});
        camera.parallelScale = 1.5 * voxels;
        scene.camera = camera;
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
        const StoreReader reader(stored_.folder / "v.zarr", ram);
        const Planner p = planScene(scene, reader, TextureLimits{}, {ram, gpu, 2});
        const Selection& s = p.layer().selection;
        EXPECT_TRUE(s.uniform());
        EXPECT_EQ(p.chosen.unseenBricks, s.counts[Selection::kEmpty]);
        EXPECT_EQ(p.chosen.atlasPages, pagesFor(s.counts));
        return {s.finest(), s.shownBricks(), p.chosen.unseenBricks, p.chosen.atlasPages};
    }
    const Stored stored_{[](const glm::dvec3& p) { return p.x + 2 * p.y + 3 * p.z; },
                         {256, 40, 256},
                         true,
                         1,
                         ValueType::i16}; // 8 x 2 x 8 bricks
};

TEST_F(ValueLevels, OfMeansAreAsFineAsPixels) {
    int before = 0;
    for (const double voxels : {1.01, 2.02, 4.04, 8.08, 16.2, 33.0}) {
        const Levels means = levelsOf(voxels, Mode::average);
        EXPECT_EQ(means.level, before) << voxels;
        before = std::min(before + 1, kLevelCount - 1);
        // Samples of level 2 reach half a brick at most; those of coarser ones further.
        EXPECT_EQ(means.unseen > 0, means.level <= 2) << voxels;
        EXPECT_EQ(means.shown + means.unseen, 128u);
        // A pixel that is the mean of samples shows two levels more.
        EXPECT_EQ(levelsOf(voxels, Mode::average, 4).level, std::max(0, means.level - 2)) << voxels;
        EXPECT_EQ(levelsOf(voxels, Mode::maximum).level, 0) << "the maximum of means is not the maximum";
    }
}

TEST_F(ValueLevels, OfALittleMemoryAreTheFinestThatFits) {
    int before = 0;
    std::size_t coarser = 0;
    for (const std::size_t bytes : {std::size_t{64} << 20, std::size_t{6} << 20, std::size_t{2} << 20}) {
        const Levels some = levelsOf(60, Mode::maximum, 1, bytes);
        EXPECT_GE(some.level, before);
        EXPECT_LE(some.pages * 65536, bytes);
        if (some.level > 0) {
            const std::size_t finer = PageAllocator::pagesFor(some.shown, some.level - 1);
            EXPECT_GT(finer * 65536 + (std::size_t{2} << 20), bytes) << "the level before would have fitted";
        }
        coarser += some.level > before;
        before = some.level;
    }
    EXPECT_GT(coarser, 0u);
}

} // namespace
} // namespace tessera::test
