// render/picture/ray_pixels.cpp: see ray_pixels.h.
#include "render/picture/ray_pixels.h"

#include "core/base/error.h"
#include "render/exposure/exposed_caster.h"
#include "render/picture/picture.h"
#include "render/plan/fusion.h"
#include "render/plan/planner.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

namespace tessera {
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
