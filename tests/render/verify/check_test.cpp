// A picture's report of its own errors, against the reference; and the step that is taken if none is named.
#include "core/base/error.h"
#include "core/image/image_metrics.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(40, 40); // below PixelGrid::kMostPixels: every pixel is drawn again

Scene sceneOf(const std::string& store, const std::string& preset, bool shading) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(store), ram).info();
    Scene scene = sceneOn(info, preset, 0, kSize);
    scene.volumes[0].path = storePath(store);
    scene.shading.on = shading;
    return scene;
}

/// All bricks at the finest level, unless told: a small picture's pixels would be shown coarser ones, which
/// the truth is not made of.
RenderResult drawn(const Scene& scene, EngineKind engine = EngineKind::gpu,
                   LevelChoice levels = LevelChoice::oneForAll) {
    Budgets budgets;
    const StoreReader reader(scene.volumes[0].path, budgets.ram);
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    options.checking = true;
    options.levels = levels;
    return renderScene(scene, reader, budgets.ram, budgets.gpu, options);
}

double rmsOf(const RenderResult& result, const Image& truth) {
    return compare(result.image, truth).rms;
}

// The estimate of the step's error is the error, but for what the quarter of the step errs by and the table.
TEST(PictureErrors, TheStepsEstimateIsTheErrorToTheReference) {
    for (const bool shading : {false, true}) {
        Scene scene = sceneOf("torso", "bone-1", shading);
        const Image truth = drawn(scene, EngineKind::reference).image;
        for (const double step : {1.0, 0.5}) {
            scene.quality.stepVoxels = step;
            const RenderResult r = drawn(scene);
            ASSERT_TRUE(r.errors && r.errors->step);
            EXPECT_EQ(r.errors->pixels, kSize.x * kSize.y);
            EXPECT_FALSE(r.errors->filtering) << "fetches are exact";
            EXPECT_EQ(r.stepVoxels, step);
            const double estimated = r.errors->step->error.rms, is = rmsOf(r, truth);
            EXPECT_GT(estimated, 0.7 * is) << "step " << step << ", shading " << shading;
            EXPECT_LT(estimated, 1.5 * is) << "step " << step << ", shading " << shading;
        }
    }
}

TEST(PictureErrors, FilteredFetchesAreCheckedAgainstExactOnes) {
    Scene scene = sceneOf("torso", "soft-tissue", false);
    const Image exact = drawn(scene).image;
    scene.quality.fetch = Fetch::hardware;
    const RenderResult filtered = drawn(scene);
    ASSERT_TRUE(filtered.errors && filtered.errors->filtering);
    const ImageDifference is = compare(filtered.image, exact);
    EXPECT_GT(is.rms, 0);
    EXPECT_NEAR(filtered.errors->filtering->rms, is.rms, 0.01 * is.rms + 1e-7);
}

TEST(AutomaticStep, IsTheLongestThatIsGoodEnough) {
    Scene scene = sceneOf("torso", "bone-1", false);
    const Image truth = drawn(scene, EngineKind::reference).image;
    scene.quality.automaticStep = true;
    const RenderResult r = drawn(scene);
    EXPECT_LT(r.errors->step->error.rms, 1.0 / 255);
    EXPECT_LT(rmsOf(r, truth), 1.2 / 255);
    scene.quality.automaticStep = false;
    scene.quality.stepVoxels = 2 * r.stepVoxels;
    EXPECT_GT(drawn(scene).errors->step->error.rms, 1.0 / 255);
    // The same as when that step is named, and the same again.
    scene.quality.stepVoxels = r.stepVoxels;
    EXPECT_TRUE(bitEqual(drawn(scene).image, r.image));
}

// Step and integrator are the plan's, whoever draws it.
TEST(AutomaticStep, IsTheSameWhoeverDraws) {
    Scene scene = sceneOf("torso", "bone-1", true);
    scene.quality.automaticStep = true;
    scene.quality.integrator = Integrator::automatic;
    for (const bool sharp : {false, true}) {
        if (sharp)
            scene.volumes[0].transferFunction =
                TransferFunction::fromOpacity({{199, 0}, {200, 0.5}, {201, 0}}, {}, 0.01);
        const RenderResult native = drawn(scene, EngineKind::native);
        const RenderResult mirror = drawn(scene, EngineKind::mirror);
        EXPECT_EQ(mirror.stepVoxels, native.stepVoxels);
        EXPECT_EQ(mirror.integrator, native.integrator);
        EXPECT_NE(native.stepVoxels, scene.quality.stepVoxels) << "else this tells nothing";
        EXPECT_TRUE(bitEqual(mirror.image, native.image));
    }
}

// An error to stay below: what levels leave of it goes to the step, and a sharp function is pre-integrated.
TEST(MaxError, ChoosesStepAndIntegrator) {
    Scene scene = sceneOf("torso", "bone-1", false);
    scene.quality.integrator = Integrator::automatic;
    double before = 1e9;
    for (const double maxError : {20.0, 4.0, 1.5}) {
        scene.quality.maxError = maxError;
        const RenderResult r = drawn(scene, EngineKind::gpu, LevelChoice::perBrick);
        EXPECT_LE(r.errors->luvP99(), 1.05 * maxError); // seen in other pixels at first
        EXPECT_LE(r.stepVoxels, before);
        before = r.stepVoxels;
    }
    EXPECT_LT(before, 2);
    scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{199, 0}, {200, 0.5}, {201, 0}}, {}, 0.01);
    scene.quality.maxError = 30;
    EXPECT_EQ(drawn(scene).integrator, Integrator::preintegrated);
}

TEST(AutomaticIntegrator, FollowsTheFunction) {
    Scene scene = sceneOf("torso", "bone-1", false);
    scene.quality.integrator = Integrator::automatic;
    EXPECT_EQ(drawn(scene).integrator, Integrator::midpoint);
    scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{199, 0}, {200, 0.5}, {201, 0}}, {}, 0.01);
    EXPECT_EQ(drawn(scene).integrator, Integrator::preintegrated);
    scene.quality.edgeFunction = EdgeFunction::nearest; // jumps
    EXPECT_EQ(drawn(scene).integrator, Integrator::midpoint);
    scene.quality.integrator = Integrator::preintegrated;
    EXPECT_THROW(drawn(scene), InputError);
}

} // namespace
} // namespace tessera
