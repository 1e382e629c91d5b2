// render/verify/error_goal.cpp: see error_goal.h.
#include "render/verify/error_goal.h"

#include <algorithm>
#include <cstdio>

namespace tessera {
namespace {

/// Errors of a normal distribution are 2.6 times their standard deviation at the 99th percentile of their
/// size; in two dimensions of colour 3. Pixels with just enough samples then have the requested error.
constexpr double kDeviationOfAsked = 1.0 / 3;
/// A cause with more than this share of the requested error is refined.
constexpr double kPartOfCause = 0.5;
/// Predictions are sometimes wrong by more than a small factor, measurements are not.
constexpr double kLeastCorrection = 0.1, kMostCorrection = 0.7;

double correction(double asked, double is) {
    return std::clamp(kPartOfCause * asked / is, kLeastCorrection, kMostCorrection);
}

} // namespace

double ErrorGoal::ofSamples() const {
    return kDeviationOfAsked * samples_ * asked_;
}

ErrorGoal::Verdict ErrorGoal::judge(const MeasuredErrors& all, const MeasuredErrors& samples,
                                    const MeasuredErrors& rays, bool raysAreFinest, bool samplesAreMost) {
    ++rounds_;
    shortfall_.clear();
    if (all.luvP99Bound && *all.luvP99Bound <= asked_)
        return Verdict::reached;
    char text[160];
    if (all.luvP99 && all.luvP99Bound)
        std::snprintf(text, sizeof text,
                      "the error is measured as %.2g, and at most %.2g (L*u*v*, 99th percentile)",
                      all.luvP99->value, *all.luvP99Bound);
    else
        std::snprintf(text, sizeof text, "the 99th percentile of the error could not be measured");
    shortfall_ = text;
    const auto matters = [&](const MeasuredErrors& part) {
        return !part.luvP99 || part.luvP99->high > kPartOfCause * asked_;
    };
    const bool raysMatter = matters(rays), samplesMatter = matters(samples);
    const bool finerRays = !raysAreFinest && (raysMatter || !samplesMatter);
    const bool moreSamples = !samplesAreMost && (samplesMatter || !raysMatter);
    if (!finerRays && !moreSamples) {
        shortfall_ += raysMatter && raysAreFinest ? ", and no level or step is finer"
                                                  : ", and no pixel can get more samples";
        return Verdict::notReached;
    }
    if (rounds_ == kMostRounds) {
        shortfall_ += " after " + std::to_string(rounds_) + " pictures, each finer than the one before";
        return Verdict::notReached;
    }
    if (finerRays)
        rays_ *= rays.luvP99 ? correction(asked_, rays.luvP99->high) : kMostCorrection;
    if (moreSamples)
        samples_ *= samples.luvP99 ? correction(asked_, samples.luvP99->high) : kMostCorrection;
    return Verdict::goOn;
}

} // namespace tessera
