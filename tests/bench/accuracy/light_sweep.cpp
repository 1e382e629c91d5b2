// tests/bench/accuracy/light_sweep.cpp: see light_sweep.h.
#include "tests/bench/accuracy/light_sweep.h"

#include "bricking/store/store_reader.h"
#include "core/base/threads.h"
#include "core/image/image_metrics.h"
#include "render/backends/reference/reference.h"
#include "render/picture/render_scene.h"
#include "render/plan/planner.h"
#include "tests/bench/accuracy/report_cells.h"

#include <algorithm>
#include <map>

namespace tessera::accuracy {
namespace {

constexpr double kStep = 0.25;  // short, so that light is what errs
constexpr int kTruthRays = 320; // of an icosahedron: within 0.001 of 4096

class Studio {
  public:
    Studio(const NamedScene& scene, const SweepOptions& options)
        : ram_("RAM", "--ram", options.ramBytes), gpu_("GPU memory", "--gpu-memory", options.gpuBytes),
          store_(scene.scene.volumes.at(0).path, ram_) {}

    RenderResult draw(const Scene& scene, int shadowLayers) {
        RenderOptions options;
        options.engine = EngineKind::native;
        options.levels = LevelChoice::oneForAll; // light alone differs
        options.shadowLayers = shadowLayers;
        return renderScene(scene, store_, ram_, gpu_, options);
    }
    Image reference(const Scene& scene) {
        const Planner p = planView(scene, store_, ram_, 0);
        BrickCache cache(
            store_, ram_,
            std::max(4 * BrickCache::floorBytes(p.info(), 2 * defaultThreads()), ram_.freeBytes() / 2), 0);
        const ReferenceInput input{
            &cache,         &p.info(), &p.layer().function, scene.shading, &p.layer().statistics, 1,
            scene.surfaces, {},        scene.lighting,      p.view.camera};
        const auto values =
            renderReference(input, referenceRays(p.view.camera, p.info(), scene.imageSize), 0);
        Image image(scene.imageSize);
        std::transform(values.begin(), values.end(), image.pixels.begin(),
                       [](const glm::dvec4& v) { return glm::vec4(v); });
        return image;
    }

