// render/picture/ray_renderer.cpp: see ray_renderer.h.
#include "render/picture/ray_renderer.h"

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/image/picture_tile.h"
#include "render/exposure/exposed_caster.h"
#include "render/picture/picture.h"
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
#include <cstdint>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
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

/// Those of the picture itself, and not of what is tried or estimated.
Rays picturesRays(const FramePlan& p, bool layers) {
    Rays rays = raysOf(p);
    rays.paths = p.view.lighting.transport.has_value();
    rays.beginnings = rays.paths && layers;
    return rays;
}

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

std::string digitsOf(double value, int digits) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

/// After a round of paths.
void tellNoise(const AreaPicture& picture, Progress& progress) {
    if (picture.noise())
        progress.detail(", " + std::to_string(picture.roundsDone()) +
                        (picture.roundsDone() == 1 ? " round, noise " : " rounds, noise ") +
                        digitsOf(*picture.noise(), 2));
}

} // namespace

/// Everything that a ray's result depends on, for a fixed scene and engine.
struct RayRenderer::RaysDrawn {
    std::vector<std::uint8_t> levels;
    double stepVoxels;
    Hulls hulls;
    Integrator integrator;
    explicit RaysDrawn(const FramePlan& p)
        : levels(p.layer().selection.levels), stepVoxels(p.view.quality.stepVoxels),
          hulls(hullsOf(p.view.frame)), integrator(p.layer().optics.integrator) {
        for (const auto& volume : p.further) {
            const auto& more = volume->plan.layer().selection.levels;
            levels.insert(levels.end(), more.begin(), more.end());
        }
    }
    friend bool operator==(const RaysDrawn&, const RaysDrawn&) = default;
    /// By name, in words.
    std::map<std::string, std::string> parts(const FramePlan& p, bool exact) const {
        const RayFrame<double>& frame = p.view.frame;
        const glm::dvec3 seen[] = {frame.centre, frame.right, frame.up, frame.toCentre};
        std::map<std::string, std::string> parts = {
            {"levels of bricks, which budgets choose:", fingerprint(std::as_bytes(std::span(levels)))},
            {"camera in the volume", fingerprint(std::as_bytes(std::span(seen)))},
            {"step in voxels", digitsOf(stepVoxels, 17)},
            {"integrator", integratorNames()[static_cast<std::size_t>(integrator)]},
            {"random numbers", exact ? "of the reference" : "of native and mirror"}};
        if (hulls.count > 0)
            parts["hulls and their samples"] =
                std::to_string(hulls.count) + " x " + std::to_string(hulls.samples);
        return parts;
    }
};

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

/// One that starts from a plan has the bits of another with these.
PictureTiles::Parts RayRenderer::partsOfTiles(const FramePlan& p) const {
    PictureTiles::Parts parts = RaysDrawn(p).parts(p, exact_);
    const ShadowQuality& maps = p.view.shadowQuality;
    parts["shadow maps, as RAM allows:"] =
        std::to_string(maps.mapSize) + " rays a side, " + std::to_string(maps.layers) + " points, offset " +
        digitsOf(maps.offset, 17) + ", light maps 1/" + std::to_string(maps.lightMapPart);
    parts["map of empty space, as budgets allow:"] =
        std::string(p.layer().mapScale == MapScale::cells ? "cells" : "bricks") +
        (p.layer().mapsSurfaces ? ", and isosurfaces" : "");
    if (const auto& window = p.layer().look.window; p.view.exposure || p.layer().reduces())
        parts["window"] = digitsOf(window.centre, 17) + " +- " + digitsOf(window.width, 17);
    return parts;
}

