// render/picture/draw_picture.cpp: see draw_picture.h.
#include "render/picture/draw_picture.h"

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "render/backends/mirror/mirror_tracer.h"
#include "render/picture/picture.h"
#include "render/picture/step_of_means.h"
#include "render/plan/overlooked_pixels.h"
#include "render/plan/plan_again.h"
#include "render/plan/step_search.h"
#include "render/verify/error_goal.h"

#include <chrono>
#include <limits>
#include <utility>

namespace tessera {
namespace {

using Clock = std::chrono::steady_clock;

/// What eight bits can show.
constexpr double kDefaultStepError = 1.0 / 255;

std::unique_ptr<SurfaceTracer> tracerOf(const RayCaster& caster, const ScenePlan& p) {
    auto tracer = caster.surfaceTracer(SurfaceLight::kSegmentVoxels);
    return tracer ? std::move(tracer) : std::make_unique<MirrorTracer>(p, SurfaceLight::kSegmentVoxels);
}

/// Looks around from what the rays of the caster met, which are those through the middles of pixels.
void lookAround(SurfaceLight& light, const RayCaster& caster, const ScenePlan& p, Progress& progress) {
    progress.stage("looking around from surfaces");
    light.look(caster.hits(), *tracerOf(caster, p), progress.shares());
    progress.stage("drawing");
}

/// Every pixel the mean of its samples. Returns whether it went on from earlier ones.
/// @param light  none: there is no occlusion of surfaces; else what is added by it is another picture
bool drawAreas(RayCaster& caster, Engine& engine, const ScenePlan& p, const RenderOptions& options,
               const PixelGoal& goal, std::optional<SamplesDrawn>& samples,
               std::unique_ptr<SurfaceLight> light, Image& added, Progress& progress, RenderResult& result) {
    RaysDrawn these(p);
    const bool goesOn =
        samples && samples->rays == these && p.view.quality.pixels.samples == PixelSampling::kAutomatic;
    if (goesOn)
        samples->picture.goOn(goal);
    else
        samples = SamplesDrawn{std::move(these),
                               AreaPicture(
                                   raysOf(p), p.view.quality.pixels, options.threads, goal,
                                   [&p](const Image& middles) { return overlookedPixels(p, middles); },
                                   result.stepOfMeans)};
    if (!goesOn)
        samples->light = std::move(light);
    AreaPicture& picture = samples->picture;
    SurfaceLight* const looks = samples->light.get();
    Slicing slicing = options.slicing;
    const ShareDone whole = progress.shares();
    if (whole)
        slicing.progress = [&](double done) { whole(picture.share(done)); };
    while (const std::optional<Rays> rays = picture.next()) {
        if (looks && !looks->hasLooked() && !rays->places.empty()) { // it takes what middles met
            caster.begin(raysOf(p));
            result.passes =
                std::max(result.passes, drawToTheEnd(caster, engine, p, options.slicing, result.work));
            lookAround(*looks, caster, p, progress);
        }
        caster.begin(*rays);
        result.passes = std::max(result.passes, drawToTheEnd(caster, engine, p, slicing, result.work));
        if (!looks) {
            picture.add(caster.image());
            continue;
        }
        if (!looks->hasLooked())
            lookAround(*looks, caster, p, progress);
        const Image more = looks->added(caster.hits(), rays->places, rays->size(), *tracerOf(caster, p));
        picture.add(caster.image(), &more);
    }
    result.image = picture.image();
    if (looks) {
        added = picture.light();
        result.surfaceLight = looks->report();
    }
    result.pixels = picture.report();
    return goesOn;
}

/// What the selection came to; after it is final.
void report(const ScenePlan& p, RenderResult& result) {
    result.level = p.volume.selection.finest();
    result.integrator = p.volume.optics.integrator;
    result.stepVoxels = p.view.quality.stepVoxels;
    result.bricksOfLevel = p.volume.selection.counts;
    result.selectionPages = pagesFor(p.volume.selection.counts);
    result.atlasPages = std::min(p.chosen.atlasPages, result.selectionPages);
    if (p.chosen.predicted)
        result.predictedError = p.chosen.error;
    result.residentBricks = p.volume.selection.shownBricks();
    result.unseenBricks = p.chosen.unseenBricks;
    result.emptyBricks = p.volume.selection.counts[Selection::kEmpty] - result.unseenBricks;
}

/// Samples until every pixel's standard error is within what is asked, at any cost.
PixelGoal pixelGoal(double lightness) {
    PixelGoal goal;
    goal.target.linear *= lightness / goal.target.lightness;
    goal.target.lightness = lightness;
    goal.rays = SIZE_MAX / 4;
    goal.most = PixelSampling::kMost;
    return goal;
}

} // namespace

bool drawPicture(const Scene& scene, ScenePlan& p, Engine& engine, const FrameContext& context,
                 const RenderOptions& options, const Round& round, std::optional<SamplesDrawn>& samples,
                 RenderResult& result, const FrameReuse& reuse) {
    Progress& progress = context.progress;
    progress.stage("loading bricks");
    const auto loading = Clock::now();
    const bool passes = loadBricks(engine, p, context.gpu, result.work, reuse.kept, reuse.pages);
    if (reuse.opened)
        reuse.opened();
    std::unique_ptr<SurfaceLight> light;
    if (p.view.lighting.surfaceOcclusion && !reuse.first)
        light = std::make_unique<SurfaceLight>(p, options.threads, traitsOf(result.engine).exact);
    std::unique_ptr<RayCaster> caster =
        engine.caster({options.counting, light != nullptr, passes}, context.gpu);
    result.secondsLoading = secondsSince(loading);
    const auto drawing = Clock::now();
    caster->refine();
    const auto drawSome = [&](const Rays& rays) {
        Work work; // not the picture's
        caster->begin(rays);
        drawToTheEnd(*caster, engine, p, options.slicing, work);
        return caster->image();
    };
    const bool checks = engine.about().choosesSteps;
    const bool steps = checks && !p.view.part.flat; // a plane has one sample
    StepSearch search(p, {[&](const RayFrame<double>& frame, const Strides& strides) {
                              return drawSome({frame, strides});
                          },
                          [&] { caster->functionChanged(); }, [&] { return caster->fetchExactly(); }});
    using Goal = StepSearch::Goal;
    result.stepOfMeans.reset();
    if (steps) {
        progress.stage("choosing the step");
        const bool chosen = scene.quality.automaticStep && (options.searching || options.checking);
        if (scene.quality.maxError.value_or(0) > 0)
            search.chooseStep({Goal::Measure::luvP99, *scene.quality.maxError - p.chosen.error.p99});
        else if (chosen)
            search.chooseStep({Goal::Measure::rms, kDefaultStepError});
        const bool decide = p.view.quality.pixels.samples == PixelSampling::kAutomatic;
        if (chosen && decide && !scene.quality.maxError)
            result.stepOfMeans = stepOfMeans(p, kDefaultStepError, drawSome);
    }
    progress.stage("drawing");
    const bool areas = p.view.quality.pixels.samples != 1;
    bool wentOn = false;
    Image added; // to the picture, once its errors are known: they are those of rays
    if (areas) {
        wentOn = drawAreas(*caster, engine, p, options, round.goal, samples, std::move(light), added,
                           progress, result);
    } else {
        Slicing slicing = options.slicing;
        slicing.progress = progress.shares();
        caster->begin(raysOf(p));
        result.passes = drawToTheEnd(*caster, engine, p, slicing, result.work);
        result.image = caster->image();
        if (light) {
            lookAround(*light, *caster, p, progress);
            added = light->added(light->middles(), {}, p.view.imageSize, *tracerOf(*caster, p));
            result.surfaceLight = light->report();
        }
    }
    if (!engine.bricks())
        result.passes = 0;
    result.features = caster->features();
    result.refinedCells = caster->refinedCells();
    result.light = engine.lightReport();
    result.secondsDrawing = secondsSince(drawing);
    const auto checking = Clock::now();
    if (steps && options.checking) {
        progress.stage("estimating the picture's errors");
        const double most = brightest(scene.shading, scene.lighting, p.volume.function.materials());
        result.errors = areas ? search.errors(most) : search.errorsOf(result.image, most);
        if (p.chosen.predicted)
            result.errors->levelsLuvP99 = p.chosen.error.p99;
    }
    report(p, result);
    if (checks && options.verify != Verify::none) {
        progress.stage("measuring the picture's errors");
        const bool decides = scene.quality.maxError.value_or(0) > 0;
        const DrawnPicture drawn{scene,
                                 result.image,
                                 result.work,
                                 result.pixels.taken,
                                 decides ? Verify::full : options.verify,
                                 round.number,
                                 decides ? ErrorGoal::kMostRounds : 1,
                                 options.slicing};
        caster->fetchAsAsked(); // estimates fetched exactly
        result.measured = measurePicture(drawn, p, engine, caster, context);
    }
    for (std::size_t i = 0; i < added.pixels.size(); ++i)
        result.image.pixels[i] = glm::max(result.image.pixels[i] + added.pixels[i], glm::vec4(0));
    result.secondsChecking = secondsSince(checking);
    if (const std::string fault = engine.fault(); !fault.empty())
        throw Error(fault);
    return wentOn;
}

void drawUntilGoodEnough(const Scene& scene, ScenePlan& p, Engine& engine, const FrameContext& context,
                         const RenderOptions& options, RenderResult& result) {
    ErrorGoal goal(*scene.quality.maxError);
    Scene now = scene;
    std::optional<SamplesDrawn> samples;
    double lastTarget = std::numeric_limits<double>::max(), lastTaken = 0;
    for (int round = 0;; ++round) {
        const double target = goal.ofSamples();
        now.quality.maxError = goal.ofRays();
        if (round > 0) {
            engine.close();
            context.progress.stage("choosing finer levels");
            chooseAgain(p, now, engine.limits(), context, options.levels);
        }
        const bool wentOn =
            drawPicture(now, p, engine, context, options, {round, pixelGoal(target)}, samples, result);
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

} // namespace tessera
