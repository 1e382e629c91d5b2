// render/picture/draw_scene.cpp: see draw_scene.h.
#include "render/picture/draw_scene.h"

#include "core/base/error.h"
#include "render/plan/plan_again.h"
#include "render/verify/error_goal.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <variant>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

/// A first picture is drawn with: a sample of the coarse level a step, not two, and nothing tried or
/// estimated.
Scene firstScene(const Scene& scene) {
    Scene first = scene;
    first.quality.stepVoxels = std::min(2 * scene.quality.stepVoxels, 16.0);
    first.quality.automaticStep = false;
    first.quality.maxError.reset();
    first.quality.pixels.samples = 1;
    return first;
}

/// Seconds that the picture itself takes, from how long the first one took: it takes as many more samples as
/// its level and step are finer. What is tried and estimated besides takes about a third of it again.
double secondsAfterFirst(const RenderResult& first, const Scene& scene) {
    const double samplesPerSample = (1 << first.level) * first.stepVoxels / scene.quality.stepVoxels;
    return 1.3 * samplesPerSample * 1e-3 * first.work.marchMs;
}

} // namespace

EngineInstance::EngineInstance(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu)
    : maker(options.engine, options.device, options.threads), kind(maker.kind()), reason(maker.reason()),
      engine(maker.make(ram, gpu)) {}

RenderResult drawScene(const Scene& scene, ScenePlan& p, const EngineInstance& made,
                       const FrameContext& context, const RenderOptions& options, const FrameReuse& reuse,
                       const Planned& planned) {
    RenderResult result;
    const auto start = Clock::now();
    Engine& engine = *made.engine;
    const TextureLimits limits = engine.limits();
    const Engine::About about = engine.about();
    result.device = about.device;
    result.glVersion = about.version;
    result.engine = made.kind;
    result.engineReason = made.reason;
    Progress& progress = context.progress;
    progress.stage("reading statistics and choosing levels");
    const EngineTraits& traits = traitsOf(made.kind);
    const bool first = options.onFirstPicture && traits.quick;
    const bool decides = // how fine it is, by what is measured
        scene.quality.maxError.value_or(0) > 0 && options.verify != Verify::none && about.choosesSteps;
    Scene picture = scene; // the first that is drawn in full
    if (decides)
        picture.quality.maxError = ErrorGoal(*scene.quality.maxError).ofRays();
    const Scene coarse = first ? firstScene(scene) : picture;
    p = planned(coarse, limits, first ? LevelChoice::quick : options.levels,
                pictureBytesPerPixel(made.kind, scene.quality.pixels) +
                    (scene.lighting.surfaceOcclusion
                         ? SurfaceLight::bytesPerPixel(scene.quality.pixels.samples != 1)
                         : 0));
    p.view.shadowQuality.layers = options.shadowLayers;
    std::optional<SamplesDrawn> ofOnePicture; // that no other goes on from
    if (first) {
        RenderResult quick;
        RenderOptions plain = options;
        plain.checking = plain.searching = false;
        plain.verify = Verify::none;
        FrameReuse nothing;
        nothing.first = true;
        drawPicture(coarse, p, engine, context, plain, {}, ofOnePicture, quick, nothing);
        options.onFirstPicture(quick.image, secondsAfterFirst(quick, scene));
        quick = {};
        engine.close();
        progress.stage("choosing levels");
        chooseAgain(p, picture, limits, context, options.levels);
    }
    result.camera = p.view.camera;
    result.tableRelativeError = p.volume.table.relativeError;
    result.levelsOnPurpose = options.levels != LevelChoice::perBrick || traits.exact;
    result.cells = cellCount(p.volume.statistics.cells);
    const SceneVolume& volume = scene.volumes.front();
    const ValueSummary values = summarise(p.volume.statistics, p.info(), volume.unit);
    const auto* const preset = std::get_if<std::string>(&volume.transferFunction);
    result.takenAsHu = preset && *preset != "auto" && !values.isHu;
    result.lowest = values.lowest;
    result.highest = values.highest;
    result.secondsPreparing = std::chrono::duration<double>(Clock::now() - start).count();

    if (decides)
        drawUntilGoodEnough(scene, p, engine, context, options, result);
    else
        drawPicture(scene, p, engine, context, options, {}, ofOnePicture, result, reuse);
    if (traits.exact)
        result.level = 0;
    result.occupiedCells = scene.quality.skipping && p.volume.occupancy.exists()
                               ? p.volume.occupancy.occupiedCells()
                               : result.cells;
    result.window = p.volume.look.window;
    return result;
}

} // namespace tessera
