// A picture's report of its measured errors, and the promise of --max-error, against the truth: the
// reference's integral, averaged over each pixel's area.
#include "core/image/image_metrics.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

Scene sceneOf(const std::string& store, const std::string& preset, const glm::ivec2& size) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath(store), ram).info();
    Scene scene = sceneOn(info, preset, 0, size);
    scene.volumes[0].path = storePath(store);
    scene.shading.on = false;
    return scene;
}

RenderResult drawn(const Scene& scene, EngineKind engine, Verify verify,
                   std::size_t gpuBytes = std::size_t{256} << 20) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20), gpu("GPU memory", "--gpu-memory", gpuBytes);
    const StoreReader reader(scene.volumes[0].path, ram);
    RenderOptions options;
    options.engine = engine;
    options.device.text = "software";
    options.searching = true;
    options.verify = verify;
    const RenderResult result = renderScene(scene, reader, ram, gpu, options);
    EXPECT_LE(ram.peakBytes(), ram.limitBytes());
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    return result;
}

Image truthOf(Scene scene, int samples) {
    scene.quality.pixels.samples = samples;
    scene.quality.pixels.seed = 77; // not the picture's
    scene.quality.maxError.reset();
    return drawn(scene, EngineKind::reference, Verify::none).image;
}

/// Within the interval, as far as the truth itself is known.
void expectHolds(const std::optional<Estimate>& e, double is, double slack, const std::string& what) {
    ASSERT_TRUE(e) << what;
    EXPECT_GE(is, e->low * (1 - slack)) << what << " is above " << is;
    EXPECT_LE(is, e->high * (1 + slack)) << what << " is below " << is;
}

// One ray a pixel, four, and sixteen; all levels and coarse ones; native engine and GPU ray caster: the
// reported error is the real one.
TEST(MeasuredErrors, AreTheErrorsToTheReferencesAreaMeans) {
    const glm::ivec2 size(64, 48);
    Scene scene = sceneOf("torso", "bone-1", size);
    scene.quality.stepVoxels = 0.5;
    const Image truth = truthOf(scene, 32);
    struct Case {
        EngineKind engine;
        int samples;
        double step;
        std::size_t gpuBytes;
    };
    const std::size_t ample = std::size_t{256} << 20;
    for (const Case& c :
         {Case{EngineKind::native, 1, 0.5, ample}, Case{EngineKind::native, 16, 2, ample},
          Case{EngineKind::native, 16, 0.5, std::size_t{1200} << 10}, Case{EngineKind::gpu, 4, 0.5, ample}}) {
        scene.quality.pixels.samples = c.samples;
        scene.quality.stepVoxels = c.step;
        const RenderResult r = drawn(scene, c.engine, Verify::full, c.gpuBytes);
        const std::string what = std::string(name(c.engine)) + ", " + std::to_string(c.samples) +
                                 " samples, step " + std::to_string(c.step) + ", finest level " +
                                 std::to_string(r.level);
        ASSERT_TRUE(r.measured && r.measured->whyNot.empty()) << what << r.measured->whyNot;
        if (c.gpuBytes < ample) {
            EXPECT_GT(r.bricksOfLevel[1] + r.bricksOfLevel[2] + r.bricksOfLevel[3], 0u) << "coarse levels";
        }
        const ImageDifference is = compare(r.image, truth);
        expectHolds(r.measured->all.rms, is.rms, 0.15, what + ", rms");
        expectHolds(r.measured->all.luvMean, is.luvMean, 0.15, what + ", mean");
        expectHolds(r.measured->all.luvP99, is.luvP99, 0.3, what + ", 99th percentile");
        // One ray a pixel errs by what it leaves out of the pixel, coarse levels by what they leave out of
        // it.
        const MeasuredErrors &samples = r.measured->sampling, &rays = r.measured->rays;
        ASSERT_TRUE(samples.rms && rays.rms) << what;
        if (c.samples == 1) {
            EXPECT_GT(samples.rms->value, 5 * rays.rms->value) << what;
        }
        if (c.gpuBytes < ample) {
            EXPECT_LT(samples.rms->value, rays.rms->value) << what;
        }
    }
}

