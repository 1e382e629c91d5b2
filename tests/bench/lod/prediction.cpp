// tests/bench/lod/prediction.cpp: predicted errors of bricks against the true ones. Choices made by them are
// compared with choices made by the true errors, and by less.
#include "tests/bench/lod/brick_truth.h"
#include "tests/bench/lod/experiments.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::bench {
namespace {

constexpr double kPredictedReductions[] = {8, 20, 80};

/// Errors of the bricks that show something, at one level.
std::vector<double> column(const LevelErrors& errors, std::size_t level) {
    std::vector<double> out;
    for (std::size_t n = 0; n < errors.shows.size(); ++n)
        if (errors.shows[n])
            out.push_back(static_cast<double>(errors.errors[n][level]));
    return out;
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return n == 0 ? 0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

} // namespace

Report predictionReport(const Workbench& bench) {
    Report report;
    report.name = "prediction";
    report.title = "Predicted and true errors";
    report.text = {
        "The true error of a brick at a level: the brick alone before black, every row of voxels along the "
        "three axes, seen from both ends, composited from level 0 and from that level, mean CIE L*u*v* "
        "distance. The prediction knows " +
        std::to_string(kBrickRayParts * kRaysPerPart) +
        " sampled rays of it. Levels are chosen for pictures of " + std::to_string(bench.pixels()) + " x " +
        std::to_string(bench.pixels()) +
        " pixels, camera anterior; every second pixel each way is drawn. Rank correlations (Spearman) are "
        "over the bricks that show something. All choices but that of one level weigh a brick by the pixels "
        "it covers (by distance: one over the distance) and by how visible the product counts it to be."};
    Table ranks{"prediction",
                "Rank correlation of predicted and true error, per level; pooled: all levels "
                "together; data error: the root mean square of the values' change, for comparison:",
                {"scene", "bricks", "level 1", "level 2", "level 3", "level 4", "level 5", "pooled",
                 "data error, pooled"},
                {},
                true};
    Table choices{"prediction-choices",
                  "Error of the picture (mean L*u*v*, p99 in brackets in the CSV's own "
                  "columns) at equal pages, levels chosen by:",
                  {"scene", "reduction", "true errors", "predicted", "predicted to true", "data error",
                   "distance", "one level", "true errors p99", "predicted p99", "data error p99",
                   "distance p99", "one level p99"},
                  {},
                  true};
    choices.caption =
        "Error of the picture at equal pages, mean and 99th percentile of L*u*v*, levels chosen by:";
    std::vector<double> cases, ratios;
    int beats = 0, contests = 0;
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets) {
            SceneBench scene(bench, volume, preset, "anterior", bench.fewerPixels());
            const Selection& culled = scene.culled();
            const WholeLevels levels = loadLevels(scene.store());
            const std::vector<std::uint8_t>& shows = scene.shows();
            const LevelErrors& predicted = scene.predicted();
            const LevelErrors real = trueErrors(levels, shows, scene.prepared().layer().table, 0);
            const LevelErrors data = dataErrors(levels, shows, 0);
            std::vector<Cell> row = {volume.name + ", " + preset, static_cast<double>(culled.shownBricks())};
            std::vector<double> allPredicted, allReal, allData;
            for (std::size_t level = 1; level < kLevelCount; ++level) {
                const std::vector<double> p = column(predicted, level), t = column(real, level),
                                          d = column(data, level);
                row.emplace_back(rankCorrelation(p, t));
                cases.push_back(std::get<double>(row.back()));
                allPredicted.insert(allPredicted.end(), p.begin(), p.end());
                allReal.insert(allReal.end(), t.begin(), t.end());
                allData.insert(allData.end(), d.begin(), d.end());
            }
            row.emplace_back(rankCorrelation(allPredicted, allReal));
            row.emplace_back(rankCorrelation(allData, allReal));
            ranks.rows.push_back(std::move(row));

            const Drawn truth = scene.draw(culled);
            const LevelErrors sizes = sizeErrors(predicted.bricks, shows);
            const ViewWeights byDistance = distanceWeights(scene.weights());
            for (const double reduction : kPredictedReductions) {
                if (reduction <= scene.reductionOf(culled))
                    continue; // everything fits: nothing to choose
                const std::size_t pages = scene.pagesAt(reduction);
                const std::vector<float> seen = scene.seenAt(reduction);
                std::vector<ImageDifference> d;
                const auto add = [&](const Selection& selection) {
                    d.push_back(SceneBench::difference(scene.draw(selection), truth));
                };
                for (const LevelErrors* errors : {&real, &predicted, &data})
                    add(selectLevels(*errors, scene.weights(), culled.means, pages, seen));
                add(selectLevels(sizes, byDistance, culled.means, pages, seen));
                add(selectUniform(predicted, culled.means, pages));
                const double ratio = d[0].luvMean > 0 ? d[1].luvMean / d[0].luvMean : 1;
                ratios.push_back(ratio);
                ++contests;
                beats += d[1].luvMean < std::min({d[2].luvMean, d[3].luvMean, d[4].luvMean});
                choices.rows.push_back({volume.name + ", " + preset, reduction, d[0].luvMean, d[1].luvMean,
                                        ratio, d[2].luvMean, d[3].luvMean, d[4].luvMean, d[0].luvP99,
                                        d[1].luvP99, d[2].luvP99, d[3].luvP99, d[4].luvP99});
            }
            bench.done(scene.name());
        }
    report.tables = {std::move(ranks), std::move(choices)};
    if (!cases.empty())
        report.after.push_back(
            "Median rank correlation over scenes and levels: " + formatCell(median(cases)) + ", lowest " +
            formatCell(*std::min_element(cases.begin(), cases.end())) + ".");
    if (!ratios.empty())
        report.after.push_back(
            "Error of the picture chosen by predictions to that chosen by true errors: median " +
            formatCell(median(ratios)) + ", largest " +
            formatCell(*std::max_element(ratios.begin(), ratios.end())) +
            ". It beats data error, distance and one level in " + std::to_string(beats) + " of " +
            std::to_string(contests) + " cases.");
    return report;
}

} // namespace tessera::bench
