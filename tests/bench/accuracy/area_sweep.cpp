// tests/bench/accuracy/area_sweep.cpp: see area_sweep.h.
#include "tests/bench/accuracy/area_sweep.h"

#include "bricking/store/store_reader.h"
#include "core/image/image_metrics.h"
#include "render/picture/render_scene.h"
#include "tests/bench/accuracy/report_cells.h"
#include "tests/bench/accuracy/setting.h"

#include <algorithm>
#include <map>

namespace tessera::accuracy {
namespace {

constexpr double kSteps[] = {1, 0.5, 0.25, 0.125, 0.0625};
constexpr int kUniform[] = {2, 4, 8, 16, 32, 64};

class Drawer {
  public:
    Drawer(const NamedScene& scene, const SweepOptions& options)
        : ram_("RAM", "--ram", options.ramBytes), gpu_("GPU memory", "--gpu-memory", options.gpuBytes),
          store_(scene.scene.volumes.at(0).path, ram_) {}

    RenderResult draw(const Scene& scene) {
        RenderOptions options;
        options.engine = EngineKind::native;
        options.searching = true;
        options.levels = LevelChoice::oneForAll; // pixels alone differ
        return renderScene(scene, store_, ram_, gpu_, options);
    }

  private:
    MemoryBudget ram_, gpu_;
    StoreReader store_;
};

Scene withSamples(Scene scene, int samples, double step) {
    scene.quality.pixels = {samples, PixelFilter::box, 0};
    scene.quality.stepVoxels = step;
    scene.quality.automaticStep = false;
    return scene;
}

} // namespace

AreaSweep runAreaSweep(const NamedScene& scene, const SweepOptions& options) {
    AreaSweep sweep;
    sweep.scene = scene.name, sweep.about = scene.about;
    sweep.truthSamples = options.effort.quick ? 64 : 256;
    sweep.repeats = options.effort.quick ? 1 : 3;
    Drawer drawer(scene, options);
    Scene asked = scene.scene;
    const int most = options.effort.quick ? 64 : 160,
              longest = std::max(asked.imageSize.x, asked.imageSize.y);
    if (longest > most)
        asked.imageSize = glm::max(glm::ivec2(1), asked.imageSize * most / longest);
    asked.quality.fetch = Fetch::exact;
    asked.quality.maxError.reset();
    sweep.imageSize = asked.imageSize;
    Scene one = asked;
    one.quality.pixels.samples = 1;
    const RenderResult found = drawer.draw(one); // the step that it takes by itself
    sweep.stepVoxels = found.stepVoxels;
    asked.quality.integrator = found.integrator;
    Scene best =
        withSamples(asked, sweep.truthSamples,
                    std::max(1.0 / 64, std::min(sweep.stepVoxels, kSteps[std::size(kSteps) - 1]) / 2));
    best.quality.pixels.seed = 1; // not that of any other
    const Image truth = drawer.draw(best).image;
    const auto measure = [&](const std::string& method, const std::string& setting, const Scene& now) {
        AreaPoint point{method, setting, 0, 1, 0, 0};
        for (int turn = 0; turn < sweep.repeats; ++turn) {
            const RenderResult r = drawer.draw(now);
            const double ms = 1000 * r.secondsDrawing;
            point.ms = turn == 0 ? ms : std::min(point.ms, ms);
            if (turn > 0)
                continue;
            const ImageError e = measureError(r.image, truth);
            point.rms = e.rmse, point.p99 = e.luvP99, point.samples = r.pixels.taken;
        }
        sweep.points.push_back(point);
    };
    for (const double step : kSteps)
        if (!options.effort.quick || step >= 0.25)
            measure("one ray, shorter steps", "step " + fractionText(step), withSamples(asked, 1, step));
    for (const int samples : kUniform)
        if (!options.effort.quick || samples <= 8)
            measure("uniform samples", std::to_string(samples) + " samples",
                    withSamples(asked, samples, sweep.stepVoxels));
    measure("auto", "auto", withSamples(asked, PixelSampling::kAutomatic, sweep.stepVoxels));
    return sweep;
}

bench::Report areaSection(const std::vector<AreaSweep>& sweeps) {
    bench::Report report;
    report.name = "pixels";
    report.title = "Samples of a pixel";
    const AreaSweep like = sweeps.empty() ? AreaSweep() : sweeps.front();
    int most = 0;
    for (const AreaSweep& sweep : sweeps)
        most = std::max({most, sweep.imageSize.x, sweep.imageSize.y});
    report.text = {
        "What a pixel should show is the mean over its area. The truth here is the mean of " +
        std::to_string(like.truthSamples) +
        " samples of each pixel through the finest level, with half of the shortest step and exact "
        "fetches; pictures have at most " +
        std::to_string(most) +
        " pixels an axis and are drawn by the native engine. *one ray*: through each pixel's middle, "
        "with shorter and shorter steps; *uniform*: as many samples of every pixel, at the step that "
        "the scene takes by itself; *auto*: samples where pixels need them. Times are of drawing "
        "alone" +
        std::string(like.repeats > 1 ? ", the least of " + std::to_string(like.repeats) : "") + "."};
    bench::Table table{"pixels",
                       "Error against the mean over pixels' areas, and time:",
                       {"scene", "method", "setting", "samples a pixel", "ms", "rms", "L*u*v* p99"},
                       {},
                       true};
    for (const AreaSweep& sweep : sweeps) {
        bench::Plot plot{"area_" + sweep.scene,
                         sweep.scene +
                             ": error against the mean over pixels' areas and time; to the left and below "
                             "is better.",
                         "time to draw, ms",
                         "rms error, linear",
                         true,
                         true,
                         {},
                         true};
        std::map<std::string, bench::Plot::Curve> curves;
        for (const AreaPoint& p : sweep.points) {
            table.rows.push_back({sweep.scene, p.method, p.setting, p.samples, p.ms, p.rms, p.p99});
            bench::Plot::Curve& curve = curves[p.method];
            curve.label = p.method;
            if (p.rms > 0)
                curve.points.emplace_back(p.ms, p.rms);
        }
        for (auto& [method, curve] : curves)
            plot.curves.push_back(std::move(curve));
        report.plots.push_back(std::move(plot));
    }
    report.tables = {std::move(table)};
    return report;
}

} // namespace tessera::accuracy
