// viewer/bench/reductions.cpp: how far data shrink before a picture suffers: figure 2.27 of the course notes
// on advanced volume ray casting, on named scans, functions and cameras.
#include "viewer/bench/experiments.h"
#include "viewer/bench/pictures.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tessera::bench {
namespace {

constexpr double kLosslessMean = 0.5, kLosslessP99 = 3; // L*u*v*: "virtually lossless"
constexpr double kMedium = 80, kExtreme = 315;          // as in the source
constexpr double kErrorScale = 20;                      // L*u*v* that error pictures end at

bool isLossless(const ImageDifference& d) {
    return d.luvMean <= kLosslessMean && d.luvP99 <= kLosslessP99;
}

/// A selection as it was drawn.
struct Choice {
    double reduction = 0;
    ImageDifference error;
    PredictedError predicted;
    Image image;
};

Choice drawn(SceneBench& scene, const Drawn& truth, double reduction) {
    const Selection selection = scene.chosenAt(reduction);
    Drawn picture = scene.draw(selection);
    return {scene.reductionOf(selection), SceneBench::difference(picture, truth),
            predictError(selection, scene.predicted(), scene.weights()), std::move(picture.image)};
}

/// The largest reduction that is virtually lossless, by halving the interval of its logarithm.
Choice mostLossless(SceneBench& scene, const Drawn& truth, int rounds) {
    const double culling = scene.reductionOf(scene.culled());
    double good = culling, bad = 50 * culling;
    Choice best{culling, {}, {}, truth.image};
    for (int round = 0; round < rounds; ++round) {
        const double middle = std::sqrt(good * bad);
        Choice choice = drawn(scene, truth, middle);
        if (isLossless(choice.error)) {
            good = middle;
            best = std::move(choice);
        } else {
            bad = middle;
        }
    }
    return best;
}

std::string fileName(std::string scene, const std::string& what) {
    std::string name = "reductions-";
    for (const char c : scene)
        if (c == ',')
            name += '-';
        else if (c != ' ')
            name += c;
    return name + "-" + what;
}

} // namespace

Report reductionsReport(const Workbench& bench) {
    Report report;
    report.name = "reductions";
    report.title = "Data reductions (figure 2.27)";
    report.text = {
        "Every picture is drawn from as many pages as the reduction leaves, levels chosen by predicted "
        "error, "
        "limited sampling, default edge function, and compared with the finest picture (every brick that "
        "shows "
        "something at level 0): CIE L*u*v* distance over pixels with alpha above 1/255. *Virtually lossless* "
        "means a mean of at most 0.5 and a 99th percentile of at most 3; the largest reduction that reaches "
        "it "
        "was searched for. *Culling alone* leaves out bricks that the function shows nothing of, and keeps "
        "the "
        "rest at level 0. Pages are the unit: a reduction counts all texels of the pages in use, free slots "
        "and "
        "bricks that the volume's border cuts included."};
    const std::string size = std::to_string(bench.pixels());
    Table table{"reductions",
                "Pictures of " + size + " x " + size + " pixels:",
                {"scene", "culling alone", "virtually lossless at", "mean", "p99", "6:1 mean", "6:1 p99",
                 "80:1 got", "80:1 mean", "80:1 p99", "315:1 got", "315:1 mean", "315:1 p99"},
                {},
                true};
    Table curve{"reductions-curve",
                "Errors by reduction, true and predicted:",
                {"scene", "reduction", "mean", "p99", "predicted mean", "predicted p99"},
                {},
                false};
    Plot plot{"reductions-plot",
              "Mean error by reduction, camera anterior:",
              "data reduction",
              "mean L*u*v* error",
              true,
              true,
              {}};
    Figure figure;
    figure.columns = {"finest", "virtually lossless", "80:1", "315:1", "error at 80:1"};
    figure.caption =
        "Side by side, camera anterior (error: 0 dark to " + formatCell(kErrorScale) + " bright):";
    int reached = 0, scenes = 0;
    const std::vector<std::string> cameras = bench.quick
                                                 ? std::vector<std::string>{"anterior"}
                                                 : std::vector<std::string>{"anterior", "left", "near"};
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets)
            for (const std::string& camera : cameras) {
                SceneBench scene(bench, volume, preset, camera);
                const Drawn truth = scene.draw(scene.culled());
                const Choice lossless = mostLossless(scene, truth, bench.quick ? 3 : 7);
                const Choice six = drawn(scene, truth, 6), medium = drawn(scene, truth, kMedium),
                             extreme = drawn(scene, truth, kExtreme);
                table.rows.push_back({scene.name(), scene.reductionOf(scene.culled()), lossless.reduction,
                                      lossless.error.luvMean, lossless.error.luvP99, six.error.luvMean,
                                      six.error.luvP99, medium.reduction, medium.error.luvMean,
                                      medium.error.luvP99, extreme.reduction, extreme.error.luvMean,
                                      extreme.error.luvP99});
                ++scenes;
                reached += lossless.reduction >= 6;
                bench.common.note("reductions: " + scene.name() + " done");
                if (camera != "anterior")
                    continue;
                Plot::Curve line{volume.name + ", " + preset, {}};
                for (double reduction = 4; reduction <= 512; reduction *= bench.quick ? 4 : 2) {
                    const Choice choice = drawn(scene, truth, reduction);
                    curve.rows.push_back({scene.name(), choice.reduction, choice.error.luvMean,
                                          choice.error.luvP99, choice.predicted.mean, choice.predicted.p99});
                    if (choice.error.luvMean > 0)
                        line.points.emplace_back(choice.reduction, choice.error.luvMean);
                }
                plot.curves.push_back(std::move(line));
                figure.rows.push_back({volume.name + ", " + preset,
                                       {{fileName(scene.name(), "finest"), truth.image},
                                        {fileName(scene.name(), "lossless"), lossless.image},
                                        {fileName(scene.name(), "80"), medium.image},
                                        {fileName(scene.name(), "315"), extreme.image},
                                        {fileName(scene.name(), "80-error"),
                                         colourMapped(luvDifferences(medium.image, truth.image),
                                                      truth.image.size, kErrorScale)}}});
            }
    report.tables = {std::move(table), std::move(curve)};
    report.figures = {std::move(figure)};
    report.plots = {std::move(plot)};
    report.after = {"Virtually lossless at 6:1 or better: " + std::to_string(reached) + " of " +
                    std::to_string(scenes) + " scenes."};
    return report;
}

} // namespace tessera::bench