// A pixel that is the mean of its samples shows more than the level whose samples are as large as it is.
TEST(MeasuredErrors, OfLevelsAreSmallWherePixelsAreLarge) {
    Scene scene = sceneOf("torso", "bone-1", glm::ivec2(20));
    scene.quality.stepVoxels = 0.5;
    scene.quality.pixels.samples = 64;
    const RenderResult r = drawn(scene, EngineKind::native, Verify::full);
    ASSERT_TRUE(r.measured && r.measured->rays.rms);
    EXPECT_LT(r.measured->rays.rms->value, 0.004);
    scene.quality.pixels.samples = 1; // its size is what counts
    const RenderResult coarse = drawn(scene, EngineKind::native, Verify::full);
    EXPECT_LT(coarse.bricksOfLevel[0], r.bricksOfLevel[0]);
    ASSERT_TRUE(coarse.measured && coarse.measured->rays.rms);
    EXPECT_GT(coarse.measured->rays.rms->value, 3 * r.measured->rays.rms->value);
}

// Rays that end with a tenth of the light left: the truth's do not.
TEST(MeasuredErrors, CountWhatEndedRaysLeaveOut) {
    Scene scene = sceneOf("torso", "skin-1", {48, 48});
    scene.quality.pixels.samples = 16;
    scene.quality.terminationTransmittance = 0.1;
    for (const EngineKind engine : {EngineKind::native, EngineKind::gpu}) {
        const RenderResult r = drawn(scene, engine, Verify::full);
        ASSERT_TRUE(r.measured && r.measured->whyNot.empty());
        Scene whole = scene;
        whole.quality.terminationTransmittance = 0;
        const ImageDifference is = compare(r.image, drawn(whole, engine, Verify::none).image);
        ASSERT_GT(is.rms, 0.02);
        expectHolds(r.measured->rays.rms, is.rms, 0.05, name(engine));
        EXPECT_NEAR(r.measured->all.rms->value, is.rms, 0.1 * is.rms);
    }
}

// Whoever asks for an error gets it, measured on pixels that decided nothing; or is told that it is not
// there.
TEST(MaxError, HoldsAgainstTheReferencesAreaMeans) {
    const glm::ivec2 size(56, 44);
    Scene scene = sceneOf("torso", "bone-1", size);
    const Image truth = truthOf(scene, 128); // noise makes errors larger
    for (const double asked : {20.0, 6.0}) {
        scene.quality.maxError = asked;
        scene.quality.pixels.samples = 64;
        const RenderResult r = drawn(scene, EngineKind::native, Verify::full);
        EXPECT_EQ(r.shortfall, "") << asked;
        ASSERT_TRUE(r.measured && r.measured->all.luvP99Bound);
        EXPECT_LE(*r.measured->all.luvP99Bound, asked);
        EXPECT_LE(compare(r.image, truth).luvP99, asked);
        if (asked == 20.0) { // with so little memory that rays wait for bricks it is the same picture
            EXPECT_EQ(drawn(scene, EngineKind::native, Verify::full, std::size_t{1200} << 10).image.pixels,
                      r.image.pixels);
        }
    }
    scene.quality.maxError = 2;
    scene.quality.pixels.samples = 1; // asked for: so nothing is finer
    const RenderResult r = drawn(scene, EngineKind::native, Verify::full);
    EXPECT_NE(r.shortfall.find("no pixel can get more samples"), std::string::npos) << r.shortfall;
    EXPECT_GT(compare(r.image, truth).luvP99, 2);
}