void RayRenderer::drawTile(const FrameTask& task, const PictureTile& tile, RenderResult& result) {
    const FramePlan& p = task.plan;
    const PixelSampling& sampling = p.view.quality.pixels;
    Slicing slicing = task.options.slicing;
    slicing.progress = {}; // the tiles'
    const auto draw = [&](const Rays& rays) {
        caster_->begin(rays);
        result.passes = std::max(result.passes, drawToTheEnd(*caster_, *engine_, p, slicing, result.work));
    };
    Rays rays = picturesRays(p, false);
    const auto drawMiddles = [&](const PictureTile& of, std::vector<glm::vec2>& middles) {
        middles = of.middles();
        Rays through = rays;
        through.places = middles;
        through.arraySize = of.size;
        draw(through);
    };
    std::vector<glm::vec2> middles;
    std::optional<DeferredLight> light;
    if (DeferredLight::isOf(p)) {
        const PictureTile around = DeferredLight::around(tile, p);
        light.emplace(p, task.options.threads, exact_, around);
        if (light->needsMiddles()) {
            drawMiddles(around, middles);
            light->lookAround(*caster_, task.context.progress);
        }
    }
    DrawnTile drawn{tile, {}, {}, {}};
    if (sampling.samples == 1) {
        drawMiddles(tile, middles);
        drawn.colours = caster_->image();
        if (light)
            drawn.added = light->added(*caster_, *engine_, middles, tile.size, slicing, result.work);
    } else {
        AreaPicture picture(
            rays, sampling, task.options.threads, {}, {}, {}, light ? 1 : 0,
            AreaOfPicture{tile, glm::min(glm::ivec2(task.options.tiles->side()), p.view.imageSize)});
        while (const std::optional<Rays> next = picture.next()) {
            draw(*next);
            const Image colours = caster_->image();
            if (!light) {
                picture.add(colours);
                continue;
            }
            const Image more =
                light->added(*caster_, *engine_, next->places, next->size(), slicing, result.work);
            picture.add(colours, std::span(&more, 1));
        }
        drawn.colours = picture.image();
        if (light)
            drawn.added = picture.other(0);
        drawn.offsets = picture.sums().offsets();
    }
    task.options.tiles->keep(drawn);
    if (light)
        light->addReport(result);
}

void RayRenderer::drawTiles(const FrameTask& task, RenderResult& result) {
    PictureTiles& tiles = *task.options.tiles;
    const PixelSampling& sampling = task.plan.view.quality.pixels;
    TESSERA_CHECK(sampling.samples != PixelSampling::kAutomatic && !(sampling.noise > 0) &&
                  !sampling.denoise && !task.options.layers.paths && !task.options.layers.errors &&
                  !task.options.kept && !task.plan.layer().sliceLabels);
    tiles.begin(partsOfTiles(task.plan));
    const ShareDone done = task.context.progress.shares();
    while (const std::optional<PictureTile> tile = tiles.next()) {
        drawTile(task, *tile, result);
        if (done)
            done(tiles.share());
    }
    result.pixels.asked = result.pixels.most = sampling.samples;
    result.pixels.taken = sampling.samples;
    if (sampling.samples > 1 && tiles.finishes()) {
        task.context.progress.stage("measuring the picture's noise");
        result.pixels.error = standardError([&](const auto& visit) { tiles.eachPixel(visit); });
    }
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
        throw InputError("--gpu-memory: paths of light need all bricks of the picture at once");
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

namespace {

/// In a step of the picture. Where phases allow means a step so many times as long, half of the step with
/// them is as near to the truth as a quarter without (docs/measurements/measured-errors.md). Of steps that
/// are short, voxels, fewer times are enough.
constexpr double kStepsOfTruth = 4, kStepsOfPhasedTruth = 2, kTimesForPhases = 3, kTimesOfShort = 2,
                 kShort = 1.0 / 8;
/// Rays of the truth end at this part of the light at which those of the picture end. They do end,
/// because most of the way behind an opaque part would be traversed for nothing.
constexpr float kEndsOfTruth = 1.0f / 64;

bool hasFinestLevels(const FramePlan& plan) {
    const Selection& s = plan.layer().selection;
    return s.counts[0] == s.shownBricks() &&
           std::all_of(plan.further.begin(), plan.further.end(),
                       [](const auto& volume) { return hasFinestLevels(volume->plan); });
}

/// Rays of the picture wait for bricks: those that pixels need are mostly gone again.
bool drawnInPasses(const FramePlan& plan, Engine& engine) {
    const auto hasAll = [](const FramePlan& volume) {
        return volume.chosen.atlasPages >= pagesFor(volume.layer().selection.counts);
    };
    return engine.bricks() &&
           !(hasAll(plan) && std::all_of(plan.further.begin(), plan.further.end(),
                                         [&](const auto& volume) { return hasAll(volume->plan); }));
}

/// A brick's width in the middle of the volume, in pixels, along the axis of the picture where it is smaller.
int brickPixels(const RayFrame<double>& frame) {
    const double voxels = std::max(2 * glm::length(frame.right) / frame.imageSize.x,
                                   2 * glm::length(frame.up) / frame.imageSize.y); // of a pixel
    return std::max(1, static_cast<int>(std::lround(kBrickExtent / voxels)));
}

} // namespace

RayPixels::RayPixels(const FrameTask& task, Engine& engine, std::unique_ptr<RayCaster>& caster,
                     double stepOfMeans)
    : task_(task), engine_(engine), caster_(caster), step_(task.plan.view.quality.stepVoxels),
      stepOfMeans_(stepOfMeans), ends_(task.plan.layer().optics.termination) {
    task.plan.setFetch(engine.about().filters ? task.scene.quality.fetch
                                              : Fetch::exact); // estimates fetch exactly
}

RayPixels::~RayPixels() {
    task_.plan.setTermination(ends_);
}

PixelSource::About RayPixels::about() const {
    return {hasFinestLevels(task_.plan), drawnInPasses(task_.plan, engine_),
            brickPixels(task_.plan.view.frame)};
}

std::optional<Image> RayPixels::draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize,
                                     const Slicing& slicing, std::uint64_t mostBytes, Work& work) {
    Rays rays = raysOf(task_.plan, task_.plan.view.quality.stepVoxels);
    rays.frame.phased = phased_;
    rays.places = places;
    rays.arraySize = arraySize;
    rays.paths = paths_ || task_.plan.view.lighting.transport;
    caster_->begin(rays);
    if (!drawWithin(*caster_, engine_, task_.plan, slicing, mostBytes, work))
        return std::nullopt;
    return caster_->image();
}

