// render/check_march.cpp: see check_march.h.
#include "render/check_march.h"

#include <optional>
#include <vector>

namespace tessera {
namespace {

constexpr double kSteps[] = {2, 1, 0.5, 0.25, 0.125}; // voxels, coarse first
constexpr double kTruthStep = 1.0 / 32;               // at second order, its error is a 16th of the finest's

/// A figure, not a measurement, so that a picture does not depend on how busy its machine is
/// (docs/accuracy.md has the measurement).
double costOfSegment(Integrator integrator) {
    return integrator == Integrator::midpoint ? 1 : 1.7;
}

} // namespace

Image CheckMarch::draw(double stepVoxels) {
    Strides strides = scene_.strides();
    strides.segmentVoxels = stepVoxels;
    march_.restart(grid_.frame(scene_.frame, stepVoxels), strides, nullptr);
    Work work;
    run_(march_, work);
    return march_.image();
}

double CheckMarch::chooseStep(double luvP99) {
    std::vector<Integrator> integrators = {scene_.optics.integrator};
    if (scene_.quality.integrator == Integrator::automatic && scene_.mayTake != Integrator::midpoint)
        integrators = {Integrator::midpoint, Integrator::preintegrated};
    const auto take = [&](Integrator integrator) {
        if (integrator != scene_.optics.integrator) {
            scene_.setIntegrator(integrator, ram_);
            march_.setFunction(scene_.optics);
        }
    };
    const Integrator finest = integrators.back();
    take(finest);
    scene_.setStep(kTruthStep);
    const Image truth = draw(kTruthStep);
    struct Choice {
        Integrator integrator;
        double step, luvP99, cost;
    };
    std::optional<Choice> best, closest; // closest: where none is good enough
    for (const Integrator integrator : integrators) {
        take(integrator);
        for (const double step : kSteps) {
            scene_.setStep(step);
            const double error = errorBetween(draw(step), truth).luvP99;
            const Choice choice{integrator, step, error, costOfSegment(integrator) / step};
            if (!closest || error < closest->luvP99)
                closest = choice;
            if (!(error <= luvP99))
                continue;
            if (!best || choice.cost < best->cost)
                best = choice;
            break; // finer ones cost more
        }
    }
    if (!best)
        best = closest;
    take(best->integrator);
    scene_.setStep(best->step);
    march_.restart(scene_.frame, scene_.strides(), nullptr);
    return best->luvP99;
}

PictureErrors CheckMarch::errorsOf(const Image& picture, double brightest) {
    PictureErrors e;
    const double step = scene_.quality.stepVoxels;
    e.pixels = grid_.size().x * grid_.size().y;
    e.terminationBound = static_cast<double>(scene_.optics.termination) * brightest;
    e.tableRelativeError = scene_.table.relativeError;
    const Image mine = grid_.of(picture);
    e.step = stepError(mine, draw(step / 2), draw(step / 4));
    if (features_ & kFeatureHardware) {
        march_.setFeatures(features_ & ~kFeatureHardware, scene_.optics);
        e.filtering = errorBetween(mine, draw(step));
    }
    return e;
}

} // namespace tessera