  private:
    MemoryBudget ram_, gpu_;
    StoreReader store_;
};

Lighting withoutVoxelLight(Lighting lighting) {
    lighting.occlusion.reset();
    for (Light& light : lighting.lights)
        light.shadow = false;
    return lighting;
}

} // namespace

std::optional<LightSweep> runLightSweep(const NamedScene& scene, const SweepOptions& options) {
    if (lightChannels(scene.scene.lighting) == 0 || !scene.scene.shading.on)
        return std::nullopt;
    const bool quick = options.effort.quick;
    LightSweep sweep;
    sweep.scene = scene.name;
    sweep.repeats = quick ? 1 : 3;
    Scene asked = scene.scene;
    const int most = quick ? 12 : 32, longest = std::max(asked.imageSize.x, asked.imageSize.y);
    if (longest > most)
        asked.imageSize = glm::max(glm::ivec2(1), asked.imageSize * most / longest);
    sweep.imageSize = asked.imageSize;
    asked.quality.fetch = Fetch::exact;
    asked.quality.maxError.reset();
    asked.quality.pixels.samples = 1;
    asked.quality.stepVoxels = kStep;
    asked.quality.automaticStep = false;
    Studio studio(scene, options);

    Scene best = asked;
    if (best.lighting.occlusion) {
        best.lighting.occlusion->rays = std::max(kTruthRays, best.lighting.occlusion->rays);
        sweep.truthRays = best.lighting.occlusion->rays;
    }
    const Image truth = studio.reference(best);
    Scene plain = asked;
    plain.lighting = withoutVoxelLight(plain.lighting);
    sweep.withoutLight =
        measureError(studio.draw(plain, DeepShadowMap::kLayers).image, studio.reference(plain)).rmse;

    const auto measure = [&](const char* axis, const std::string& setting, const Lighting& lighting,
                             int layers = DeepShadowMap::kLayers) {
        Scene now = asked;
        now.lighting = lighting;
        LightPoint point{axis, setting, 0, 0, 0, 0, 0};
        for (int turn = 0; turn < sweep.repeats; ++turn) {
            const RenderResult r = studio.draw(now, layers);
            if (!r.light)
                return;
            point.seconds = turn == 0 ? r.light->seconds : std::min(point.seconds, r.light->seconds);
            point.bytes = static_cast<double>(r.light->planeBytes + r.light->mapBytes);
            const ImageError e = measureError(r.image, truth);
            point.rms = e.rmse, point.bias = e.bias, point.p99 = e.luvP99;
        }
        sweep.points.push_back(point);
    };
    const Lighting& as = asked.lighting;
    measure("as it is", "", as);
    if (const auto& occlusion = as.occlusion) {
        for (const int rays :
             quick ? std::vector<int>{8, 32} : std::vector<int>{4, 8, 16, 20, 32, 64, 80, 128, 320}) {
            Lighting now = as;
            now.occlusion->rays = rays;
            measure("rays", std::to_string(rays) + " rays", now);
        }
        for (const double part :
             quick ? std::vector<double>{0.5} : std::vector<double>{0.125, 0.25, 0.5, 0.75, 1}) {
            Lighting now = as;
            now.occlusion->radiusMm = part * occlusion->radiusMm;
            measure("radius", number(now.occlusion->radiusMm) + " mm", now);
        }
    }
    if (!castingLights(as.lights).empty())
        for (const int layers : quick ? std::vector<int>{2} : std::vector<int>{2, 3, 4, 6, 8})
            measure("layers", std::to_string(layers) + " layers", as, layers);
    for (const int level : quick ? std::vector<int>{1} : std::vector<int>{0, 1, 2}) {
        Lighting now = as;
        now.finestLevel = level;
        measure("finest level", "level " + std::to_string(level), now);
    }
    return sweep;
}

bench::Report lightSection(const std::vector<LightSweep>& sweeps) {
    bench::Report report;
    report.name = "light";
    report.title = "Light of voxels";
    const LightSweep like = sweeps.empty() ? LightSweep() : sweeps.front();
    report.text = {"Occlusion and shadows are kept of voxels; the reference sends rays of light of its own "
                   "from every place that "
                   "is seen, through level 0, in double. Pictures of " +
                   std::to_string(like.imageSize.x) + " x " + std::to_string(like.imageSize.y) +
                   " pixels are drawn by the native engine with steps of 1/4 voxel, all bricks at one level, "
                   "the finest that "
                   "fits, and one thing of the scene's light is changed at a time. *rays*: of occlusion, "
                   "whose truth has " +
                   std::to_string(like.truthRays) +
                   " (0: the scene has none); *radius*: how far they look, the truth's being the scene's "
                   "own; *layers*: places "
                   "that deep shadow maps keep of a ray; *finest level*: finer bricks take light of this "
                   "one. *s*: computing the "
                   "light on all processors" +
                   (like.repeats > 1 ? ", the least of " + std::to_string(like.repeats) : std::string()) +
                   "; *without*: rms of the same picture without light of voxels, against a truth without "
                   "it: what steps and "
                   "the rest err by."};
    bench::Table table{"light",
                       "Error of light, and the time that it takes:",
                       {"scene", "axis", "setting", "s", "MiB", "rms", "bias", "L*u*v* p99", "without"},
                       {},
                       true};
    for (const LightSweep& sweep : sweeps) {
        bench::Plot plot{"light_" + sweep.scene,
                         sweep.scene +
                             ": error of light and the time that it takes; to the left and below is better.",
                         "time to compute light, s",
                         "rms error, linear",
                         true,
                         true,
                         {},
                         true};
        std::map<std::string, bench::Plot::Curve> curves;
        for (const LightPoint& p : sweep.points) {
            constexpr double kMiB = 1024.0 * 1024.0;
            table.rows.push_back({sweep.scene, p.axis, p.setting, p.seconds, p.bytes / kMiB, p.rms, p.bias,
                                  p.p99, sweep.withoutLight});
            bench::Plot::Curve& curve = curves[p.axis];
            curve.label = p.axis;
            if (p.rms > 0 && p.seconds > 0)
                curve.points.emplace_back(p.seconds, p.rms);
        }
        for (auto& [axis, curve] : curves)
            plot.curves.push_back(std::move(curve));
        report.plots.push_back(std::move(plot));
    }
    report.tables = {std::move(table)};
    return report;
}

} // namespace tessera::accuracy
