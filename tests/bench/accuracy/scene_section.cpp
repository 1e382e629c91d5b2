// tests/bench/accuracy/scene_section.cpp: see scene_section.h.
#include "tests/bench/accuracy/scene_section.h"

#include "tests/bench/accuracy/pareto.h"
#include "tests/bench/accuracy/report_cells.h"
#include "tests/bench/accuracy/scene_plots.h"
#include "tests/bench/report/work_precision.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace tessera::accuracy {
namespace {

using bench::Cell;
using bench::Report;
using bench::Table;

std::string targetText(double target) {
    return target == kDisplayError ? "1/255" : number(target);
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

/// Pixels that the truth shows something in, of those compared.
std::size_t shownPixels(const Sweep& sweep) {
    return sweep.measured.empty() ? 0 : sweep.measured.front().error.maskedPixels;
}

/// The worth of the curves of this scene's other renderers beside the rest; empty if there are none.
std::string peersText(const Sweep& sweep, const std::vector<PeerPoint>& peers) {
    bool any = false, vtk = false;
    std::map<std::string, double> pixels; // if reported, by renderer
    for (const PeerPoint& p : peers)
        if (p.scene == sweep.scene.name) {
            any = true;
            vtk = vtk || p.renderer.starts_with("vtk");
            if (p.pixels > 0 && p.pixels != static_cast<double>(shownPixels(sweep)))
                pixels[p.renderer] = p.pixels;
        }
    if (!any)
        return {};
    std::string text =
        "Other renderers were measured on the same scene in runs of their own, not interleaved "
        "with these.";
    if (vtk)
        text +=
            " VTK's mappers hold the whole volume, whatever memory Tessera has in this scene. They are "
            "given the transfer function's points as nodes and its opacity unit distance; both sample these "
            "into tables of their own, and what those lose is part of their error. They hand out 8 bits a "
            "channel, so their errors end at about 0.001; rays along the volume's outermost half voxels, "
            "which VTK does not draw, are left out of their errors.";
    for (const auto& [renderer, count] : pixels)
        text += " Errors of `" + renderer + "` are over " + formatNumber(count, 9) + " pixels.";
    return text;
}

} // namespace

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
                   std::to_string(shownPixels(sweep)) +
                   " show something). The transfer function's table is off by " + number(sweep.tableError) +
                   " of the largest extinction."};
    if (std::string text = peersText(sweep, peers); !text.empty())
        report.text.push_back(std::move(text));
    report.tables = {equalErrorTable(sweep, peers), equalTimeTable(sweep, peers), orderTable(sweep),
                     axesTable(sweep)};
    report.plots = {workPrecisionPlot(sweep, peers), convergencePlot(sweep)};
    return report;
}

} // namespace tessera::accuracy
