// tests/bench/lod/calibration_shares.cpp: see calibration.h: how often what is said holds, and the figure
// of it.
#include "tests/bench/lod/calibration.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera::bench {
namespace {

constexpr double kLeastShown = 0.01; // zero has no place on a logarithmic axis

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n == 0 ? std::nan("") : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

void count(CalibrationShares::Share& share, const std::optional<Estimate>& said, double is) {
    if (!said)
        return;
    ++share.of;
    share.hold += said->low <= is && is <= said->high;
}

} // namespace

CalibrationShares sharesOf(const std::vector<const CalibrationCase*>& cases) {
    CalibrationShares s;
    std::vector<double> toMeasured, toPredicted;
    for (const CalibrationCase* c : cases) {
        const double is = c->is.luvP99;
        ++s.cases;
        if (c->asked && c->shortfall.empty()) {
            ++s.maxError.of;
            s.maxError.hold += is <= *c->asked;
        } else if (c->asked) {
            ++s.notReached;
        }
        count(s.p99, c->measured.luvP99, is);
        count(s.mean, c->measured.luvMean, c->is.luvMean);
        count(s.rms, c->measured.rms, c->is.rms);
        if (c->measured.luvP99Bound) {
            ++s.bound.of;
            s.bound.hold += is <= *c->measured.luvP99Bound;
        }
        if (!c->measured.luvP99)
            ++s.noP99;
        else if (c->measured.luvP99->value > 0)
            toMeasured.push_back(is / c->measured.luvP99->value);
        if (c->predictedP99 > 0)
            toPredicted.push_back(is / c->predictedP99);
    }
    s.trueToP99 = median(toMeasured);
    s.trueToGuess = median(toPredicted);
    return s;
}

Plot calibrationPlot(const std::vector<CalibrationCase>& cases) {
    Plot plot{
        "calibration",
        "Measured errors (points) and predicted ones (crosses) against true ones; left of its grey line is "
        "where `--max-error` is kept:",
        "true p99, L*u*v*",
        "measured or predicted p99, L*u*v*",
        true,
        true,
        {},
        true};
    Plot::Curve predicted{"predicted", {}, Plot::Style::crosses, 5};
    Plot::Curve budgets{"measured, by memory", {}, Plot::Style::points, 6};
    std::vector<Plot::Curve> asked;
    for (const double maxError : kCalibratedMaxErrors)
        asked.push_back({"measured, --max-error " + formatCell(maxError),
                         {},
                         Plot::Style::points,
                         static_cast<int>(asked.size())});
    double least = 1, most = 1;
    const auto add = [&](Plot::Curve& curve, double is, double said) {
        curve.points.emplace_back(std::max(is, kLeastShown), std::max(said, kLeastShown));
        least = std::min({least, curve.points.back().first, curve.points.back().second});
        most = std::max({most, curve.points.back().first, curve.points.back().second});
    };
    for (const CalibrationCase& c : cases) {
        add(predicted, c.is.luvP99, c.predictedP99);
        if (!c.measured.luvP99)
            continue;
        Plot::Curve* curve = &budgets;
        for (std::size_t i = 0; c.asked && i < asked.size(); ++i)
            if (*c.asked == kCalibratedMaxErrors[i])
                curve = &asked[i];
        add(*curve, c.is.luvP99, c.measured.luvP99->value);
    }
    plot.curves = {std::move(predicted), std::move(budgets)};
    plot.curves.insert(plot.curves.end(), asked.begin(), asked.end());
    plot.curves.push_back({"as promised", {{least, least}, {most, most}}, Plot::Style::guide, -1});
    for (const double maxError : kCalibratedMaxErrors)
        plot.curves.push_back(
            {formatCell(maxError), {{maxError, most}, {maxError, least}}, Plot::Style::guide, -1});
    return plot;
}

} // namespace tessera::bench
