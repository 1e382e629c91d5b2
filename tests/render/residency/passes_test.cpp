// Pictures out of core. Budgets hold, whatever their size. At the finest level the picture is bit for bit the
// one without limits, in one pass or in hundreds, and rays that wait for a brick lose nothing.
#include "render/picture/render_scene.h"
#include "tests/support/graded.h"
#include "tests/support/scene_fixture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>

namespace tessera {
namespace {

using namespace tessera::test;

struct Drawn {
    RenderResult result;
    std::size_t peak = 0, limit = 0;
};

Drawn draw(const Scene& scene, const std::string& store, std::size_t gpuBytes,
           EngineKind engine = EngineKind::gpu, int threads = 2) {
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(storePath(store), ram);
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    options.threads = threads;
    return {renderScene(scene, reader, ram, gpu, options), gpu.peakBytes(), gpu.limitBytes()};
}

Scene finest(const std::string& store, const std::string& preset, int camera, bool shading) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(store), ram).info();
    Scene scene = sceneOn(info, preset, camera, {64, 64});
    scene.shading.on = shading;
    scene.quality.maxError = 0;
    return scene;
}

/// The floor that a refusal states, in bytes.
std::size_t statedFloor(const Scene& scene, const std::string& store, EngineKind engine) {
    try {
        draw(scene, store, 1, engine);
    } catch (const InputError& e) {
        const std::string text = e.what();
        std::smatch found;
        // "at least N bytes"-like texts round up; ask again with that until it is accepted or says more.
        if (std::regex_search(text, found, std::regex("at least ([0-9.]+) ([KMG]?i?B)")))
            return parseBytes(found[1].str() + found[2].str(), "floor");
        ADD_FAILURE() << text;
    }
    return 0;
}

struct PassesCase {
    const char* store;
    const char* preset;
    int camera;
    bool shading;
    EngineKind engine = EngineKind::gpu;
    Gradient gradient = Gradient::central;
    Integrator integrator = Integrator::midpoint;
    bool isGraded = false;
    Scene scene() const {
        Scene s = finest(store, preset, camera, shading);
        s.shading.gradient = gradient;
        if (engine == EngineKind::native)
            s.quality.integrator = integrator;
        if (isGraded)
            grade(s);
        return s;
    }
};
class Passes : public testing::TestWithParam<PassesCase> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Passes,
                         testing::Values(PassesCase{"torso", "bone-1", 0, true},
                                         PassesCase{"torso", "soft-tissue", 2, false},
                                         PassesCase{"abdomen", "bone-1", 2, true}));
constexpr EngineKind kNative = EngineKind::native;
INSTANTIATE_TEST_SUITE_P(Graded, Passes,
                         testing::Values(PassesCase{"torso", "soft-tissue", 2, false, EngineKind::gpu,
                                                    Gradient::central, Integrator::midpoint, true},
                                         PassesCase{"torso", "soft-tissue", 0, false, kNative,
                                                    Gradient::sobel, Integrator::midpoint, true},
                                         PassesCase{"torso", "soft-tissue", 1, true, kNative,
                                                    Gradient::central, Integrator::preintegrated, true}));
INSTANTIATE_TEST_SUITE_P(Native, Passes,
                         testing::Values(PassesCase{"torso", "bone-1", 0, true, kNative, Gradient::sobel},
                                         PassesCase{"torso", "soft-tissue", 2, true, kNative,
                                                    Gradient::central, Integrator::linear},
                                         PassesCase{"torso", "soft-tissue", 1, true, kNative,
                                                    Gradient::analytic, Integrator::preintegrated},
                                         PassesCase{"abdomen", "bone-1", 2, true, kNative},
                                         PassesCase{"head", "soft-tissue", 0, false, kNative,
                                                    Gradient::central, Integrator::preintegrated2d}));

TEST_P(Passes, AnyBudgetGivesTheSamePictureBitByBit) {
    const PassesCase c = GetParam();
    if (!std::filesystem::exists(storePath(c.store)))
        GTEST_SKIP() << c.store << " is absent: the real scans are not on this machine";
    const Scene scene = c.scene();
    const Drawn unlimited = draw(scene, c.store, std::size_t{1} << 30, c.engine);
    EXPECT_EQ(unlimited.result.passes, 1);
    EXPECT_FALSE(isBlank(unlimited.result.image));
    const std::size_t floor = statedFloor(scene, c.store, c.engine);
    ASSERT_GT(floor, 0u);
    for (const std::size_t budget : {floor, 2 * floor, floor + (std::size_t{50} << 16)}) {
        SCOPED_TRACE(budget);
        const Drawn small = draw(scene, c.store, budget, c.engine);
        EXPECT_LE(small.peak, small.limit);
        EXPECT_TRUE(bitEqual(small.result.image, unlimited.result.image));
        EXPECT_GE(small.result.work.segments, unlimited.result.work.segments) << "a smaller map skips less";
        if (small.result.atlasPages < small.result.selectionPages) {
            EXPECT_GT(small.result.passes, 1);
        }
    }
    // Loaders finish in any order; the picture does not care.
    EXPECT_TRUE(bitEqual(draw(scene, c.store, floor, c.engine, 5).result.image, unlimited.result.image));
}

// Without --max-error one pass must do, and a larger budget predicts no larger error.
TEST_P(Passes, TheBestOfOnePassFitsAndImprovesWithMemory) {
    const PassesCase c = GetParam();
    if (!std::filesystem::exists(storePath(c.store)))
        GTEST_SKIP() << c.store << " is absent: the real scans are not on this machine";
    Scene scene = c.scene();
    scene.quality.maxError.reset();
    const std::size_t floor = statedFloor(scene, c.store, c.engine);
    double before = 1e9;
    for (const std::size_t extra : {0u, 4u, 16u, 64u, 1000u}) {
        const Drawn d = draw(scene, c.store, floor + (std::size_t{extra} << 16), c.engine);
        EXPECT_LE(d.peak, d.limit);
        EXPECT_EQ(d.result.passes, 1);
        ASSERT_TRUE(d.result.predictedError.has_value());
        EXPECT_LE(d.result.predictedError->mean, before + 1e-9);
        before = d.result.predictedError->mean;
    }
}

// A first picture comes before, whole and coarse, and changes nothing of the picture itself.
TEST(FirstPicture, ComesFirstAndChangesNothing) {
    Scene scene = finest("torso", "bone-1", 0, true);
    scene.quality.maxError.reset();
    const RenderResult alone = draw(scene, "torso", std::size_t{6} << 20).result;
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{6} << 20);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.device.text = "software";
    Image first;
    options.onFirstPicture = [&](const Image& image, double secondsLeft) {
        first = image;
        EXPECT_GT(secondsLeft, 0);
    };
    const RenderResult result = renderScene(scene, reader, ram, gpu, options);
    ASSERT_EQ(first.size, scene.imageSize);
    EXPECT_FALSE(isBlank(first));
    EXPECT_TRUE(bitEqual(result.image, alone.image));
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
}

} // namespace
} // namespace tessera
