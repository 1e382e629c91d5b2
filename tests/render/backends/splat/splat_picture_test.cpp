// tests/render/backends/splat/splat_picture_test.cpp: pictures of splats: closed forms, filters, levels,
// light and cuts; bits over threads and budgets; what is refused; the error that is told.
#include "tests/support/splat_scene.h"

#include "core/base/names.h"
#include "render/picture/frame_renderer.h"
#include "render/picture/render_scene.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/refusals.h"
#include "tests/support/set_levels.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace tessera::test {
namespace {

const std::vector<OpacityPoint> kEven = {{0, 0.02}, {1000, 0.02}};

/// Looks at the volume's middle, parallel.
Camera parallelFrom(const VolumeInfo& info, const glm::dvec3& towards, double halfHeight) {
    Camera camera;
    camera.projection = Projection::parallel;
    camera.focalPoint =
        glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    camera.position = camera.focalPoint + 500.0 * glm::normalize(towards);
    camera.viewUp = {0.1, 0.2, 1};
    camera.parallelScale = halfHeight;
    return camera;
}

TEST(SplatPictures, SlabsLetThroughWhatTheyShould) {
    SplatScene s({64, 40, 64}, [](const glm::dvec3&) { return 1.0; });
    s.show(kEven);
    for (const double halfHeight : {12.0, 40.0}) {
        s.scene.camera = parallelFrom(s.store->info(), {0, -1, 0}, halfHeight);
        for (const double sigma : {0.5, 0.6, 0.7, 0.8}) {
            SplatSettings settings;
            settings.sigma = sigma;
            const Image image = s.draw(settings);
            // Kernels add up but for their ripple along both axes, and the step at which they are cut off.
            const double ripple = 4 * std::exp(-2 * std::pow(std::numbers::pi * sigma, 2)) + std::exp(-4.5);
            for (int y = 30; y < 50; ++y)
                for (int x = 38; x < 58; ++x) {
                    const double depth =
                        -std::log1p(-double{image.pixels[static_cast<std::size_t>(y * 96 + x)].a});
                    ASSERT_NEAR(depth / (0.02 * 40), 1, ripple) << sigma << " " << x << " " << y;
                }
        }
    }
}

TEST(SplatPictures, BallsHaveTheirVolume) {
    const glm::dmat4 place = glm::rotate(glm::dmat4(1), 0.5, glm::dvec3(1, 0.4, 0.2));
    SplatScene s(
        {70, 66, 72},
        [](const glm::dvec3& p) { return glm::length(p - glm::dvec3(35, 33, 36)) < 25 ? 1.0 : 0.0; }, place);
    s.show({{0.4, 0}, {0.6, 1e-3}, {2, 1e-3}});
    s.scene.camera = parallelFrom(s.store->info(), {0.4, -1, 0.5}, 45);
    const double perPixel = std::pow(80 / 90.0, 2), ball = 4.0 / 3 * std::numbers::pi * std::pow(25.0, 3);
    EXPECT_NEAR(depthOf(s.draw()) / (1e-3 * ball * perPixel), 1, 0.01);
}

// The boxes of samples of all levels tile the volume, and slices share what is in them.
TEST(SplatPictures, LevelsKeepTheVolumesMass) {
    SplatScene s({90, 70, 100}, [](const glm::dvec3&) { return 1.0; });
    s.show({{0, 1e-3}, {2, 1e-3}});
    for (const glm::dvec3 towards :
         {glm::dvec3(0.2, -1, 0.1), glm::dvec3(1, 0.1, 0.3), glm::dvec3(0.2, 0.3, -1)}) {
        s.scene.camera = parallelFrom(s.store->info(), towards, 110); // room for the coarsest kernels
        Planner p = s.plan();
        const double mass = 1e-3 * 90 * 70 * 100 * std::pow(80 / 220.0, 2);
        for (int level = 0; level < kLevelCount; ++level) {
            setLevels(p, level);
            EXPECT_NEAR(depthOf(s.draw(p)) / mass, 1, 2e-3) << level;
        }
        p.setSelection(randomShownLevels(p.layer().selection, 7));
        EXPECT_NEAR(depthOf(s.draw(p)) / mass, 1, 2e-3);
    }
}

// Fine slices before and behind a coarse brick's: its depth is spread over them, so neither hides all of it.
TEST(SplatPictures, CoarseBricksLieAmongFineSlices) {
    const auto red = [](const glm::dvec3& p) { return std::abs(p.y - 16) < 8 ? 1.0 : 0.0; };
    SplatScene s({64, 32, 32}, red);
    s.show({{0, 0.05}, {1, 0.05}}, {{0, {0, 1, 0}}, {1, {1, 0, 0}}});
    s.scene.camera = parallelFrom(s.store->info(), {0, -1, 0}, 16);
    Planner p = s.plan();
    const Image fine = s.draw(p);
    Selection mixed = p.layer().selection;
    mixed.levels[0] = 3; // four samples along the way
    mixed.counts = {1, 0, 0, 1};
    p.setSelection(mixed);
    const Image both = s.draw(p);
    const auto at = [](const Image& image, int x) {
        return image.pixels[static_cast<std::size_t>(40 * 96 + x)];
    };
    for (const int x : {22, 30, 66, 72})
        for (int c = 0; c < 4; ++c)
            EXPECT_NEAR(at(both, x)[c], at(fine, x)[c], 0.02) << x;
}

TEST(SplatPictures, ComeNearTheTrueIntegral) {
    const glm::dmat4 place =
        glm::scale(glm::rotate(glm::dmat4(1), 0.3, glm::dvec3(0.2, 1, 0)), {0.8, 1, 1.7});
    SplatScene s(
        {80, 72, 40},
        [](const glm::dvec3& p) {
            const glm::dvec3 d = (p - glm::dvec3(40, 36, 20)) / glm::dvec3(11, 10, 6);
            return 100 * std::exp(-0.5 * glm::dot(d, d));
        },
        place);
    s.show({{0, 0}, {10, 0}, {100, 0.06}}, {{0, {0, 0, 1}}, {50, {1, 0.5, 0}}, {100, {1, 1, 1}}});
    for (const bool lit : {false, true})
        for (const int camera : {0, 1}) {
            s.scene.camera = cameraNumber(camera, s.store->info(), s.scene.imageSize);
            s.scene.shading.on = lit;
            RenderOptions options;
            options.threads = 2;
            options.engine = EngineKind::reference;
            const Image truth = renderScene(s.scene, *s.store, s.budgets.ram, s.budgets.gpu, options).image;
            SplatSettings settings;
            settings.sigma = 0.5;
            const double rms = rmsOf(s.draw(settings), truth);
            EXPECT_LT(rms, lit ? 0.012 : 0.008) << camera;
            settings.composition = SplatComposition::every; // hides more: what is in a slice hides itself
            EXPECT_LT(rmsOf(s.draw(settings), truth), 0.05);
            EXPECT_GT(rmsOf(s.draw(settings), truth), rms);
        }
}

TEST(SplatPictures, AdaptiveFiltersAreNearFullOnes) {
    SplatScene s({512, 512, 3}, [](const glm::dvec3& p) {
        return static_cast<double>((static_cast<int>(p.x) / 4 + static_cast<int>(p.y) / 4) & 1);
    });
    s.show({{0, 1}, {1, 1}}, {{0, {0, 0, 0}}, {1, {1, 1, 1}}});
    Camera camera;
    camera.focalPoint = {256, 256, 1.5};
    camera.viewUp = {0, 1, 0};
    const auto from = [&](double distance, double tilt) {
        camera.position = camera.focalPoint + distance * glm::normalize(glm::dvec3(0, -tilt, 1));
        s.scene.camera = camera;
    };
    const auto drawn = [&](SplatFilter filter) {
        SplatSettings settings;
        settings.filter = filter;
        return s.draw(settings);
    };
    for (const auto& [distance, tilt] : {std::pair(40.0, 0.3), {150.0, 1.0}, {700.0, 2.0}, {6000.0, 0.3}}) {
        from(distance, tilt);
        const Image full = drawn(SplatFilter::full), adaptive = drawn(SplatFilter::adaptive);
        EXPECT_LT(rmsOf(adaptive, full), 2.0 / 255) << distance;
    }
    from(40, 0.3);
    drawn(SplatFilter::adaptive);
    EXPECT_EQ(s.report.counts.byFilter[0], s.report.counts.drawn);
    const auto holes = [](const Image& image) {
        return std::count_if(image.pixels.begin(), image.pixels.end(),
                             [](const auto& p) { return p.a < 0.5f; });
    };
    EXPECT_EQ(holes(drawn(SplatFilter::full)), 0);
    EXPECT_GT(holes(drawn(SplatFilter::lowPass)), 1000) << "footprints that are too small leave holes";
    // Far away a pixel holds many fields, and is grey but where footprints miss it.
    from(12000, 0.3);
    drawn(SplatFilter::adaptive);
    EXPECT_EQ(s.report.counts.byFilter[1], s.report.counts.drawn);
    const auto contrast = [&](SplatFilter filter) {
        const Image image = drawn(filter);
        double least = 1, most = 0;
        for (int y = 39; y < 41; ++y)
            for (int x = 47; x < 49; ++x) {
                const double grey = image.pixels[static_cast<std::size_t>(y * 96 + x)].r;
                least = std::min(least, grey), most = std::max(most, grey);
            }
        return std::max(most - 0.5, 0.5 - least);
    };
    EXPECT_LT(contrast(SplatFilter::full), 0.06);
    EXPECT_LT(contrast(SplatFilter::adaptive), 0.06);
    EXPECT_GT(contrast(SplatFilter::reconstruction), 0.1) << "pixels between samples see other ones, or none";
}

// A brick that lies beside the picture reaches into it.
TEST(SplatPictures, PartsAreThoseOfTheWhole) {
    SplatScene s({40, 40, 64}, [](const glm::dvec3& p) { return 50 + 50 * std::sin(p.x + 0.7 * p.z); });
    s.show({{0, 0.01}, {100, 0.2}}, {{0, {0, 0, 1}}, {100, {1, 1, 0}}});
    const auto rows = [&](int height) {
        Camera camera = parallelFrom(s.store->info(), {0, -1, 0}, height / 2.0);
        camera.viewUp = {0, 0, 1};
        camera.position.z = camera.focalPoint.z = 48.5; // the lower brick ends half a pixel below 32 rows
        s.scene.imageSize = {96, height};
        s.scene.camera = camera;
        return s.draw();
    };
    const Image whole = rows(80), part = rows(32);
    for (std::size_t n = 0; n < part.pixels.size(); ++n)
        for (int c = 0; c < 4; ++c)
            ASSERT_NEAR(part.pixels[n][c], whole.pixels[n + std::size_t{24} * 96][c], 1e-5) << n / 96;
}

struct TorsoSplats : ::testing::Test {
    SplatScene s{storePath("torso"), {150, 110}};
    Scene& scene = s.scene;
    const StoreReader& store = *s.store;
    Budgets& budgets = s.budgets;
};

TEST_F(TorsoSplats, ThreadsAndBudgetsChangeNoBit) {
    for (const int camera : {0, 1, 2}) {
        scene.camera = cameraNumber(camera, store.info(), scene.imageSize);
        scene.quality.terminationTransmittance = camera == 1 ? 0 : 1.0 / 510;
        Planner p = planScene(scene, store, TextureLimits{}, {budgets.ram, budgets.gpu, 0});
        p.setSelection(randomShownLevels(p.layer().selection, 3u + static_cast<unsigned>(camera)));
        const Image one = s.draw(p, {}, 1);
        EXPECT_GT(depthOf(one), 0);
        EXPECT_TRUE(bitEqual(s.draw(p, {}, 3), one)) << camera;
        // So little that bricks are listed slice by slice, and batches end amid slices.
        MemoryBudget small("GPU memory", "--gpu-memory", std::size_t{3} << 20);
        EXPECT_TRUE(bitEqual(s.draw(p, {}, 2, &small), one)) << camera;
        EXPECT_LE(small.peakBytes(), small.limitBytes());
        EXPECT_EQ(small.usedBytes(), 0u);
        MemoryBudget none("GPU memory", "--gpu-memory", std::size_t{1} << 20);
        EXPECT_THAT(refusalOf([&] { s.draw(p, {}, 1, &none); }), testing::HasSubstr("--gpu-memory"));
    }
    EXPECT_GT(s.report.counts.tooNear, 0u) << "the last camera is inside";
}

TEST(SplatPictures, TerminationHidesNoMoreThanItSays) {
    SplatScene s({70, 100, 100}, [](const glm::dvec3& p) { return std::fmod(p.x + p.y, 50); });
    s.show({{0, 0.02}, {50, 0.5}}, {{0, {0, 0, 1}}, {50, {1, 1, 0}}});
    s.scene.imageSize = {300, 240};
    s.scene.camera = cameraNumber(1, s.store->info(), s.scene.imageSize);
    Planner p = s.plan();
    const Image all = s.draw(p);
    const std::size_t splats = s.report.counts.drawn;
    p.setTermination(0.01f);
    const Image ended = s.draw(p);
    for (std::size_t n = 0; n < all.pixels.size(); ++n)
        for (int c = 0; c < 4; ++c)
            ASSERT_NEAR(ended.pixels[n][c], all.pixels[n][c], 0.0101) << n;
    EXPECT_LT(s.report.counts.drawn, splats);
}

// A box that keeps half of a volume's samples keeps half of its mass.
TEST(SplatPictures, CutsGoByTheMiddleOfASplat) {
    SplatScene s({64, 64, 64}, [](const glm::dvec3&) { return 1.0; });
    s.show({{0, 1e-3}, {2, 1e-3}});
    s.scene.camera = parallelFrom(s.store->info(), {0.3, -1, 0.2}, 70);
    const double all = depthOf(s.draw());
    CropBox box;
    box.space = CropBox::Space::voxels;
    box.low = {0, 0, 0};
    box.high = {32, 64, 64};
    for (const Keep keep : {Keep::inside, Keep::outside}) {
        box.keep = keep;
        s.scene.cuts.boxes = {box};
        EXPECT_NEAR(depthOf(s.draw()) / all, 0.5, 1e-4) << static_cast<int>(keep);
    }
}

TEST_F(TorsoSplats, RefuseWhatTheyDoNotDraw) {
    const std::pair<std::function<void(Scene&)>, const char*> rows[] = {
        {[](Scene& o) {
             o.surfaces = {{250, glm::dvec3(1), 0.5}};
         },
         "it draws no isosurfaces"},
        {[](Scene& o) { o.mode = Mode::maximum; }, "it draws mode composite alone"},
        {[](Scene& o) { o.mode = Mode::slice; }, "it draws mode composite alone"},
        {[](Scene& o) { o.mode = Mode::emission; }, "it draws mode composite alone"},
        {[](Scene& o) { o.lighting.occlusion.emplace(); }, "it has no occlusion, shadows"},
        {[](Scene& o) { o.lighting.transport.emplace(); }, "it follows no paths"},
        {[](Scene& o) { o.shading.gradient = Gradient::sobel; }, "its gradients are of kind central"},
        {[](Scene& o) { o.quality.pixels.samples = 4; }, "its pixels have one sample"},
        {[](Scene& o) { o.quality.pixels.samples = PixelSampling::kAutomatic; }, "its pixels have"},
        {[](Scene& o) { o.quality.maxError = 1; }, "its error is measured"},
        {[](Scene& o) { o.quality.sampling = Sampling::hulls; }, "it has no rays whose sampling"},
        {[](Scene& o) { o.quality.sampling = Sampling::full; }, "it has no rays whose sampling"},
        {[](Scene& o) { o.quality.integrator = Integrator::linear; }, "it integrates along no ray"},
        {[](Scene& o) { o.quality.stepVoxels = 0.25; }, "it has no rays that take steps"},
        {[](Scene& o) { o.quality.edgeFunction = EdgeFunction::nearest; }, "it fetches no values"},
        {[](Scene& o) { o.quality.fetch = Fetch::exact; }, "it fetches no values"},
    };
    for (const auto& [set, words] : rows) {
        Scene other = scene;
        set(other);
        RenderOptions splat;
        splat.engine = EngineKind::splat;
        EXPECT_THAT(refusalOf([&] { renderScene(other, store, budgets.ram, budgets.gpu, splat); }),
                    testing::AllOf(testing::HasSubstr("--engine"),
                                   testing::HasSubstr(std::string("splat: ") + words)));
        FrameRenderer film(store, budgets.ram, budgets.gpu, splat); // of frames likewise
        EXPECT_THAT(refusalOf([&] { film.draw(other); }), testing::HasSubstr(std::string("splat: ") + words));
    }
    RenderOptions options;
    options.layers.errors = true;
    EXPECT_THAT(splatDeclines(scene, options), testing::HasSubstr("layers"));
    EXPECT_EQ(splatDeclines(scene, {}), "");
}

// A light that is very bright where no sample is takes no precision from those that are.
TEST_F(TorsoSplats, ALightBesideNothingChangesNoColour) {
    scene.shading.on = true;
    Light sun, lamp;
    sun.kind = LightKind::directional;
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    lamp.position = {4000, 0, 0};
    lamp.attenuation = {1e-6, 0, 1e6};
    scene.lighting.lights = {sun};
    const Image alone = s.draw();
    scene.lighting.lights = {sun, lamp};
    EXPECT_LT(rmsOf(s.draw(), alone), 1e-4);
    EXPECT_GT(depthOf(alone), 1);
}

// As the picture of the reference says it, of the same pixels.
TEST_F(TorsoSplats, TellTheirErrorAgainstTheTrueIntegral) {
    scene.imageSize = {36, 30};
    scene.shading.on = false;
    scene.camera = cameraNumber(0, store.info(), scene.imageSize);
    RenderOptions options;
    options.verify = Verify::full;
    options.engine = EngineKind::splat;
    const RenderResult r = renderScene(scene, store, budgets.ram, budgets.gpu, options);
    ASSERT_TRUE(r.measured);
    ASSERT_EQ(r.measured->whyNot, "");
    ASSERT_TRUE(r.measured->all.rms);
    EXPECT_EQ(r.engine, EngineKind::splat);
    EXPECT_GT(r.work.segments, 1000u);
    RenderOptions exact;
    exact.engine = EngineKind::reference;
    const Image truth = renderScene(scene, store, budgets.ram, budgets.gpu, exact).image;
    double sum = 0;
    std::size_t shown = 0;
    for (std::size_t n = 0; n < truth.pixels.size(); ++n) {
        const glm::dvec4 d(r.image.pixels[n] - truth.pixels[n]);
        sum += glm::dot(d, d) / 4;
        shown += r.image.pixels[n].a > 0 || truth.pixels[n].a > 0;
    }
    const double rms = std::sqrt(sum / static_cast<double>(shown));
    EXPECT_NEAR(r.measured->all.rms->value, rms, 0.25 * rms);
    EXPECT_GT(rms, 1e-3) << "a splat is no ray";
}

} // namespace
} // namespace tessera::test
