// render/picture/ray_renderer.cpp: see ray_renderer.h.
#include "render/picture/ray_renderer.h"

#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "render/exposure/exposed_caster.h"
#include "render/picture/picture.h"
#include "render/picture/ray_pixels.h"
#include "render/picture/rays_drawn.h"
#include "render/picture_tiles.h"
#include "render/pixels/kept_samples.h"
#include "render/pixels/noise_filter.h"
#include "render/plan/fusion.h"
#include "render/plan/overlooked_pixels.h"
#include "render/plan/planner.h"
#include "render/plan/step_search.h"
#include "render/renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

/// The smallest difference that eight bits can show.
constexpr double kDefaultStepError = 1.0 / 255;

/// The effect of steps and filtering on the picture.
/// @param image  none: it was drawn in tiles
PictureErrors estimate(StepSearch& search, const FrameTask& task, const Image& image) {
    const FramePlan& p = task.plan;
    const double most = brightest(task.scene.shading, task.scene.lighting, p.layer().function.materials());
    const bool areas = p.view.quality.pixels.samples != 1 || task.options.tiles;
    PictureErrors errors = areas ? search.errors(most) : search.errorsOf(image, most);
    if (p.chosen.predicted)
        errors.levelsLuvP99 = predictedOf(p).p99;
    return errors;
}

/// Of the rays that a caster has drawn.
PictureLayers::OfRays layersOf(const RayCaster& caster, const Image& colours, const FramePlan& p) {
    const std::span<const PathBeginning> beginnings = caster.beginnings();
    if (beginnings.size() != colours.pixels.size())
        throw badFile("--layers", "an engine that keeps where paths begin: native or mirror", "another");
    return layersOfRays(beginnings, colours, p);
}

/// After a round of paths.
void tellNoise(const AreaPicture& picture, Progress& progress) {
    if (picture.noise())
        progress.detail(", " + std::to_string(picture.roundsDone()) +
                        (picture.roundsDone() == 1 ? " round, noise " : " rounds, noise ") +
                        digitsOf(*picture.noise(), 2));
}

} // namespace

struct RayRenderer::Samples {
    RaysDrawn rays;
    AreaPicture picture;
    std::unique_ptr<DeferredLight> light; // of isosurfaces, where there is any
};

RayRenderer::RayRenderer(std::unique_ptr<Engine> engine, bool exact)
    : engine_(std::move(engine)), exact_(exact) {}

RayRenderer::~RayRenderer() = default;

void RayRenderer::endFrame() {
    samples_.reset();
    caster_.reset();
}

void RayRenderer::close() {
    caster_.reset();
    engine_->close();
}

std::unique_ptr<PixelSource> RayRenderer::pixels(const FrameTask& task) {
    return std::make_unique<RayPixels>(task, *engine_, caster_, stepOfMeans_);
}

Image RayRenderer::drawSome(const FrameTask& task, const Rays& rays) {
    Work work; // not the picture's
    caster_->begin(rays);
    drawToTheEnd(*caster_, *engine_, task.plan, task.options.slicing, work);
    return caster_->image();
}

/// The window of sums that the scene leaves open follows from some rays, with a step of a voxel.
void RayRenderer::settleExposure(const FrameTask& task) {
    Planner& p = task.plan;
    p.setExposure(exposureOf(task.scene.mode, task.scene.valueColour, task.scene.window).window);
    if (p.view.exposure->window || task.scene.mode == Mode::absorption)
        return;
    const double asked = p.view.quality.stepVoxels;
    p.setStep(1);
    const glm::ivec2 size = glm::min(p.view.imageSize, glm::ivec2(PixelGrid::kMostPixels));
    std::vector<glm::vec2> places;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            places.push_back((glm::vec2(x, y) + 0.5f) * glm::vec2(p.view.imageSize) / glm::vec2(size));
    Rays rays = raysOf(p);
    rays.places = places;
    rays.arraySize = size;
    drawSome(task, rays);
    p.setExposure(caster_->window());
    p.setStep(asked);
}

