// tests/bench/lod/calibration_report.cpp: the experiment "calibration": promised errors against true ones.
#include "tests/bench/lod/calibration.h"
#include "tests/bench/lod/experiments.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>

namespace tessera::bench {
namespace {

std::string text(const CalibrationShares::Share& share) {
    return share.of == 0 ? "none" : std::to_string(share.hold) + " of " + std::to_string(share.of);
}
std::string percent(const CalibrationShares::Share& share) {
    return share.of == 0 ? "none"
                         : text(share) + " (" + formatCell(std::round(1000 * share.part()) / 10) + " %)";
}

/// A median, where there is one.
Cell orNone(double number) {
    return std::isnan(number) ? Cell("none") : Cell(number);
}
Cell cell(const std::optional<double>& number) {
    return number ? Cell(*number) : Cell("not measured");
}
void append(std::vector<Cell>& row, const std::optional<Estimate>& e) {
    row.push_back(e ? Cell(e->value) : Cell("not measured"));
    row.push_back(e ? Cell(e->low) : Cell(""));
    row.push_back(e ? Cell(e->high) : Cell(""));
}

Table caseTable(const std::vector<CalibrationCase>& cases) {
    Table table{"calibration",
                "A line a picture:",
                {"volume",
                 "function",
                 "view",
                 "light",
                 "seen before",
                 "setting",
                 "max error",
                 "GPU bytes",
                 "true p99",
                 "true mean",
                 "true rms",
                 "shown pixels",
                 "predicted p99",
                 "p99",
                 "p99 from",
                 "p99 to",
                 "p99 bound",
                 "mean",
                 "mean from",
                 "mean to",
                 "rms",
                 "rms from",
                 "rms to",
                 "pixels drawn again",
                 "p99 of samples",
                 "p99 of rays",
                 "samples a pixel",
                 "step voxels",
                 "finest level",
                 "pictures",
                 "bytes",
                 "seconds",
                 "not measured because",
                 "not reached because"},
                {},
                false};
    for (const CalibrationCase& c : cases) {
        std::vector<Cell> row = {
            c.volume, c.preset, c.view, c.lit ? "lit" : "plain", c.seenBefore ? "yes" : "no", c.setting};
        row.push_back(c.asked ? Cell(*c.asked) : Cell(""));
        for (const double number : {static_cast<double>(c.budgetBytes), c.is.luvP99, c.is.luvMean, c.is.rms,
                                    static_cast<double>(c.is.maskedPixels), c.predictedP99})
            row.emplace_back(number);
        append(row, c.measured.luvP99);
        row.push_back(cell(c.measured.luvP99Bound));
        append(row, c.measured.luvMean);
        append(row, c.measured.rms);
        row.emplace_back(static_cast<double>(c.measured.shown));
        for (const MeasuredErrors* part : {&c.samples, &c.rays})
            row.push_back(part->luvP99 ? Cell(part->luvP99->value) : Cell("not measured"));
        for (const double number : {c.samplesPerPixel, c.stepVoxels, double(c.level), double(c.rounds),
                                    static_cast<double>(c.bytes), c.seconds})
            row.emplace_back(number);
        row.emplace_back(c.whyNot);
        row.emplace_back(c.shortfall);
        table.rows.push_back(std::move(row));
    }
    return table;
}

/// Shares by what a case belongs to, in the order of its first case; the last row is of all.
Table sharesTable(const std::vector<CalibrationCase>& cases, const std::string& name,
                  const std::string& caption, const std::string& what,
                  const std::function<std::string(const CalibrationCase&)>& groupOf) {
    Table table{name,
                caption,
                {what, "pictures", "`--max-error` kept", "said not to be", "p99 in its interval", "mean",
                 "rms", "p99 within its bound", "no p99", "true / measured p99", "true / predicted p99"},
                {},
                true};
    std::vector<std::string> order;
    std::map<std::string, std::vector<const CalibrationCase*>> groups;
    for (const CalibrationCase& c : cases)
        for (const std::string& group : {groupOf(c), std::string("all")}) {
            groups[group].push_back(&c);
            if (group != "all" && std::find(order.begin(), order.end(), group) == order.end())
                order.push_back(group);
        }
    order.emplace_back("all");
    for (const std::string& group : order) {
        const CalibrationShares s = sharesOf(groups[group]);
        table.rows.push_back({group, double(s.cases), text(s.maxError), double(s.notReached), text(s.p99),
                              text(s.mean), text(s.rms), text(s.bound), double(s.noP99), orNone(s.trueToP99),
                              orNone(s.trueToGuess)});
    }
    return table;
}

Table truthTable(const std::vector<CalibrationScene>& scenes) {
    Table table{
        "calibration-truth",
        "The truth of each scene, L\\*u\\*v\\* at the 99th percentile: its noise, from how two halves of its "
        "samples differ, and what lies between it and the reference through the same places:",
        {"scene", "pixels that show something", "with four times the samples", "noise", "pixels of reference",
         "to reference", "rms to reference"},
        {},
        true};
    for (const CalibrationScene& s : scenes)
        table.rows.push_back({s.name, static_cast<double>(s.truth.shown), static_cast<double>(s.truth.noisy),
                              s.truth.noiseLuvP99, double(s.truth.referencePixels), s.truth.referenceLuvP99,
                              s.truth.referenceRms});
    return table;
}

std::vector<std::string> conclusions(const std::vector<CalibrationCase>& cases) {
    std::vector<const CalibrationCase*> all, fresh;
    for (const CalibrationCase& c : cases) {
        all.push_back(&c);
        if (!c.seenBefore)
            fresh.push_back(&c);
    }
    const auto sentence = [](const std::string& of, const CalibrationShares& s) {
        return of + ": `--max-error` is kept by " + percent(s.maxError) +
               " of the pictures that say so, and " + std::to_string(s.notReached) +
               " say that they do not; the interval of p99 holds the truth in " + percent(s.p99) +
               ", of the mean in " + percent(s.mean) + ", of rms in " + percent(s.rms) +
               "; p99 is within its bound in " + percent(s.bound) + ". True over measured p99: median " +
               formatCell(orNone(s.trueToP99)) + "; over predicted: " + formatCell(orNone(s.trueToGuess)) +
               ".";
    };
    return {sentence("All pictures", sharesOf(all)),
            sentence("Of volumes that were not looked at before", sharesOf(fresh))};
}

} // namespace

Report calibrationReport(const Workbench& bench) {
    const int pixels = bench.quick ? 64 : 160;
    AreaTruthEffort effort;
    std::vector<double> maxErrors(std::begin(kCalibratedMaxErrors), std::end(kCalibratedMaxErrors));
    if (bench.quick) {
        effort.side = 8;
        effort.stepVoxels = 1.0 / 8;
        effort.referencePixels = 20;
        effort.referenceSide = 4;
        maxErrors = {10};
    }
    std::vector<CalibrationCase> cases;
    std::vector<CalibrationScene> scenes;
    int turn = 0;
    for (const BenchVolume& volume : bench.volumes)
        calibrate(bench, volume, pixels, effort, maxErrors, turn, cases, scenes);

    Report report;
    report.name = "calibration";
    report.title = "Promised and true errors";
    const std::string size = std::to_string(pixels) + " x " + std::to_string(pixels);
    std::string seen;
    for (const BenchVolume& volume : bench.volumes)
        if (volume.seenBefore)
            seen += (seen.empty() ? "*" : ", *") + volume.name + "*";
    report.text = {
        "What a picture says of its error, and what that is. Pictures of " + size +
            " pixels by the native engine with `--samples auto --verify full`: every volume and its "
            "functions, from "
            "the front, the left (parallel) and above in turn, plain and lit in turn; each with the least "
            "GPU memory "
            "that the program names (*floor*), with all of it (*ample*), with the geometric mean of both "
            "(*between*), and with `--max-error`. *Predicted*: the sum of what levels, step and filtering "
            "are said "
            "to cost before anything is measured; what its samples of a pixel leave out is not in it. "
            "*Measured*: pixels drawn again "
            "([measured-errors.md](measured-errors.md)).",
        "The truth is found apart from all that: the mean over a pixel's area of " +
            std::to_string(effort.side * effort.side) + " stratified rays with a step of " +
            formatCell(effort.stepVoxels) +
            " voxels through the finest levels, exact, none ended early; four times as many where halves of "
            "them "
            "say that they can be off by more than " +
            formatCell(effort.noisy) +
            ". All pixels have one, because a truth of some has chance of its own, and intervals promise to "
            "hold "
            "what all pixels are. The reference's integral through " +
            std::to_string(effort.referenceSide * effort.referenceSide) + " places in each of " +
            std::to_string(effort.referencePixels) +
            " pixels says whether it is right. All numbers are L\\*u\\*v\\*, over pixels where the truth's "
            "alpha is "
            "above 1/255, but rms, which is linear light. Mean and rms are freed of the truth's own noise, "
            "as two "
            "independent halves of its samples tell it; p99 is not, which makes it larger. An interval is of "
            "95 %. A `--max-error` is *kept* "
            "where "
            "the true p99 is within it; those that said that they do not reach it are counted apart."};
    if (!seen.empty())
        report.text.push_back("Looked at while what is measured here was made: " + seen +
                              "; the others were not.");
    report.plots = {calibrationPlot(cases)};
    report.tables = {sharesTable(cases, "calibration-settings", "By setting; ratios are medians:", "setting",
                                 [](const CalibrationCase& c) { return c.setting; }),
                     sharesTable(cases, "calibration-scans", "By volume and function:", "volume, function",
                                 [](const CalibrationCase& c) {
                                     return c.volume + ", " + c.preset +
                                            (c.seenBefore ? " (seen before)" : "");
                                 }),
                     truthTable(scenes), caseTable(cases)};
    report.after = conclusions(cases);
    return report;
}

} // namespace tessera::bench
