// tests/bench/sweep_test.cpp: one whole sweep of `tessera accuracy`, and the standard scenes.
#include "tests/bench/accuracy/scenes.h"
#include "tests/support/accuracy_fixture.h"

#include "bricking/import/importer.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "datasets/phantom.h"
#include "render/plan/planner.h"
#include "tests/bench/accuracy/area_sweep.h"
#include "tests/bench/accuracy/light_sweep.h"
#include "tests/bench/accuracy/runs_table.h"
#include "tests/bench/accuracy/scene_section.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

namespace tessera::accuracy {
namespace {

using ::testing::HasSubstr;

// Samples of a pixel bring pictures nearer to the mean over its area; shorter steps of one ray do not.
TEST(AnAreaSweep, FindsThatSamplesGainWhatStepsDoNot) {
    const ScratchFolder folder;
    {
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        ImportOptions options;
        options.durable = false;
        importToStore(*makePhantom("torso", {48, 36, 56}), folder / "v.zarr", ram, options);
    }
    NamedScene scene{"torso", "A phantom.", plainScene(), 0};
    scene.scene.volumes[0].path = folder / "v.zarr";
    scene.scene.imageSize = {40, 32};
    SweepOptions options;
    options.ramBytes = options.gpuBytes = std::size_t{256} << 20;
    options.effort.quick = true;
    const AreaSweep sweep = runAreaSweep(scene, options);
    const auto find = [&](const std::string& setting) {
        return *std::find_if(sweep.points.begin(), sweep.points.end(),
                             [&](const AreaPoint& p) { return p.setting == setting; });
    };
    EXPECT_GT(find("step 1/4").rms, 0.8 * find("step 1").rms);
    EXPECT_LT(find("8 samples").rms, 0.5 * find("step 1/4").rms);
    EXPECT_LT(find("auto").rms, find("8 samples").rms);
    EXPECT_GT(find("auto").samples, 1);
    const bench::Report report = areaSection({sweep});
    EXPECT_EQ(report.tables.at(0).rows.size(), sweep.points.size());
    EXPECT_EQ(report.plots.at(0).curves.size(), 3u);
}

// Light of voxels: more rays are nearer to the reference, a scene without such light has no section.
TEST(ALightSweep, FindsWhatRaysAndReachGain) {
    const ScratchFolder folder;
    {
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        ImportOptions options;
        options.durable = false;
        importToStore(*makePhantom("torso", {48, 36, 56}), folder / "v.zarr", ram, options);
    }
    NamedScene scene{"torso", "A phantom.", plainScene(), 0};
    scene.scene.volumes[0].path = folder / "v.zarr";
    scene.scene.imageSize = {40, 32};
    scene.scene.shading.on = true;
    SweepOptions options;
    options.ramBytes = options.gpuBytes = std::size_t{256} << 20;
    options.effort.quick = true;
    EXPECT_FALSE(runLightSweep(scene, options));
    scene.scene.lighting.occlusion = Occlusion{.radiusMm = 60};
    Light key;
    key.kind = LightKind::directional;
    key.direction = {-1, 1, 1};
    key.shadow = true;
    scene.scene.lighting.lights = {key};
    const auto sweep = runLightSweep(scene, options);
    ASSERT_TRUE(sweep);
    EXPECT_EQ(sweep->truthRays, 320);
    const auto find = [&](const std::string& setting) {
        return *std::find_if(sweep->points.begin(), sweep->points.end(),
                             [&](const LightPoint& p) { return p.setting == setting; });
    };
    for (const LightPoint& p : sweep->points) {
        EXPECT_TRUE(std::isfinite(p.rms)) << p.axis << p.setting;
        EXPECT_GT(p.seconds, 0) << p.axis << p.setting;
        EXPECT_GT(p.bytes, 0) << p.axis << p.setting;
    }
    EXPECT_EQ(find("32 rays").rms, find("").rms); // the scene as it is
    EXPECT_GT(find("30 mm").bias, find("").bias); // that see less of what is around
    EXPECT_NE(find("2 layers").rms, find("").rms);
    const bench::Report report = lightSection({*sweep});
    EXPECT_EQ(report.tables.at(0).rows.size(), sweep->points.size());
    EXPECT_EQ(report.plots.at(0).curves.size(), 5u);
}

// A whole sweep: finite, bounded, and nearer to the truth with every halving of the step.
TEST(ASweep, FindsThatErrorsFallWithTheStep) {
    const ScratchFolder folder;
    {
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20);
        ImportOptions options;
        options.durable = false;
        importToStore(*makePhantom("torso", {48, 36, 56}), folder / "v.zarr", ram, options);
    }
    NamedScene scene{"torso", "A phantom.", plainScene(), 0};
    scene.scene.volumes[0].path = folder / "v.zarr";
    scene.scene.imageSize = {40, 32};
    SweepOptions options;
    options.device = "software";
    options.ramBytes = std::size_t{256} << 20;
    options.gpuBytes = std::size_t{64} << 20;
    options.effort.quick = true;
    const auto add = [&](const std::string& axis) -> Setting& {
        options.settings.push_back({settingOf(scene.scene), axis});
        return options.settings.back().setting;
    };
    add("default");
    for (const double step : {2.0, 1.0, 0.5, 0.25}) {
        Setting& s = add("product");
        s.integrator = Integrator::midpoint;
        s.stepVoxels = step;
        s.termination = 0;
    }
    for (const double step : {1.0, 0.5}) { // its tables are for a step
        Setting& s = add("product");
        s.integrator = Integrator::preintegrated2d;
        s.stepVoxels = step;
    }
    add("memory").detail.memoryShare = 4;
    CommonOptions common;
    common.quiet = true;
    const Sweep sweep = runSweep(scene, options, common);
    EXPECT_TRUE(sweep.proof.holds()) << sweep.proof.halving << ", " << sweep.proof.independent;
    EXPECT_EQ(sweep.imageSize, glm::ivec2(40, 32));
    EXPECT_EQ(sweep.pixelStride, 1);
    for (const Failure& failure : sweep.failures)
        ADD_FAILURE() << failure.setting << ": " << failure.what;
    for (const Measured& m : sweep.measured) {
        EXPECT_EQ(m.error.nanCount, 0u) << settingName(m.planned.setting);
        EXPECT_TRUE(m.boundOk) << settingName(m.planned.setting);
        EXPECT_GT(m.work.samples, 0u);
        EXPECT_GT(m.leastMs(), 0);
        EXPECT_EQ(m.leastOfBlocks().size(), 2u);
        EXPECT_GT(m.peakGpuBytes, 0u);
        EXPECT_LE(m.peakGpuBytes, options.gpuBytes);
        EXPECT_LE(m.peakRamBytes, options.ramBytes);
        EXPECT_GT(m.error.maskedPixels, 100u);
        EXPECT_LE(m.error.p999, m.error.maxAbs);
    }
    ASSERT_EQ(sweep.measured.size(), options.settings.size());
    double before = 1;
    for (const double step : {2.0, 1.0, 0.5, 0.25}) {
        Setting s = settingOf(scene.scene);
        s.integrator = Integrator::midpoint;
        s.stepVoxels = step;
        s.termination = 0;
        const Measured* m = sweep.find(s);
        ASSERT_NE(m, nullptr) << step;
        EXPECT_LT(m->error.rmse, before) << step;
        before = m->error.rmse;
    }
    // Less memory, more error: the sweep measures what it says.
    Setting little = settingOf(scene.scene);
    little.detail.memoryShare = 4;
    const Measured* const coarse = sweep.find(little);
    const Measured* const whole = sweep.find(settingOf(scene.scene));
    ASSERT_TRUE(coarse && whole);
    EXPECT_GT(coarse->error.rmse, whole->error.rmse);
    EXPECT_LT(coarse->peakGpuBytes, whole->peakGpuBytes);
}

TEST(StandardScenes, AreSevenAndSayWhatIsLeftOut) {
    EXPECT_EQ(standardSceneNames().size(), 7u);
    const ScratchFolder folder;
    CommonOptions common;
    common.quiet = true;
    const StandardScenes made = standardScenes(folder.path(), "", {"boundary-layer", "narrow-ct"}, true,
                                               std::size_t{256} << 20, common);
    ASSERT_EQ(made.scenes.size(), 1u);
    EXPECT_EQ(made.scenes[0].name, "boundary-layer");
    EXPECT_EQ(made.leftOut.size(), 6u);
    EXPECT_THAT(made.leftOut, ::testing::Contains(HasSubstr("not at hand")));
    EXPECT_THROW(standardScenes(folder.path(), "", {"sphare"}, true, std::size_t{256} << 20, common),
                 InputError);
}

// The input of other renderers: the same function, spelled out, and a volume beside the file.
TEST(StandardScenes, AreKeptForOtherRenderers) {
    const ScratchFolder folder;
    CommonOptions common;
    common.quiet = true;
    const std::size_t ramBytes = std::size_t{256} << 20;
    for (int again = 0; again < 2; ++again) { // over what is there
        const StandardScenes made = standardScenes(folder.path(), "", {"sphere", "boundary-layer", "sparse"},
                                                   true, ramBytes, common, true);
        keepScenes(made.scenes, folder.path(), ramBytes);
        ASSERT_EQ(made.scenes.size(), 3u);
        for (const NamedScene& scene : made.scenes) {
            std::ifstream file(folder / (scene.name + ".json"));
            const std::string text((std::istreambuf_iterator<char>(file)), {});
            EXPECT_THAT(text, ::testing::Not(HasSubstr(folder.path().string()))) << "a path of this machine";
            const Scene kept = loadScene(folder / (scene.name + ".json"));
            EXPECT_EQ(kept.volumes[0].path, scene.scene.volumes[0].path);
            EXPECT_EQ(kept.imageSize, scene.scene.imageSize);
            EXPECT_FALSE(kept.shading.on);
            MemoryBudget ram("RAM", "--ram", ramBytes);
            const StoreReader store(kept.volumes[0].path, ram);
            const auto& function = std::get<TransferFunction>(kept.volumes[0].transferFunction);
            const Planner measured = planView(scene.scene, store, ram, 1);
            EXPECT_EQ(function.referenceLengthMm(), measured.layer().function.referenceLengthMm());
            ASSERT_EQ(function.opacityPoints().size(), measured.layer().function.opacityPoints().size());
            for (std::size_t i = 0; i < function.opacityPoints().size(); ++i) {
                EXPECT_EQ(function.opacityPoints()[i].value,
                          measured.layer().function.opacityPoints()[i].value);
                EXPECT_EQ(function.opacityPoints()[i].opacity,
                          measured.layer().function.opacityPoints()[i].opacity);
            }
            EXPECT_EQ(function.colourPoints().size(), measured.layer().function.colourPoints().size());
        }
    }
}

} // namespace
} // namespace tessera::accuracy
