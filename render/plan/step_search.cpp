// render/plan/step_search.cpp: see step_search.h.
#include "render/plan/step_search.h"

#include <optional>
#include <vector>

namespace tessera {
namespace {

// Voxels, coarse first. A step is judged by the picture with a quarter of it, as pictures are afterwards.
constexpr double kSteps[] = {2, 1, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625};
constexpr std::size_t kJudged = std::size(kSteps) - 2;
static_assert(kSteps[kJudged - 1] == StepSearch::kFinestStep);
/// Factors on a step that is good enough, if twice the step is not.
constexpr double kBetween[] = {1.75, 1.5, 1.25};

/// A constant, not a measurement, so that a picture does not depend on the machine's load
/// (docs/measurements/accuracy.md has the measurement).
double costOfSegment(Integrator integrator) {
    return integrator == Integrator::midpoint ? 1 : 1.5;
}

} // namespace

Image StepSearch::draw(double stepVoxels) {
    Strides strides = plan_.strides();
    strides.segmentVoxels = stepVoxels;
    return drawer_(grid_.frame(plan_.view.frame, stepVoxels), strides);
}

double StepSearch::chooseStep(const Goal& goal) {
    const std::vector<Integrator> integrators = plan_.integratorsToTry();
    struct Choice {
        Integrator integrator;
        double step, error, cost;
        StepError estimate;
    };
    const auto measured = [&](const EstimatedError& e) {
        return goal.measure == Goal::Measure::rms ? e.rms : e.luvP99;
    };
    std::optional<Choice> best, closest; // closest: if none is good enough
    for (const Integrator integrator : integrators) {
        plan_.setIntegrator(integrator);
        std::vector<Image> drawn;
        for (std::size_t n = 0; n < kJudged; ++n) {
            while (drawn.size() < n + 3) {
                plan_.setStep(kSteps[drawn.size()]);
                drawn.push_back(draw(kSteps[drawn.size()]));
            }
            const StepError e = stepError(drawn[n], drawn[n + 1], drawn[n + 2]);
            const Choice choice{integrator, kSteps[n], measured(e.error),
                                costOfSegment(integrator) / kSteps[n], e};
            if (!closest || choice.error < closest->error)
                closest = choice;
            if (!(choice.error <= goal.limit))
                continue;
            if (!best || choice.cost < best->cost)
                best = choice;
            if (n > 0) // the next coarser one is not good enough: those between
                for (const double times : kBetween) {
                    const double step = times * kSteps[n];
                    plan_.setStep(step);
                    const EstimatedError between = errorBetween(draw(step), drawn[n + 2]);
                    const Choice longer{integrator,
                                        step,
                                        measured(between),
                                        costOfSegment(integrator) / step,
                                        {between, e.order}};
                    if (!(longer.error <= goal.limit && between.luvP99 <= kLuvOfLonger))
                        continue;
                    if (longer.cost < best->cost)
                        best = longer;
                    break;
                }
            break; // finer ones cost more
        }
    }
    if (!best)
        best = closest;
    plan_.setIntegrator(best->integrator);
    plan_.setStep(best->step);
    chosen_ = {best->integrator, best->step, best->estimate};
    return best->error;
}

PictureErrors StepSearch::errorsOf(const Image& picture, double brightest) {
    return errorsOfGrid(grid_.of(picture), brightest);
}

PictureErrors StepSearch::errors(double brightest) {
    return errorsOfGrid(draw(plan_.view.quality.stepVoxels), brightest);
}

PictureErrors StepSearch::errorsOfGrid(const Image& mine, double brightest) {
    PictureErrors e;
    const double step = plan_.view.quality.stepVoxels;
    e.pixels = grid_.size().x * grid_.size().y;
    e.terminationBound = static_cast<double>(plan_.layer().optics.termination) * brightest;
    e.tableRelativeError = plan_.layer().table.relativeError;
    if (chosen_ && chosen_->integrator == plan_.layer().optics.integrator && chosen_->step == step)
        e.step = chosen_->estimate;
    else
        e.step = stepError(mine, draw(step / 2), draw(step / 4));
    if (plan_.view.quality.fetch == Fetch::hardware) {
        plan_.setFetch(Fetch::exact);
        e.filtering = errorBetween(mine, draw(step));
    }
    return e;
}

} // namespace tessera