// A second picture whose rays are the first one's goes on from its samples: none is taken twice.
TEST(MaxError, GoesOnFromSamplesOfTheSameRays) {
    Scene scene = sceneOf("torso", "vessels-1", {56, 44});
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    scene.camera = cameraNumber(1, StoreReader(storePath("torso"), ram).info(), scene.imageSize);
    scene.quality.maxError = 12;
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    const RenderResult r = drawn(scene, EngineKind::native, Verify::full);
    EXPECT_EQ(r.shortfall, "");
    ASSERT_EQ(r.rounds, 2);
    Scene once = scene; // a ray through the middle of each pixel, too few to search blocks of empty space
    once.quality.maxError.reset();
    once.quality.automaticStep = false;
    once.quality.stepVoxels = r.stepVoxels;
    once.quality.integrator = r.integrator;
    once.quality.pixels.samples = 1;
    const RenderResult all = drawn(once, EngineKind::native, Verify::none);
    EXPECT_EQ(all.refinedCells, 0u);
    EXPECT_LT(static_cast<double>(r.work.segments),
              0.9 * static_cast<double>(all.work.segments) * r.pixels.taken)
        << "they leap over blocks; taken twice they would be more";
}

// A picture with as many samples as the truth begins with: where the truth is noisier than the picture's
// largest errors, it gets more, and tells what these are.
TEST(MeasuredErrors, NoisyPixelsOfTheTruthGetMoreSamples) {
    Scene scene = sceneOf("torso", "vessels-1", {64, 48});
    scene.quality.pixels.samples = 256;
    const RenderResult r = drawn(scene, EngineKind::native, Verify::full);
    ASSERT_TRUE(r.measured && r.measured->whyNot.empty());
    const PictureMeasurement& m = *r.measured;
    EXPECT_EQ(m.mostSamples, 16 * m.samples);
    EXPECT_LT(m.all.noiseShare, 0.25);
    EXPECT_LT(m.sampling.noiseShare, 0.25);
    ASSERT_TRUE(m.all.luvP99 && m.sampling.luvP99);
    EXPECT_LT(m.sampling.luvP99->value, 0.3 * m.all.luvP99->value) << "steps err, not so many samples";
    const RenderResult quick = drawn(scene, EngineKind::native, Verify::quick);
    EXPECT_EQ(quick.measured->mostSamples, quick.measured->samples) << "its cost is bounded";
}

// Where phases help much the truth has them, and longer steps: what rays err by comes out as it does through
// shorter steps without.
TEST(MeasuredErrors, ThroughPhasesAreThoseThroughShorterSteps) {
    Scene scene = sceneOf("torso", "lung", glm::ivec2(256));
    scene.shading.on = true;
    scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{-950, 0}, {-600, 0.01}, {500, 0.03}}, {{-900, {0.5, 0.3, 0.2}}});
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    scene.quality.automaticStep = true;
    const RenderResult phased = drawn(scene, EngineKind::native, Verify::quick);
    ASSERT_TRUE(phased.stepOfMeans);
    ASSERT_GE(*phased.stepOfMeans, 3 * phased.stepVoxels) << "phases would not be used";
    scene.quality.automaticStep = false;
    scene.quality.stepVoxels = phased.stepVoxels;
    const RenderResult plain = drawn(scene, EngineKind::native, Verify::quick);
    ASSERT_FALSE(plain.stepOfMeans);
    ASSERT_TRUE(phased.measured->rays.rms && plain.measured->rays.rms);
    EXPECT_NEAR(phased.measured->rays.rms->value, plain.measured->rays.rms->value,
                0.1 * plain.measured->rays.rms->value);
    EXPECT_NEAR(phased.measured->rays.luvMean->value, plain.measured->rays.luvMean->value,
                0.1 * plain.measured->rays.luvMean->value);
}

// Measuring changes no pixel; errors that budgets have no room for are not guessed.
TEST(MeasuredErrors, ChangeNoPictureAndKeepToBudgets) {
    Scene scene = sceneOf("torso", "soft-tissue", glm::ivec2(40));
    scene.quality.stepVoxels = 1;
    for (const EngineKind engine : {EngineKind::native, EngineKind::gpu}) {
        const RenderResult with = drawn(scene, engine, Verify::quick),
                           without = drawn(scene, engine, Verify::none);
        EXPECT_EQ(with.image.pixels, without.image.pixels);
        EXPECT_TRUE(with.measured && !without.measured);
        EXPECT_EQ(with.stepVoxels, without.stepVoxels) << "the manifest's is the picture's";
    }
}

} // namespace
} // namespace tessera
