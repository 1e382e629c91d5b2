// viewer/accuracy/accuracy_report.cpp: see accuracy_report.h.
#include "viewer/accuracy/accuracy_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace tessera::accuracy {
namespace {

using bench::Cell;
using bench::Plot;
using bench::Report;
using bench::Table;

constexpr const char* kNotReached = "not reached";

std::string number(double value, int digits = 3) {
    return formatNumber(value, digits);
}
/// Cells one by one: lists of variants made of literals are more than GCC 12 can follow without a warning.
template <typename... Cells> void append(std::vector<Cell>& row, Cells&&... cells) {
    (row.push_back(Cell(std::forward<Cells>(cells))), ...);
}
Cell orNotReached(const std::optional<double>& value) {
    return value ? Cell(*value) : Cell(kNotReached);
}
std::string targetText(double target) {
    return target == kDisplayError ? "1/255" : number(target);
}

/// A setting's name, an automatic integrator with what it came to.
std::string shownName(const Measured& m) {
    std::string name = settingName(m.planned.setting);
    if (m.planned.setting.integrator == Integrator::automatic)
        name.insert(name.find(','), " (" + integratorNames()[static_cast<std::size_t>(m.integrator)] + ")");
    return name;
}

/// Settings that differ in step, integrator, fetch and termination alone: with all memory and the scene's
/// light.
bool isPlain(const Sweep& sweep, const Setting& s) {
    return s.detail == Detail{} && s.gradient == settingOf(sweep.scene.scene).gradient;
}

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

/// Rays that go on, all memory: what the step alone does. By method.
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

Table orderTable(const Sweep& sweep) {
    Table table{"order-" + sweep.scene.name,
                "Error (rms) by step in voxels, and the order fitted where it falls:",
                {"method"},
                {},
                true};
    std::vector<double> steps;
    for (const auto& [method, list] : byStep(sweep))
        for (const Measured* m : list)
            if (std::find(steps.begin(), steps.end(), m->planned.setting.stepVoxels) == steps.end())
                steps.push_back(m->planned.setting.stepVoxels);
    std::sort(steps.rbegin(), steps.rend());
    for (const double step : steps)
        table.columns.push_back(fractionText(step));
    table.columns.insert(table.columns.end(), {"order", "points"});
    for (const auto& [method, list] : byStep(sweep)) {
        std::vector<Cell> row = {method};
        std::vector<std::pair<double, double>> points;
        for (const double step : steps) {
            const auto found = std::find_if(list.begin(), list.end(), [step](const Measured* m) {
                return m->planned.setting.stepVoxels == step;
            });
            row.push_back(found == list.end() ? Cell("") : Cell((*found)->error.rmse));
            if (found != list.end())
                points.emplace_back(step, (*found)->error.rmse);
        }
        const auto order = fittedOrder(points, sweep.floor());
        row.push_back(order ? Cell(number(order->slope, 2)) : Cell("none"));
        row.push_back(order ? Cell(static_cast<double>(order->points)) : Cell(""));
        table.rows.push_back(std::move(row));
    }
    return table;
}

/// Every method's time at an error when only one block counts; none where some block does not reach it.
std::vector<double> blockTimesAt(const Sweep& sweep, const std::string& method, double target) {
    std::vector<double> times;
    std::size_t blocks = sweep.measured.empty() ? 0 : sweep.measured.front().blocks.size();
    for (std::size_t block = 0; block < blocks; ++block) {
        std::vector<WorkPoint> points;
        for (std::size_t i = 0; i < sweep.measured.size(); ++i) {
            const Measured& m = sweep.measured[i];
            if (isPlain(sweep, m.planned.setting) && methodName(m.planned.setting) == method &&
                !m.blocks[block].wallMs.empty())
                points.push_back({m.error.rmse, quantile(m.blocks[block].wallMs, 0), i});
        }
        const auto time = timeAtError(paretoEnvelope(points), target);
        if (!time)
            return {};
        times.push_back(*time);
    }
    return times;
}

Table equalErrorTable(const Sweep& sweep, const std::vector<PeerPoint>& peers) {
    Table table{
        "equal-error-" + sweep.scene.name,
        "Least time, ms, at equal error (rms, linear), interpolated on each method's envelope and never "
        "extrapolated. The speed-up is of the fastest over `midpoint, hardware`, with the interval that "
        "holds "
        "95 % of what blocks drawn again give; where it holds 1 or is within 3 %, no difference is claimed:",
        {"error"},
        {},
        true};
    const auto all = envelopes(sweep, peers);
    for (const auto& [method, envelope] : all)
        table.columns.push_back(method);
    table.columns.insert(table.columns.end(), {"fastest", "speed-up"});
    const std::string base = "midpoint, hardware";
    for (const double target : errorTargets()) {
        std::vector<Cell> row = {targetText(target)};
        std::string fastest = "none";
        double least = std::numeric_limits<double>::infinity();
        for (const auto& [method, envelope] : all) {
            const auto time = timeAtError(envelope, target);
            row.push_back(orNotReached(time));
            if (time && *time < least) {
                least = *time;
                fastest = method;
            }
        }
        row.push_back(fastest);
        const std::vector<double> mine = blockTimesAt(sweep, fastest, target),
                                  theirs = blockTimesAt(sweep, base, target);
        if (fastest == "none" || fastest == base || mine.empty() || theirs.empty()) {
            row.push_back("");
        } else {
            const double ratio = quantile(theirs, 0) / quantile(mine, 0);
            const RatioInterval interval = bootstrapRatio(theirs, mine);
            row.push_back(number(ratio) + " (" + number(interval.low) + " to " + number(interval.high) + ")" +
                          (interval.claimed(ratio) ? "" : ", not claimed"));
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

Table equalTimeTable(const Sweep& sweep, const std::vector<PeerPoint>& peers) {
    Table table{"equal-time-" + sweep.scene.name, "Error (rms, linear) at equal time:", {"ms"}, {}, true};
    const auto all = envelopes(sweep, peers);
    for (const auto& [method, envelope] : all)
        table.columns.push_back(method);
    for (const double ms : {16.7, 100.0, 1000.0}) {
        std::vector<Cell> row = {number(ms)};
        for (const auto& [method, envelope] : all)
            row.push_back(orNotReached(errorAtTime(envelope, ms)));
        table.rows.push_back(std::move(row));
    }
    return table;
}

std::vector<Cell> axisRow(const Measured& m) {
    return {settingName(m.planned.setting),
            m.error.rmse,
            m.error.maxAbs,
            m.error.p999,
            m.error.bias,
            m.error.psnr,
            m.error.ssim,
            m.error.luvP99,
            m.leastMs(),
            static_cast<double>(m.work.samples),
            static_cast<double>(m.peakGpuBytes) / (1024.0 * 1024.0)};
}

Table axesTable(const Sweep& sweep) {
    Table table{
        "axes-" + sweep.scene.name,
        "The scene as it is drawn by default, its levels chosen for the picture and the memory, and one "
        "thing "
        "changed at a time (`levels`: every brick at its finest, or levels within a predicted error):",
        {"axis", "setting", "rms", "max", "99.9 %", "bias", "PSNR, dB", "SSIM", "L*u*v* p99", "ms", "samples",
         "GPU MiB"},
        {},
        true};
    const auto add = [&](const std::string& axis, const Measured& m) {
        std::vector<Cell> row = {axis};
        const std::vector<Cell> rest = axisRow(m);
        row.insert(row.end(), rest.begin(), rest.end());
        table.rows.push_back(std::move(row));
    };
    const Setting asIs = settingOf(sweep.scene.scene);
    if (asIs.gradient)
        table.caption.insert(table.caption.size() - 1,
                             "; another `gradient` is another definition of the surface's "
                             "normal, so its row is a difference rather than an error");
    for (const Measured& m : sweep.measured) {
        const Setting& s = m.planned.setting;
        if (m.planned.axis == "default")
            add("as it is", m);
        else if (m.planned.axis != "product" && (s.detail != Detail{} || m.planned.axis == "levels") &&
                 s.stepVoxels == asIs.stepVoxels && s.integrator == asIs.integrator && s.fetch == asIs.fetch)
            add(m.planned.axis, m);
    }
    return table;
}

} // namespace

const std::vector<double>& errorTargets() {
    static const std::vector<double> targets = {1e-1, 1e-2, kDisplayError, 1e-3, 1e-4, 1e-5};
    return targets;
}

std::map<std::string, std::vector<WorkPoint>> envelopes(const Sweep& sweep,
                                                        const std::vector<PeerPoint>& peers) {
    std::map<std::string, std::vector<WorkPoint>> points;
    for (std::size_t i = 0; i < sweep.measured.size(); ++i) {
        const Measured& m = sweep.measured[i];
        const Setting& s = m.planned.setting;
        if (isPlain(sweep, s) && s.integrator != Integrator::automatic && m.leastMs() > 0)
            points[methodName(s)].push_back({m.error.rmse, m.leastMs(), i});
    }
    for (const PeerPoint& p : peers)
        if (p.scene == sweep.scene.name)
            points[p.renderer].push_back({p.rmse, p.ms, sweep.measured.size()});
    for (auto& [method, list] : points)
        list = paretoEnvelope(std::move(list));
    return points;
}

const Measured* paretoChoice(const Sweep& sweep) {
    const Measured* best = nullptr;
    for (const Measured& m : sweep.measured)
        if (isPlain(sweep, m.planned.setting) && m.error.rmse <= kDisplayError && m.leastMs() > 0 &&
            (!best || m.leastMs() < best->leastMs()))
            best = &m;
    return best;
}

std::vector<CommonChoice> commonChoices(const std::vector<Sweep>& sweeps) {
    std::vector<const Sweep*> reached;
    for (const Sweep& sweep : sweeps)
        if (paretoChoice(sweep))
            reached.push_back(&sweep);
    std::vector<CommonChoice> choices;
    if (reached.empty())
        return choices;
    for (const Measured& candidate : reached.front()->measured) {
        if (!isPlain(*reached.front(), candidate.planned.setting))
            continue;
        double logs = 0;
        bool everywhere = true;
        for (const Sweep* sweep : reached) {
            Setting s = candidate.planned.setting;
            s.gradient = settingOf(sweep->scene.scene).gradient;
            const Measured* m = sweep->find(s);
            everywhere = everywhere && m && m->error.rmse <= kDisplayError && m->leastMs() > 0;
            if (!everywhere)
                break;
            logs += std::log(m->leastMs() / paretoChoice(*sweep)->leastMs());
        }
        if (everywhere)
            choices.push_back(
                {candidate.planned.setting, std::exp(logs / static_cast<double>(reached.size()))});
    }
    std::sort(choices.begin(), choices.end(),
              [](const CommonChoice& a, const CommonChoice& b) { return a.slowdown < b.slowdown; });
    return choices;
}

bench::Report referenceSection(const std::vector<Sweep>& sweeps, const MeasuredOn& on, const Effort& effort) {
    Report report;
    report.name = "reference";
    report.title = "Machine and reference";
    report.text = {"Measured by " + on.version + " on " + on.machine + ".",
                   "The truth is the volume rendering integral of the finest level in double, cell by cell, "
                   "of the transfer "
                   "function's points, without ending rays, levels or steps. Errors are of linear "
                   "premultiplied RGBA in float, "
                   "over the pixels where the truth's alpha is above 0. Times are the least of " +
                       std::to_string(effort.blocks()) + " blocks of up to " +
                       std::to_string(effort.rounds()) +
                       " frames of every setting, interleaved in random order after two frames of warming "
                       "up; a frame is all "
                       "dispatches and the copy of the picture to RAM. Compiling, loading and finding empty "
                       "space are once for a "
                       "scene, and not in it. A block is taken again where a fixed calculation before and "
                       "after it differs by "
                       "more than 2 %, at most " +
                       std::to_string(effort.repeatedBlocks()) + " times."};
    Table forms{"proof-closed-forms",
                "The reference's integrator against closed forms, largest relative error:",
                {"form", "what", "error", "limit", "holds"},
                {},
                true};
    for (const ClosedFormError& f : closedFormErrors())
        forms.rows.push_back(
            {f.name, f.about, f.relativeError, f.limit, f.relativeError <= f.limit ? "yes" : "NO"});
    Table rays{
        "proof-rays",
        "The reference on rays of each scene that meet something: largest difference of a component with "
        "twice "
        "the panels (limit 1e-10), and of the unlit scene to a second integrator, adaptive Simpson from 1/64 "
        "voxel on, that shares no code with it (limit 1e-7). No error below ten times the larger is told "
        "apart:",
        {"scene", "rays", "halving", "second integrator", "holds"},
        {},
        true};
    for (const Sweep& s : sweeps)
        rays.rows.push_back({s.scene.name, static_cast<double>(s.proof.rays), s.proof.halving,
                             s.proof.independent, s.proof.holds() ? "yes" : "NO"});
    Table load{
        "load",
        "Load average of the machine, and blocks kept although the calibration moved; times are worth as "
        "much as the machine was quiet:",
        {"scene", "before", "after", "blocks", "moved"},
        {},
        true};
    for (const Sweep& s : sweeps)
        load.rows.push_back({s.scene.name, s.loadBefore, s.loadAfter, static_cast<double>(s.blocksMeasured),
                             static_cast<double>(s.blocksMoved)});
    report.tables = {std::move(forms), std::move(rays), std::move(load)};
    return report;
}

bench::Report sceneSection(const Sweep& sweep, const std::vector<PeerPoint>& peers) {
    Report report;
    report.name = "scene-" + sweep.scene.name;
    report.title = "Scene: " + sweep.scene.name;
    std::string compared = "Picture of " + std::to_string(sweep.imageSize.x) + " x " +
                           std::to_string(sweep.imageSize.y) + " pixels";
    compared += sweep.pixelStride == 1
                    ? ", all compared"
                    : ", every " + std::to_string(sweep.pixelStride) + "th pixel of every " +
                          std::to_string(sweep.pixelStride) + "th row compared";
    report.text = {sweep.scene.about + " Volume " + sweep.volume + ". " + compared + " (" +
                   std::to_string(sweep.measured.empty() ? 0 : sweep.measured.front().error.maskedPixels) +
                   " show something). The transfer function's table is off by " + number(sweep.tableError) +
                   " of the largest extinction."};
    report.tables = {equalErrorTable(sweep, peers), equalTimeTable(sweep, peers), orderTable(sweep),
                     axesTable(sweep)};
    report.plots = {workPrecisionPlot(sweep, peers), convergencePlot(sweep)};
    return report;
}

bench::Report stiffSection() {
    Report report;
    report.name = "stiff";
    report.title = "Stiff extinction";
    report.text = {
        "A slab of constant extinction whose colour is a ramp (closed form T6) in " +
        std::to_string(kStiffSegments) +
        " segments, by the arithmetic that march and mirror share, in double and in float, over twelve "
        "decades of optical depth."};
    Table table{"stiff", "Relative error by optical depth:", {"optical depth"}, {}, true};
    Plot plot{
        "stiff",
        "Relative error of the colour. The mean over a segment's values is here the colour of its middle, so "
        "that `pre-integrated` covers `midpoint`:",
        "optical depth of the slab",
        "relative error",
        true,
        true,
        {},
        true};
    const std::vector<StiffCurve> curves = stiffCurves();
    for (const StiffCurve& curve : curves) {
        table.columns.push_back(curve.name);
        Plot::Curve shown{curve.name, {}, Plot::Style::line, -1};
        const bool isFloat = curve.name.ends_with("float");
        shown.style = isFloat ? Plot::Style::dashed : Plot::Style::line;
        shown.colour = 1 + static_cast<int>(&curve - curves.data()) / 2; // as in the other figures
        for (const auto& [depth, error] : curve.points)
            shown.points.emplace_back(depth, std::max(error, 1e-17)); // zero has no place on the axis
        plot.curves.push_back(std::move(shown));
    }
    for (std::size_t i = 0; i < curves.front().points.size(); i += 8) {
        std::vector<Cell> row = {number(curves.front().points[i].first)};
        for (const StiffCurve& curve : curves)
            row.push_back(curve.points[i].second);
        table.rows.push_back(std::move(row));
    }
    report.tables = {std::move(table)};
    report.plots = {std::move(plot)};
    return report;
}

bench::Report defaultsSection(const std::vector<Sweep>& sweeps) {
    Report report;
    report.name = "defaults";
    report.title = "Defaults";
    report.text = {
        "The Pareto choice at 1/255 is the fastest setting whose rms error is at most 1/255, computed from "
        "the runs. All memory, the finest levels and the scene's own light.",
        "`tessera render` takes, where the scene names none, the longest step whose estimated error is "
        "within "
        "1/255, and where the function leaves a doubt tries both integrators on some pixels: that is what "
        "the "
        "column *as it is* shows. Levels are chosen apart, for the memory and for what a pixel can show; "
        "what "
        "they cost is the axis `memory` of each scene."};
    Table scenes{"defaults",
                 "By scene, beside what the scene itself asks for:",
                 {"scene", "Pareto choice at 1/255", "its rms", "its ms", "as it is", "its rms", "its ms",
                  "times slower"},
                 {},
                 true};
    for (const Sweep& sweep : sweeps) {
        const Measured* best = paretoChoice(sweep);
        const Measured* asIs = sweep.find(settingOf(sweep.scene.scene));
        std::vector<Cell> row = {sweep.scene.name};
        if (best)
            append(row, settingName(best->planned.setting), best->error.rmse, best->leastMs());
        else
            append(row, std::string(kNotReached), std::string(), std::string());
        if (asIs)
            append(row, shownName(*asIs), asIs->error.rmse, asIs->leastMs());
        else
            append(row, std::string("not drawn"), std::string(), std::string());
        row.push_back(best && asIs && best->leastMs() > 0 ? Cell(asIs->leastMs() / best->leastMs())
                                                          : Cell(""));
        scenes.rows.push_back(std::move(row));
    }
    report.tables = {std::move(scenes)};
    std::size_t within = 0;
    for (const Sweep& sweep : sweeps)
        if (const Measured* asIs = sweep.find(settingOf(sweep.scene.scene)))
            within += asIs->error.rmse <= kDisplayError;
    report.after = {"As they are, " + std::to_string(within) + " of " + std::to_string(sweeps.size()) +
                    (sweeps.size() == 1 ? " scene stays" : " scenes stay") + " within 1/255."};
    if (sweeps.size() > 1) {
        Table common{
            "defaults-common",
            "One setting for all scenes: within 1/255 in every scene that any setting reaches it in, and how "
            "many times slower than each scene's own choice (geometric mean):",
            {"setting", "times slower"},
            {},
            true};
        const std::vector<CommonChoice> choices = commonChoices(sweeps);
        for (std::size_t i = 0; i < std::min<std::size_t>(choices.size(), 8); ++i)
            common.rows.push_back({settingName(choices[i].setting), choices[i].slowdown});
        if (choices.empty())
            common.rows.push_back({"none", ""});
        report.tables.push_back(std::move(common));
    }
    return report;
}

bench::Report runsSection(const std::vector<Sweep>& sweeps, const MeasuredOn& on,
                          const std::vector<std::string>& omissions) {
    Report report;
    report.name = "runs";
    report.title = "Runs, failures and omissions";
    Table fails = failTable(sweeps);
    if (fails.rows.empty())
        report.text.push_back("Nothing was refused and nothing went wrong.");
    Table summary{"fail-summary", "The same, counted:", {"scene", "what", "settings", "the first"}, {}, true};
    for (const auto& row : fails.rows) {
        const auto same = std::find_if(summary.rows.begin(), summary.rows.end(),
                                       [&](const auto& r) { return r[0] == row[0] && r[1] == row[2]; });
        if (same == summary.rows.end())
            summary.rows.push_back({row[0], row[2], 1.0, row[1]});
        else
            (*same)[2] = std::get<double>((*same)[2]) + 1;
    }
    fails.onPage = false;
    const bool any = !fails.rows.empty();
    report.tables = {runsTable(sweeps, on), std::move(fails)};
    if (any)
        report.tables.push_back(std::move(summary));
    std::string list = "Left out:\n";
    for (const std::string& omission : omissions)
        list += "\n- " + omission;
    report.after = {list};
    return report;
}

} // namespace tessera::accuracy
