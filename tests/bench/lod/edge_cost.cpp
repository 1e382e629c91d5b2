// tests/bench/lod/edge_cost.cpp: the cost of each edge function in the picture of real scans; the default is
// chosen by this.
#include "tests/bench/lod/experiments.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::bench {
namespace {

constexpr std::array<EdgeFunction, 4> kFunctions = {EdgeFunction::nearest, EdgeFunction::minimum,
                                                    EdgeFunction::split, EdgeFunction::maximum};
constexpr double kEdgeReductions[] = {8, 30, 120};

std::string nameOf(EdgeFunction function) {
    return edgeFunctionNames()[static_cast<std::size_t>(function)];
}

/// The edge function with the least error of the four.
std::string bestOf(const std::array<double, 4>& errors) {
    return nameOf(kFunctions[static_cast<std::size_t>(std::min_element(errors.begin(), errors.end()) -
                                                      errors.begin())]);
}

} // namespace

Report edgeCostReport(const Workbench& bench) {
    Report report;
    report.name = "edges";
    report.title = "Edge functions on scans";
    report.text = {
        "The same selections of levels drawn with each edge function, every segment sampled, against "
        "the finest picture (every brick that shows something at level 0): CIE L*u*v* distance over "
        "pixels with alpha above 1/255. The default edge function is the one with the least error "
        "here, not the smoothest. Levels are chosen for pictures of " +
        std::to_string(bench.pixels()) + " x " + std::to_string(bench.pixels()) +
        " pixels; every second pixel each way is drawn."};
    Table table{"edges",
                "Mean and 99th percentile:",
                {"scene", "reduction", "nearest", "minimum", "split", "maximum", "best by mean",
                 "nearest p99", "minimum p99", "split p99", "maximum p99", "best by p99"},
                {},
                true};
    Table summary{"edges-summary",
                  "",
                  {"volume", "pictures", "nearest", "minimum", "split", "maximum", "best by mean",
                   "nearest p99", "minimum p99", "split p99", "maximum p99", "best by p99"},
                  {},
                  true};
    summary.caption = "Errors relative to those of `minimum`, geometric means over the pictures:";
    std::array<double, 8> allSums{};
    double allPictures = 0;
    const auto addSummary = [&summary](const std::string& name, double pictures,
                                       const std::array<double, 8>& sums) {
        std::array<double, 4> mean{}, p99{};
        for (std::size_t f = 0; f < 4; ++f) {
            mean[f] = std::exp(sums[f] / pictures);
            p99[f] = std::exp(sums[4 + f] / pictures);
        }
        summary.rows.push_back({name, pictures, mean[0], mean[1], mean[2], mean[3], bestOf(mean), p99[0],
                                p99[1], p99[2], p99[3], bestOf(p99)});
    };
    for (const BenchVolume& volume : bench.volumes) {
        if (!volume.isScan && bench.volumes.size() > 1)
            continue; // generated volumes only where there is nothing else: they are too smooth to choose by
        std::array<double, 8> sums{};
        double pictures = 0;
        for (const std::string& preset : volume.presets) {
            SceneBench scene(bench, volume, preset, "anterior", bench.fewerPixels());
            const Selection& culled = scene.culled();
            Setting setting;
            setting.sampling = Sampling::full;
            const Drawn truth = scene.draw(culled, setting);
            for (const double reduction : kEdgeReductions) {
                const Selection selection = scene.chosenAt(reduction);
                if (selection.uniform())
                    continue; // all edge functions are one there
                std::array<double, 4> mean{}, p99{};
                for (std::size_t f = 0; f < kFunctions.size(); ++f) {
                    setting.edgeFunction = kFunctions[f];
                    const ImageDifference d = SceneBench::difference(scene.draw(selection, setting), truth);
                    mean[f] = d.luvMean;
                    p99[f] = d.luvP99;
                }
                table.rows.push_back({scene.name(), scene.reductionOf(selection), mean[0], mean[1], mean[2],
                                      mean[3], bestOf(mean), p99[0], p99[1], p99[2], p99[3], bestOf(p99)});
                constexpr double kLeast = 1e-6; // no logarithm of nothing
                constexpr std::size_t kMinimum = 1;
                for (std::size_t f = 0; f < kFunctions.size(); ++f) {
                    sums[f] += std::log(std::max(mean[f], kLeast) / std::max(mean[kMinimum], kLeast));
                    sums[4 + f] += std::log(std::max(p99[f], kLeast) / std::max(p99[kMinimum], kLeast));
                }
                ++pictures;
            }
            bench.done(scene.name());
        }
        if (pictures == 0)
            continue;
        addSummary(volume.name, pictures, sums);
        if (!volume.isScan)
            continue;
        allPictures += pictures;
        for (std::size_t i = 0; i < sums.size(); ++i)
            allSums[i] += sums[i];
    }
    if (allPictures > 0) {
        addSummary("all scans", allPictures, allSums);
        // Nearest leaves seams, which the contract does not allow a default to have.
        const auto leastContinuous = [&](std::size_t first) {
            const auto begin = allSums.begin() + static_cast<std::ptrdiff_t>(first) + 1;
            const auto least = std::min_element(begin, begin + 3);
            return nameOf(kFunctions[static_cast<std::size_t>(least - begin) + 1]);
        };
        report.after = {
            "Over all scans, of the functions without seams (all but nearest), the least error has " +
            leastContinuous(0) + " in the mean and " + leastContinuous(4) + " at the 99th percentile."};
    }
    report.tables = {std::move(summary), std::move(table)};
    return report;
}

} // namespace tessera::bench
