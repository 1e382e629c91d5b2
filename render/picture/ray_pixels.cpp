// render/picture/ray_pixels.cpp: see ray_pixels.h.
#include "render/picture/ray_pixels.h"

#include "core/base/error.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

constexpr double kStepsOfTruth = 4; // in a step of the picture
/// Rays of the truth end at this part of the light at which those of the picture end. They do end,
/// because most of the way behind an opaque part would be traversed for nothing.
constexpr float kEndsOfTruth = 1.0f / 64;

bool hasFinestLevels(const FramePlan& plan) {
    const Selection& s = plan.layer().selection;
    return s.counts[0] == s.shownBricks();
}

/// Rays of the picture wait for bricks: those that pixels need are mostly gone again.
bool drawnInPasses(const FramePlan& plan, Engine& engine) {
    return engine.bricks() && plan.chosen.atlasPages < pagesFor(plan.layer().selection.counts);
}

/// A brick's width in the middle of the volume, in pixels, along the axis of the picture where it is smaller.
int brickPixels(const RayFrame<double>& frame) {
    const double voxels = std::max(2 * glm::length(frame.right) / frame.imageSize.x,
                                   2 * glm::length(frame.up) / frame.imageSize.y); // of a pixel
    return std::max(1, static_cast<int>(std::lround(kBrickExtent / voxels)));
}

} // namespace

RayPixels::RayPixels(const FrameTask& task, Engine& engine, std::unique_ptr<RayCaster>& caster)
    : task_(task), engine_(engine), caster_(caster), step_(task.plan.view.quality.stepVoxels),
      ends_(task.plan.layer().optics.termination) {
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
    rays.places = places;
    rays.arraySize = arraySize;
    caster_->begin(rays);
    if (!drawWithin(*caster_, engine_, task_.plan, slicing, mostBytes, work))
        return std::nullopt;
    return caster_->image();
}

std::string RayPixels::toTruth() {
    Planner& plan = task_.plan;
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
        try {
            plan.chooseAgain(all, engine_.limits(), task_.context, LevelChoice::finest);
        } catch (const InputError& e) {
            return e.what();
        }
        const FramePlan* const plans[] = {&plan};
        engine_.open(plans, plan.chosen.atlasPages);
        caster_ = engine_.caster({false, false, true}, task_.context.gpu);
    }
    plan.setStep(step_ / kStepsOfTruth);
    plan.setTermination(ends_ * kEndsOfTruth);
    return {};
}

} // namespace tessera
