// render/picture/draw_scene.cpp: see draw_scene.h.
#include "render/picture/draw_scene.h"

#include "core/base/error.h"
#include "core/base/progress.h"
#include "render/geometry/mesh_caster.h"
#include "render/labels/slice_labels.h"
#include "render/parts/part_caster.h"
#include "render/picture/measure_picture.h"
#include "render/picture/ray_renderer.h"
#include "render/picture/render_scene.h"
#include "render/pixels/noise_filter.h"
#include "render/plan/fusion.h" // FurtherVolume
#include "render/plan/planner.h"
#include "render/plan/step_search.h" // kFinestStep
#include "render/renderer.h"
#include "render/verify/error_goal.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <variant>

namespace tessera {

Scene firstScene(const Scene& scene) {
    Scene first = scene;
    first.quality.stepVoxels = std::min(2 * scene.quality.stepVoxels, 16.0);
    first.quality.automaticStep = false;
    first.quality.maxError.reset();
    first.quality.pixels.samples = 1;
    return withoutReflections(std::move(first));
}

namespace {

using Clock = std::chrono::steady_clock;

/// Seconds for the picture itself, estimated from the time of the first one: it takes as many more samples as
/// its level and step are finer. Trials and estimates besides take about a third of it again.
double secondsAfterFirst(const RenderResult& first, const Scene& scene) {
    const double samplesPerSample = (1 << first.level) * first.stepVoxels / scene.quality.stepVoxels;
    return 1.3 * samplesPerSample * 1e-3 * first.work.marchMs;
}

/// RAM of a picture.
std::size_t bytesPerPixelOf(EngineKind engine, const Scene& scene, const RenderOptions& options) {
    const int samples = scene.quality.pixels.samples;
    std::size_t bytes = pictureBytesPerPixel(engine, scene.quality.pixels) + meshBytesPerPixel(scene);
    if (scene.lighting.surfaceOcclusion)
        bytes += SurfaceLight::bytesPerPixel(samples != 1, drawsMeshes(scene));
    if (scene.lighting.surfaceOcclusion || reflects(scene)) // sums of many samples have two floats each
        bytes += PixelSums::bytesPerPixel(samples) - PixelSums::bytesPerPixel(1);
    if (reflects(scene))
        bytes += Reflections::bytes(scene.imageSize, samples != 1) / rayCount(scene.imageSize) + 1;
    if (scene.lighting.transport)
        bytes += sizeof(std::uint32_t); // numbers of samples
    if (scene.lighting.transport && options.layers.paths)
        bytes += PictureLayers::bytesPerPixel(samples);
    if (options.layers.errors)
        bytes += sizeof(glm::vec4);
    if (options.tiles)
        bytes += sizeof(glm::vec2) + sizeof(glm::vec4); // the middles of pixels, offsets of their means
    if (options.group)
        bytes += PartCaster::bytesPerRay();
    if (scene.quality.pixels.denoise)
        bytes += noiseFilterBytes(scene.imageSize, options.threads) / rayCount(scene.imageSize) + 1;
    return bytes;
}

/// The pixels of a picture's largest tile, and those around it that it needs.
glm::ivec2 largestTile(const Scene& scene, const PictureTiles& tiles) {
    const int around =
        scene.lighting.surfaceOcclusion ? SurfaceLight::margin(*scene.lighting.surfaceOcclusion) : 0;
    return glm::min(glm::ivec2(tiles.side() + 2 * around), scene.imageSize);
}

/// A plan does not depend on how a picture is drawn, as long as the budgets have room for all of its pixels.
Planner planInTiles(const std::function<Planner(const PixelMemory&)>& planned, const PixelMemory& tile) {
    try {
        Planner p = planned(tile.bytesPerPixel);
        p.drawInParts(tile);
        return p;
    } catch (const InputError&) {
        return planned(tile);
    }
}

/// Samples until every pixel's standard error is within the request, at any cost.
PixelGoal pixelGoal(double lightness) {
    PixelGoal goal;
    goal.target.linear *= lightness / goal.target.lightness;
    goal.target.lightness = lightness;
    goal.rays = SIZE_MAX / 4;
    goal.most = PixelSampling::kMostDecided;
    return goal;
}

/// True if measurements decide the fineness of the picture.
bool decides(const Scene& scene, const RenderOptions& options) {
    return scene.quality.maxError.value_or(0) > 0 && options.verify != Verify::none;
}

/// Lays the labels over a slice. Returns what they do to a pixel; empty: nothing.
PixelOver layLabelsOver(const FrameTask& task, RenderResult& result) {
    const FramePlan& p = task.plan;
    SliceLabels* const labels = p.layer().sliceLabels.get();
    if (!labels)
        return {};
    task.context.progress.stage("laying labels over the slice");
    const auto drawing = Clock::now();
    const PlanePlaces places = planePlaces(p.view.camera, task.scene.slice, p.info(), result.image.size);
    const SliceLabels::Drawn drawn = labels->layOver(result.image.pixels, places, 1, task.options.shares);
    result.labels = {labels->table().labels.size(), labels->shownLabels(), 0, {drawn.values}, drawn.level};
    result.secondsDrawing += secondsSince(drawing);
    return [labels, places](const glm::ivec2& pixel) { return labels->overPixel(pixel, places); };
}

/// Of all bricks of a plan, once each: what tiles in passes take, whichever of them a process has drawn.
std::uint64_t bytesOfBricks(const FramePlan& p) {
    std::uint64_t bytes = 0;
    for (std::size_t level = 0; level < kLevelCount; ++level)
        bytes += p.layer().selection.counts[level] *
                 cellCount(glm::ivec3(kBrickExtent >> static_cast<int>(level))) *
                 bytesPerValue(p.info().type);
    for (const auto& volume : p.further)
        bytes += bytesOfBricks(volume->plan);
    return bytes;
}

/// Draws a plan, and measures how wrong that is. Returns whether it went on from the round before.
bool drawFrame(Renderer& renderer, const FrameTask& task, RenderResult& result) {
    const Scene& scene = task.scene;
    Image added; // to the picture, once its errors are known: they are those without it
    const bool wentOn = renderer.draw(task, result, added);
    const PixelOver over = layLabelsOver(task, result);
    const auto checking = Clock::now();
    PictureTiles* const tiles = task.options.tiles;
    if (renderer.about().measures && task.options.verify != Verify::none && (!tiles || tiles->finishes()) &&
        (!scene.lighting.transport || scene.quality.pixels.denoise)) {
        task.context.progress.stage("measuring the picture's errors");
        const bool full = scene.quality.maxError.value_or(0) > 0;
        const std::unique_ptr<PixelSource> pixels = renderer.pixels(task);
        const DrawnPicture drawn{
            scene,
            tiles ? DrawnPixels{scene.imageSize, tiles->shown(),
                                [tiles](const glm::ivec2& at) { return tiles->colour(at); },
                                task.plan.view.drawnSize()}
                  : pixelsOf(result.image),
            tiles && pixels && pixels->about().passes ? bytesOfBricks(task.plan) : result.work.bytesUploaded,
            result.pixels.taken,
            full ? Verify::full : task.options.verify,
            task.round.number,
            full ? ErrorGoal::kMostRounds : 1,
            task.options.slicing,
            task.options.verify == Verify::full,
            over};
        if (pixels)
            result.measured = measurePicture(drawn, *pixels, task.context.ram);
    }
    for (std::size_t i = 0; i < added.pixels.size(); ++i)
        result.image.pixels[i] = glm::max(result.image.pixels[i] + added.pixels[i], glm::vec4(0));
    result.secondsChecking += secondsSince(checking);
    if (const std::string fault = renderer.fault(); !fault.empty())
        throw Error(fault);
    return wentOn;
}

/// Pictures, each finer than the one before, until the measured error is within the scene's request, or
/// nothing is left to gain, which the result says.
void drawUntilGoodEnough(Renderer& renderer, const Scene& scene, Planner& p, const FrameContext& context,
                         const RenderOptions& options, RenderResult& result) {
    ErrorGoal goal(*scene.quality.maxError);
    Scene now = scene;
    double lastTarget = std::numeric_limits<double>::max(), lastTaken = 0;
    for (int round = 0;; ++round) {
        const double target = goal.ofSamples();
        now.quality.maxError = goal.ofRays();
        if (round > 0) {
            renderer.close();
            context.progress.stage("choosing finer levels");
            p.chooseAgain(now, renderer.limits(), context, options.levels);
        }
        const bool wentOn =
            drawFrame(renderer, {now, p, context, options, {round, pixelGoal(target)}}, result);
        result.rounds = round + 1;
        const PictureMeasurement& m = *result.measured;
        const bool finest = result.bricksOfLevel[0] == result.residentBricks &&
                            (p.view.part.flat || result.stepVoxels <= StepSearch::kFinestStep);
        const bool most = scene.quality.pixels.samples != PixelSampling::kAutomatic ||
                          (wentOn && target < lastTarget && result.pixels.taken <= lastTaken);
        lastTarget = target, lastTaken = result.pixels.taken;
        const auto verdict = goal.judge(m.all, m.sampling, m.rays, finest, most);
        result.shortfall = goal.shortfall();
        if (!m.whyNot.empty())
            result.shortfall += ": " + m.whyNot;
        if (verdict != ErrorGoal::Verdict::goOn)
            return;
    }
}

/// A preset took the values for HU because they resemble HU: no file said so.
bool takesAsHu(const FramePlan& p, const SceneVolume& volume) {
    const auto* const preset = std::get_if<std::string>(&volume.transferFunction);
    return preset && *preset != "auto" && !summarise(p.layer().statistics, p.info(), volume.unit).isHu;
}

std::unique_ptr<Renderer> rendererOf(const EngineMaker& maker, MemoryBudget& ram, MemoryBudget& gpu) {
    const EngineTraits& traits = traitsOf(maker.kind());
    if (traits.renderer)
        return traits.renderer(maker.input(ram, gpu));
    return std::make_unique<RayRenderer>(maker.make(ram, gpu), traits.exact);
}

} // namespace

RendererInstance::RendererInstance(const RenderOptions& options, MemoryBudget& ram, MemoryBudget& gpu)
    : maker(options.engine, options.device, options.threads), kind(maker.kind()), reason(maker.reason()),
      renderer(rendererOf(maker, ram, gpu)) {}

RenderResult drawScene(const Scene& scene, Planner& p, const RendererInstance& made,
                       const FrameContext& context, const RenderOptions& options, const FrameReuse& reuse,
                       const Planned& planned) {
    RenderResult result;
    const auto start = Clock::now();
    Renderer& renderer = *made.renderer;
    const TextureLimits limits = renderer.limits();
    const Engine::About about = renderer.about();
    result.device = about.device;
    result.glVersion = about.version;
    result.engine = made.kind;
    result.engineReason = made.reason;
    Progress& progress = context.progress;
    progress.stage("reading statistics and choosing levels");
    const EngineTraits& traits = traitsOf(made.kind);
    const bool first = options.onFirstPicture && traits.quick;
    const bool fine = decides(scene, options) && about.measures;
    Scene picture = scene; // the first that is drawn in full
    if (fine)
        picture.quality.maxError = ErrorGoal(*scene.quality.maxError).ofRays();
    const Scene coarse = first ? firstScene(scene) : picture;
    const LevelChoice levels = first ? LevelChoice::quick : options.levels;
    const PixelMemory pixels = bytesPerPixelOf(made.kind, scene, options);
    TESSERA_CHECK(!options.tiles || !(first || fine || traits.renderer));
    if (options.tiles)
        p = planInTiles([&](const PixelMemory& of) { return planned(coarse, limits, levels, of); },
                        {pixels.bytesPerPixel, largestTile(scene, *options.tiles)});
    else
        p = planned(coarse, limits, levels, pixels);
    p.setShadowLayers(options.shadowLayers);
    if (first) {
        RenderResult quick;
        RenderOptions plain = options;
        plain.checking = plain.searching = false;
        plain.layers = {};
        plain.kept = nullptr;
        plain.verify = Verify::none;
        FrameReuse nothing;
        nothing.first = true;
        drawFrame(renderer, {coarse, p, context, plain, {}, nothing}, quick);
        options.onFirstPicture(quick.image, secondsAfterFirst(quick, scene));
        quick = {};
        renderer.close();
        progress.stage("choosing levels");
        if (p.isCoarse) {
            p = Planner(); // gives back its memory
            p = planned(picture, limits, options.levels, pixels);
            p.setShadowLayers(options.shadowLayers);
        } else {
            p.chooseAgain(picture, limits, context, options.levels);
        }
    }
    reportVolume(p, scene, result);
    result.takenAsHu = takesAsHu(p, scene.volumes.front());
    if (traits.exact)
        result.hulls = {0, 0}; // it takes no steps
    result.levelsOnPurpose = options.levels != LevelChoice::perBrick || traits.exact;
    result.secondsPreparing = std::chrono::duration<double>(Clock::now() - start).count();

    if (fine)
        drawUntilGoodEnough(renderer, scene, p, context, options, result);
    else
        drawFrame(renderer, {scene, p, context, options, {}, reuse}, result);
    renderer.endFrame();
    if (p.shared)
        result.part = p.shared->parts.box(p.shared->mine());
    result.occupiedCells = scene.quality.skipping && p.layer().occupancy.exists()
                               ? p.layer().occupancy.occupiedCells()
                               : result.cells;
    return result;
}

} // namespace tessera