/// The trials follow from the scene and its plan, not from the engine.
void RayRenderer::chooseStep(const FrameTask& task, StepSearch& search, RenderResult& result) {
    using Goal = StepSearch::Goal;
    const Quality& asked = task.scene.quality;
    const bool searches = task.options.searching || task.options.checking;
    if (asked.sampling == Sampling::hulls) {
        if (asked.hulls.samples == Hulls::kAutomatic && searches)
            search.chooseHullSamples();
        return;
    }
    const bool chosen = asked.automaticStep && searches;
    if (asked.maxError.value_or(0) > 0)
        search.chooseStep({Goal::Measure::luvP99, *asked.maxError - predictedOf(task.plan).p99});
    else if (chosen)
        search.chooseStep({Goal::Measure::rms, kDefaultStepError});
    constexpr double kBehindGlass = 1; // voxels; what is there ends no ray of the trials
    const std::vector<SurfaceLook>& surfaces = task.plan.layer().optics.surfaces;
    if (task.plan.view.quality.stepVoxels > kBehindGlass &&
        std::any_of(surfaces.begin(), surfaces.end(),
                    [](const SurfaceLook& s) { return s.reflection && s.reflection->transmits; }))
        task.plan.setStep(kBehindGlass);
    const bool decide = task.plan.view.quality.pixels.samples == PixelSampling::kAutomatic;
    if (chosen && decide && !asked.maxError)
        result.stepOfMeans =
            stepOfMeans(task.plan, kDefaultStepError, [&](const Rays& rays) { return drawSome(task, rays); });
}

void RayRenderer::takeKept(const FrameTask& task, const RaysDrawn& these, AreaPicture& picture,
                           RenderResult& result) {
    if (!task.options.kept)
        return;
    const FramePlan& p = task.plan;
    result.pixels.ofEarlierRuns =
        task.options.kept->restore(picture, p.view.quality.pixels.samples, these.parts(p, exact_));
    task.context.progress.startAt(picture.share(0));
}

/// Every pixel the mean of its samples. Returns whether it went on from earlier ones.
/// @param light  none: there is none; else its addition is another picture
bool RayRenderer::drawAreas(const FrameTask& task, std::unique_ptr<DeferredLight> light, RenderResult& result,
                            Image& added) {
    const FramePlan& p = task.plan;
    Progress& progress = task.context.progress;
    const PixelGoal& goal = task.round.goal;
    RaysDrawn these(p);
    const LayersAsked& asked = task.options.layers;
    const Rays rays = picturesRays(p, asked.paths);
    const std::size_t others = light ? 1 : rays.beginnings ? PictureLayers::kPictures : 0;
    const bool goesOn =
        samples_ && samples_->rays == these && p.view.quality.pixels.samples == PixelSampling::kAutomatic;
    if (goesOn)
        samples_->picture.goOn(goal);
    else
        samples_.reset(new Samples{std::move(these),
                                   AreaPicture(
                                       rays, p.view.quality.pixels, task.options.threads, goal,
                                       [&p](const Image& middles) { return overlookedPixels(p, middles); },
                                       result.stepOfMeans, others),
                                   std::move(light)});
    AreaPicture& picture = samples_->picture;
    takeKept(task, samples_->rays, picture, result);
    DeferredLight* const deferred = samples_->light.get();
    Slicing slicing = task.options.slicing;
    const ShareDone whole = progress.shares();
    if (whole)
        slicing.progress = [&](double done) { whole(picture.share(done)); };
    while (const std::optional<Rays> next = picture.next()) {
        tellNoise(picture, progress);
        if (deferred && deferred->needsMiddles() && !next->places.empty()) {
            caster_->begin(raysOf(p));
            result.passes = std::max(result.passes,
                                     drawToTheEnd(*caster_, *engine_, p, task.options.slicing, result.work));
            deferred->lookAround(*caster_, progress);
        }
        caster_->begin(*next);
        result.passes = std::max(result.passes, drawToTheEnd(*caster_, *engine_, p, slicing, result.work));
        if (!deferred) {
            const Image colours = caster_->image();
            if (rays.beginnings)
                picture.add(colours, layersOf(*caster_, colours, p));
            else
                picture.add(colours);
            if (task.options.kept)
                task.options.kept->keep(picture);
            const int samples = picture.samplesOfAll().value_or(p.view.quality.pixels.samples);
            if (task.options.onRound && rays.paths && samples < p.view.quality.pixels.samples)
                task.options.onRound(picture.image(), samples,
                                     samples > 1 ? std::optional(rmsError(picture.sums())) : std::nullopt);
            continue;
        }
        if (deferred->needsMiddles())
            deferred->lookAround(*caster_, progress);
        const Image colours = caster_->image(), more = deferred->added(*caster_, *engine_, next->places,
                                                                       next->size(), slicing, result.work);
        picture.add(colours, std::span(&more, 1));
    }
    if (p.view.quality.pixels.denoise) {
        progress.stage("taking out noise");
        result.image = withoutNoise(picture.sums(), task.options.threads);
    } else {
        result.image = picture.image();
    }
    if (deferred) {
        added = picture.other(0);
        deferred->report(result);
    }
    if (rays.beginnings)
        result.layers.emplace(PictureLayers::OfRays{picture.other(0), picture.other(1)});
    if (asked.errors)
        result.pixelErrors = picture.sums().errors();
    const int ofEarlierRuns = result.pixels.ofEarlierRuns;
    result.pixels = picture.report();
    result.pixels.ofEarlierRuns = ofEarlierRuns;
    return goesOn;
}

