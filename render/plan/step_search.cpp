// render/plan/step_search.cpp: see step_search.h.
#include "render/plan/step_search.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace tessera {
namespace {

EstimatedError scaled(const ImageDifference& d, double factor) {
    return {factor * d.rms, factor * d.maxAbs, factor * d.luvMean, factor * d.luvP99};
}

} // namespace

PixelGrid::PixelGrid(const glm::ivec2& imageSize)
    : picture_(imageSize), every_((std::max(imageSize.x, imageSize.y) + kMostPixels - 1) / kMostPixels) {
    size_ = thinnedSize(imageSize, every_);
}

RayFrame<double> PixelGrid::frame(const RayFrame<double>& picture, double segmentVoxels) const {
    RayFrame<double> f = picture;
    // A pixel x of the grid is pixel every * x + every / 2 of the picture: from -1 to 1 across each, the
    // picture's place is share * the grid's + shift.
    const glm::dvec2 share = glm::dvec2(size_ * every_) / glm::dvec2(picture_);
    const double middle = every_ / 2 + 0.5 - 0.5 * every_;
    const glm::dvec2 shift = share - 1.0 + 2 * middle / glm::dvec2(picture_);
    const glm::dvec3 offset = shift.x * picture.right - shift.y * picture.up;
    f.right *= share.x;
    f.up *= share.y;
    f.centre += offset;
    if (picture.perspective)
        f.toCentre += offset;
    f.imageSize = glm::dvec2(size_);
    f.segmentVoxels = segmentVoxels;
    if (f.hulls.count > 0) // more samples in place of shorter segments
        f.hulls.samples = std::max(
            1, static_cast<int>(std::lround(f.hulls.samples * picture.segmentVoxels / segmentVoxels)));
    return f;
}

Image PixelGrid::of(const Image& picture) const {
    TESSERA_CHECK(picture.size == picture_);
    return thinned(picture, every_);
}

EstimatedError errorBetween(const Image& picture, const Image& better) {
    return scaled(compare(picture, better), 1);
}

StepError stepError(const Image& picture, const Image& half, const Image& quarter) {
    const ImageDifference first = compare(picture, half), second = compare(half, quarter);
    StepError e;
    if (first.rms > 0 && second.rms > 0)
        e.order = std::log2(first.rms / second.rms);
    // Not extrapolated from the first two: on scans their errors are hardly correlated, and terms that would
    // cancel in a smooth scene add up. The quarter's own error is a 16th where the order is 2.
    e.error = scaled(compare(picture, quarter), 16.0 / 15);
    return e;
}

double PictureErrors::luvP99() const {
    return (step ? step->error.luvP99 : 0) + (filtering ? filtering->luvP99 : 0) + levelsLuvP99.value_or(0);
}

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
        const auto cost = [&](double step) { return costOfSegment(integrator) / step; };
        for (std::size_t n = 0; n < kJudged; ++n) {
            if (best && cost(kBetween[0] * kSteps[n]) >= best->cost)
                break; // neither this step nor a longer one beside it would be taken
            while (drawn.size() < n + 3) {
                plan_.setStep(kSteps[drawn.size()]);
                drawn.push_back(draw(kSteps[drawn.size()]));
            }
            const StepError e = stepError(drawn[n], drawn[n + 1], drawn[n + 2]);
            const Choice choice{integrator, kSteps[n], measured(e.error), cost(kSteps[n]), e};
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
                    const Choice longer{integrator, step, measured(between), cost(step), {between, e.order}};
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

void StepSearch::chooseHullSamples() {
    const double step = plan_.view.quality.stepVoxels;
    constexpr double kRms = 1.0 / 255;
    struct Choice {
        Integrator integrator;
        int samples;
        double cost;
    };
    std::optional<Choice> best;
    Choice finest{};
    for (const Integrator integrator : plan_.integratorsToTry()) {
        plan_.setIntegrator(integrator);
        std::vector<Image> drawn;
        for (int n = 0; (1 << n) <= Hulls::kMostSamples; ++n) {
            finest = {integrator, 1 << n, costOfSegment(integrator) * (1 << n)};
            if (best && finest.cost >= best->cost)
                break;
            while (drawn.size() < static_cast<std::size_t>(n) + 3) {
                plan_.setHullSamples(1 << drawn.size());
                drawn.push_back(draw(step));
            }
            const std::size_t at = static_cast<std::size_t>(n);
            const StepError e = stepError(drawn[at], drawn[at + 1], drawn[at + 2]);
            if (e.error.rms <= kRms && e.error.luvP99 <= kLuvOfLonger) {
                best = finest;
                break;
            }
        }
    }
    const Choice& chosen = best ? *best : finest;
    plan_.setIntegrator(chosen.integrator);
    plan_.setHullSamples(chosen.samples);
}

PictureErrors StepSearch::errorsOf(const Image& picture, double brightest) {
    return errorsOfGrid([&] { return grid_.of(picture); }, brightest);
}

PictureErrors StepSearch::errors(double brightest) {
    return errorsOfGrid([&] { return draw(plan_.view.quality.stepVoxels); }, brightest);
}

PictureErrors StepSearch::errorsOfGrid(const std::function<Image()>& drawMine, double brightest) {
    PictureErrors e;
    const double step = plan_.view.quality.stepVoxels;
    const bool known =
        chosen_ && chosen_->integrator == plan_.layer().optics.integrator && chosen_->step == step;
    const bool filters = plan_.view.quality.fetch == Fetch::hardware;
    const Image mine = known && !filters ? Image() : drawMine();
    e.pixels = grid_.size().x * grid_.size().y;
    e.terminationBound = static_cast<double>(plan_.layer().optics.termination) * brightest;
    e.tableRelativeError = plan_.layer().table.relativeError;
    if (known)
        e.step = chosen_->estimate;
    else
        e.step = stepError(mine, draw(step / 2), draw(step / 4));
    if (filters) {
        plan_.setFetch(Fetch::exact);
        e.filtering = errorBetween(mine, draw(step));
    }
    return e;
}

} // namespace tessera
