// tests/bench/accuracy/scene_plots.cpp: see scene_plots.h.
#include "tests/bench/accuracy/scene_plots.h"

#include "tests/bench/accuracy/pareto.h"
#include "tests/bench/accuracy/report_cells.h"
#include "tests/bench/report/work_precision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace tessera::accuracy {
namespace {

using bench::Plot;

/// A method's place among the plotted ones: integrators have colours, fetches have dashes.
std::pair<int, Plot::Style> lookOf(const Setting& s) {
    return {static_cast<int>(s.integrator),
            s.fetch == Fetch::exact ? Plot::Style::dashed : Plot::Style::line};
}

/// A guide of order p through a point: y falls by 2^p where x changes by a factor of 2.
Plot::Curve guide(const std::string& label, double x0, double y0, double x1, double power) {
    return {label, {{x0, y0}, {x1, y0 * std::pow(x1 / x0, power)}}, Plot::Style::guide, -1};
}

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    void add(double v) {
        low = std::min(low, v);
        high = std::max(high, v);
    }
    bool any() const { return high > 0 && low <= high; }
};

/// Guides at the top left, and the floor's line where errors come near it; else the caption tells where it
/// is.
void addGuides(Plot& plot, double floor, double sign, const std::vector<double>& orders) {
    Range x, y;
    for (const Plot::Curve& curve : plot.curves)
        for (const auto& [px, py] : curve.points) {
            x.add(px);
            y.add(py);
        }
    if (!x.any() || !y.any())
        return;
    for (const double order : y.high > 5 * y.low ? orders : std::vector<double>()) {
        // From the corner where errors are large; no longer than the figure is high.
        const double from = sign < 0 ? x.low : x.high,
                     decades = std::log(y.high / std::max(floor, y.low)) / order;
        const double reach = std::min(std::log(x.high / x.low), std::max(decades, 0.1));
        plot.curves.push_back(guide("order " + number(order), from, y.high,
                                    from * std::exp(sign < 0 ? reach : -reach), sign * order));
    }
    constexpr double kNear = 30;
    if (y.low < kNear * floor)
        plot.curves.push_back(
            {"floor of the reference", {{x.low, floor}, {x.high, floor}}, Plot::Style::guide, -1});
    else
        plot.caption += " The floor of the reference, " + number(floor, 2) + ", is below the figure.";
}

} // namespace

std::map<std::string, std::vector<const Measured*>> byStep(const Sweep& sweep) {
    std::map<std::string, std::vector<const Measured*>> methods;
    for (const Measured& m : sweep.measured) {
        const Setting& s = m.planned.setting;
        if (isPlain(sweep, s) && s.termination == 0 && s.integrator != Integrator::automatic)
            methods[methodName(s)].push_back(&m);
    }
    for (auto& [method, list] : methods)
        std::sort(list.begin(), list.end(), [](const Measured* a, const Measured* b) {
            return a->planned.setting.stepVoxels > b->planned.setting.stepVoxels;
        });
    return methods;
}

Plot workPrecisionPlot(const Sweep& sweep, const std::vector<PeerPoint>& peers) {
    Plot plot{"wp_" + sweep.scene.name,
              "Work and precision: the settings of each method that none of its others beats in both error "
              "and time; "
              "to the left and below is better. Methods are integrators with filtered fetches (lines) and "
              "exact ones "
              "(dashes).",
              "least time of a frame, ms",
              "rms error, linear",
              true,
              true,
              {},
              true};
    std::map<std::string, Setting> looks;
    for (const Measured& m : sweep.measured)
        looks.emplace(methodName(m.planned.setting), m.planned.setting);
    int peerColour = 6;
    for (const auto& [method, envelope] : envelopes(sweep, peers)) {
        Plot::Curve curve{method, {}, Plot::Style::line, peerColour};
        if (const auto look = looks.find(method); look != looks.end()) {
            if (look->second.integrator == Integrator::automatic)
                continue; // it is one of the others
            std::tie(curve.colour, curve.style) = lookOf(look->second);
        } else {
            ++peerColour;
        }
        for (const WorkPoint& p : envelope)
            if (p.error > 0)
                curve.points.emplace_back(p.ms, p.error);
        if (!curve.points.empty())
            plot.curves.push_back(std::move(curve));
    }
    addGuides(plot, sweep.floor(), -1, {1, 2});
    return plot;
}

Plot convergencePlot(const Sweep& sweep) {
    Plot plot{"conv_" + sweep.scene.name,
              "Convergence, rays that are never ended early; the order is fitted to those coarsest steps "
              "over which "
              "the error falls.",
              "step, voxels",
              "rms error, linear",
              true,
              true,
              {},
              true};
    for (const auto& [method, list] : byStep(sweep)) {
        Plot::Curve curve{method, {}, Plot::Style::line, -1};
        std::tie(curve.colour, curve.style) = lookOf(list.front()->planned.setting);
        for (const Measured* m : list)
            if (m->error.rmse > 0)
                curve.points.emplace_back(m->planned.setting.stepVoxels, m->error.rmse);
        if (const auto order = fittedOrder(curve.points, sweep.floor()))
            curve.label += ": " + number(order->slope, 2);
        if (!curve.points.empty())
            plot.curves.push_back(std::move(curve));
    }
    addGuides(plot, sweep.floor(), 1, {1, 2});
    return plot;
}

} // namespace tessera::accuracy