bool RayRenderer::draw(const FrameTask& task, RenderResult& result, Image& added) {
    Planner& p = task.plan;
    const RenderOptions& options = task.options;
    Progress& progress = task.context.progress;
    if (task.round.number == 0)
        samples_.reset();
    progress.stage("loading bricks");
    const auto loading = Clock::now();
    caster_.reset();
    if (!engine_->about().filters)
        p.setFetch(Fetch::exact);
    const bool passes =
        loadBricks(*engine_, p, task.context.gpu, result.work, task.reuse.kept, task.reuse.pages);
    if (task.reuse.opened)
        task.reuse.opened();
    std::unique_ptr<DeferredLight> light;
    if (DeferredLight::isOf(p) && !task.reuse.first)
        light = std::make_unique<DeferredLight>(p, options.threads, exact_);
    caster_ = casterOf(*engine_, p, {options.counting, light != nullptr, passes}, task.context.gpu,
                       options.threads);
    result.secondsLoading = secondsSince(loading);
    const auto drawing = Clock::now();
    if (p.view.lighting.transport && passes)
        throw OverBudget("--gpu-memory: paths of light need all bricks of the picture at once");
    caster_->refine();
    const bool steps = engine_->about().choosesSteps && !p.view.part.flat; // a plane has one sample
    StepSearch search(p, [this, &task](const RayFrame<double>& frame, const Strides& strides) {
        return drawSome(task, {frame, strides});
    });
    if (p.view.exposure) {
        settleExposure(task);
        result.window = p.layer().look.window;
    }
    result.stepOfMeans.reset();
    if (steps) {
        progress.stage("choosing the step");
        chooseStep(task, search, result);
    }
    stepOfMeans_ = result.stepOfMeans.value_or(0);
    progress.stage("drawing");
    bool wentOn = false;
    if (options.tiles) {
        light.reset();
        drawTiles(task, result);
    } else if (p.view.quality.pixels.samples != 1) {
        wentOn = drawAreas(task, std::move(light), result, added);
    } else {
        Slicing slicing = options.slicing;
        slicing.progress = progress.shares();
        const Rays rays = picturesRays(p, options.layers.paths);
        caster_->begin(rays);
        result.passes = drawToTheEnd(*caster_, *engine_, p, slicing, result.work);
        result.image = caster_->image();
        if (rays.beginnings)
            result.layers.emplace(layersOf(*caster_, result.image, p));
        if (light) {
            if (light->needsMiddles())
                light->lookAround(*caster_, progress);
            added = light->added(*caster_, *engine_, {}, p.view.imageSize, options.slicing, result.work);
            light->report(result);
        }
    }
    if (!engine_->bricks())
        result.passes = 0;
    result.features = caster_->features();
    result.refinedCells = caster_->refinedCells();
    result.light = engine_->lightReport();
    result.secondsDrawing = secondsSince(drawing);
    const auto checking = Clock::now();
    if (steps && options.checking) {
        progress.stage("estimating the picture's errors");
        result.errors = estimate(search, task, result.image);
    }
    reportLevels(p, result);
    if (p.chosen.predicted)
        result.predictedError = predictedOf(p);
    result.unseenBricks = p.chosen.unseenBricks;
    result.emptyBricks -= result.unseenBricks;
    if (exact_)
        result.level = 0;
    result.secondsChecking = secondsSince(checking);
    return wentOn;
}

} // namespace tessera
