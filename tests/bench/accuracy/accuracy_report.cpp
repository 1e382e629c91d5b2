// tests/bench/accuracy/accuracy_report.cpp: see accuracy_report.h.
#include "tests/bench/accuracy/accuracy_report.h"

#include "tests/bench/accuracy/pareto.h"
#include "tests/bench/accuracy/report_cells.h"
#include "tests/bench/accuracy/stiff.h"

#include <algorithm>
#include <utility>

namespace tessera::accuracy {
namespace {

using bench::Cell;
using bench::Plot;
using bench::Report;
using bench::Table;

/// Cells one by one: lists of variants made of literals are more than GCC 12 can follow without a warning.
template <typename... Cells> void append(std::vector<Cell>& row, Cells&&... cells) {
    (row.push_back(Cell(std::forward<Cells>(cells))), ...);
}

/// A setting's name, an automatic integrator with what it came to.
std::string shownName(const Measured& m) {
    std::string name = settingName(m.planned.setting);
    if (m.planned.setting.integrator == Integrator::automatic)
        name.insert(name.find(','), " (" + integratorNames()[static_cast<std::size_t>(m.integrator)] + ")");
    return name;
}

} // namespace

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
        "the panels (limit 1e-10), and to a second integrator, adaptive Simpson from 1/64 "
        "voxel on (limit 1e-7). The two share samples and transfer function, but neither interpolation, nor "
        "cuts, nor quadrature, nor how gradients are taken. Surfaces alone are compared in a thin fog, or "
        "their places would not show. "
        "No error below ten times the larger is told apart:",
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
