// tests/bench/lod/calibration.cpp: see calibration.h: draws the cases and finds the truth.
#include "tests/bench/lod/calibration.h"
#include "core/base/progress.h"

#include "render/picture/render_scene.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace tessera::bench {
namespace {

constexpr std::size_t kAmpleBytes = std::size_t{1} << 30;
constexpr std::array<View, 3> kViews = {View::anterior, View::left, View::superior};

Scene sceneOf(const BenchVolume& volume, const std::string& preset, View view, bool lit, int pixels) {
    Scene scene;
    scene.volumes = {{volume.store, preset}};
    scene.camera =
        FittedView{view, view == View::left ? Projection::parallel : Projection::perspective, Fit::shown};
    scene.shading.on = lit;
    scene.imageSize = glm::ivec2(pixels);
    scene.quality.automaticStep = true;
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    return scene;
}

RenderResult drawn(const Workbench& bench, const Scene& scene, MemoryBudget& gpu) {
    MemoryBudget ram("RAM", "--ram", bench.ramBytes);
    const StoreReader store(scene.volumes.front().path, ram);
    RenderOptions options;
    options.engine = EngineKind::native;
    options.counting = false;
    options.searching = options.checking = true;
    options.verify = Verify::full;
    return renderScene(scene, store, ram, gpu, options);
}

/// Draws a case; the camera is fitted once, by the first.
CalibrationCase drawnCase(const Workbench& bench, Scene& scene, const CalibrationCase& like,
                          const std::string& setting, std::size_t budgetBytes, std::optional<double> asked) {
    CalibrationCase c = like;
    c.setting = setting;
    c.asked = asked;
    c.budgetBytes = budgetBytes;
    scene.quality.maxError = asked;
    MemoryBudget gpu("GPU memory", "--gpu-memory", budgetBytes);
    const auto start = std::chrono::steady_clock::now();
    RenderResult r = drawn(bench, scene, gpu);
    c.seconds = secondsSince(start);
    scene.camera = r.camera;
    if (r.errors)
        c.predictedP99 = r.errors->luvP99();
    if (r.measured) {
        c.measured = r.measured->all;
        c.samples = r.measured->sampling;
        c.rays = r.measured->rays;
        c.whyNot = r.measured->whyNot;
        c.bytes = r.measured->bytesRead;
    }
    c.shortfall = r.shortfall;
    c.samplesPerPixel = r.pixels.taken;
    c.stepVoxels = r.stepVoxels;
    c.level = r.level;
    c.rounds = r.rounds;
    c.bytes += r.work.bytesUploaded;
    c.image = std::move(r.image);
    return c;
}

std::string told(const CalibrationCase& c) {
    char text[200];
    const auto& p99 = c.measured.luvP99;
    std::snprintf(text, sizeof text,
                  "true p99 %.3g, measured %.3g (%.3g to %.3g, at most %.3g), predicted %.3g, %.1f s%s",
                  c.is.luvP99, p99 ? p99->value : -1, p99 ? p99->low : -1, p99 ? p99->high : -1,
                  c.measured.luvP99Bound.value_or(-1), c.predictedP99, c.seconds,
                  c.shortfall.empty() ? "" : ", not reached");
    return c.setting + ": " + text;
}

} // namespace

void calibrate(const Workbench& bench, const BenchVolume& volume, int pixels, const AreaTruthEffort& effort,
               const std::vector<double>& maxErrors, int& turn, std::vector<CalibrationCase>& cases,
               std::vector<CalibrationScene>& scenes) {
    for (const std::string& preset : volume.presets) {
        const View view = kViews[static_cast<std::size_t>(turn) % kViews.size()];
        CalibrationCase like;
        like.volume = volume.name;
        like.preset = preset;
        like.view = viewNames()[static_cast<std::size_t>(view)];
        like.seenBefore = volume.seenBefore;
        like.lit = turn++ % 2 == 1;
        Scene scene = sceneOf(volume, preset, view, like.lit, pixels);
        const std::size_t floor = floorNamed([&](MemoryBudget& gpu) { (void)drawn(bench, scene, gpu); });
        std::vector<CalibrationCase> here;
        const auto draw = [&](const std::string& setting, std::size_t bytes,
                              std::optional<double> asked = {}) {
            here.push_back(drawnCase(bench, scene, like, setting, bytes, asked));
        };
        draw("ample", kAmpleBytes);
        // A picture with all its bricks takes floor and bytes; between nothing and that levels are coarse.
        const double all = static_cast<double>(here.front().bytes) / static_cast<double>(floor) + 1;
        draw("floor", floor);
        draw("between", static_cast<std::size_t>(static_cast<double>(floor) * std::sqrt(all)));
        for (const double asked : maxErrors)
            draw("--max-error " + formatCell(asked), kAmpleBytes, asked);
        scene.quality.maxError.reset();
        const std::string name =
            volume.name + ", " + preset + ", " + like.view + (like.lit ? ", lit" : ", plain");
        scenes.push_back({name, areaTruth(scene, effort, bench.ramBytes)});
        const AreaTruth& truth = scenes.back().truth;
        bench.common.note(name + ": truth in " + formatNumber(truth.secondsNative, 3) + " s, noise " +
                          formatNumber(truth.noiseLuvP99, 2) + ", " + std::to_string(truth.noisy) + " of " +
                          std::to_string(truth.shown) + " pixels noisy; reference in " +
                          formatNumber(truth.secondsReference, 3) + " s, p99 " +
                          formatNumber(truth.referenceLuvP99, 2));
        for (CalibrationCase& c : here) {
            c.is = differenceTo(truth, c.image);
            c.image = {};
            bench.common.note(name + ", " + told(c));
            cases.push_back(std::move(c));
        }
        bench.done(name);
    }
}

} // namespace tessera::bench