std::string RayPixels::toSingleWays() {
    if (!engine_.about().followsPaths)
        return "the engine follows no paths of light";
    if (about().passes)
        return "paths need all bricks of the picture at once";
    const std::string why = task_.plan.boundLight(task_.scene);
    paths_ = why.empty();
    return why;
}

std::string RayPixels::toTruth() {
    Planner& plan = task_.plan;
    if (std::exchange(paths_, false))
        plan.unboundLight();
    if (hasFinestLevels(plan)) {
        plan.setFetch(Fetch::exact);
    } else {
        caster_.reset();
        engine_.close();
        Scene all = task_.scene;
        all.quality.stepVoxels = step_;
        all.quality.automaticStep = false;
        all.quality.integrator = plan.layer().optics.integrator;
        all.quality.fetch = Fetch::exact;
        all.quality.maxError = 0; // rays wait for bricks
        all.quality.sampling = Sampling::limited;
        try {
            plan.chooseAgain(all, engine_.limits(), task_.context, LevelChoice::finest);
        } catch (const InputError& e) {
            return e.what();
        }
        engine_.open(plan, plan.chosen.atlasPages);
        for (std::size_t n = 0; n < plan.further.size(); ++n)
            if (Engine* const further = engine_.further(n))
                further->open(plan.further[n].plan, plan.further[n].plan.chosen.atlasPages);
        caster_ = casterOf(engine_, plan, {false, false, true}, task_.context.gpu, task_.options.threads);
    }
    const double times = step_ <= kShort ? kTimesOfShort : kTimesForPhases;
    phased_ = stepOfMeans_ >= times * step_ && !plan.layer().reduces();
    plan.setHullSamples(0);
    plan.setStep(step_ / (phased_ ? kStepsOfPhasedTruth : kStepsOfTruth));
    plan.setTermination(ends_ * kEndsOfTruth);
    return {};
}

} // namespace tessera
