// tests/bench/lod/reductions.cpp: the reduction of data before a picture suffers: figure 2.27 of the course
// notes on advanced volume ray casting, on named scans, functions and cameras.
#include "bricking/levels/visibility.h"
#include "tests/bench/lod/experiments.h"
#include "tests/bench/lod/pictures.h"
#include "tests/bench/lod/seen_bricks.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::bench {
namespace {

constexpr double kLosslessMean = 0.5, kLosslessP99 = 3; // L*u*v*: "virtually lossless"
constexpr double kShownReductions[] = {6, 80, 315};     // as in the source
constexpr double kErrorScale = 20;                      // L*u*v* that error pictures end at
/// The largest difference that no pixel of 8 bits can show.
constexpr float kUnseen = 1.0f / 510;

/// The knowledge of occlusion behind a choice of levels. It is none, the prediction of the bricks' rays, the
/// visibility in a picture of the levels so chosen (as in the product), or the truth.
enum class Way { allVisible, predicted, counted, asSeen };
constexpr std::array<std::pair<Way, const char*>, 4> kWays = {{{Way::allVisible, "all visible"},
                                                               {Way::predicted, "predicted"},
                                                               {Way::counted, "product"},
                                                               {Way::asSeen, "as seen"}}};

/// A scene with its finest picture and what is seen of each brick.
struct Subject {
    SceneBench& scene;
    Drawn truth;
    std::vector<float> seen, factors;
    double occluded = 0; // reduction by leaving out all that shows nothing or is not seen

    explicit Subject(SceneBench& s, int rays) : scene(s), truth(s.draw(s.culled())) {
        seen = seenBricks(scene.prepared(), scene.culled(), rays);
        Selection left = scene.culled();
        for (std::size_t b = 0; b < seen.size(); ++b) {
            factors.push_back(std::max(seen[b], kHiddenVisibility));
            if (left.levels[b] == 0 && (seen[b] < kUnseen || scene.weights().area[b] <= 0)) {
                left.levels[b] = kLevelCount - 1;
                --left.counts[0];
                ++left.counts[kLevelCount - 1];
            }
        }
        occluded = scene.reductionOf(left);
    }
};

/// A selection as it was drawn.
struct Choice {
    double reduction = 0;
    ImageDifference error;
    PredictedError predicted;
    Image image;
};

Choice drawn(Subject& subject, double reduction, Way way) {
    SceneBench& scene = subject.scene;
    std::vector<float> counted;
    if (way == Way::counted)
        counted = scene.seenAt(reduction);
    const Visibility visibility = way == Way::allVisible  ? Visibility()
                                  : way == Way::predicted ? Visibility(scene.visibility())
                                  : way == Way::asSeen    ? Visibility(subject.factors)
                                                          : Visibility(counted);
    const Selection selection = scene.chosenAt(reduction, visibility);
    Drawn picture = scene.draw(selection);
    return {scene.reductionOf(selection), SceneBench::difference(picture, subject.truth),
            predictError(selection, scene.predicted(), scene.weights(), visibility),
            std::move(picture.image)};
}

/// The largest reduction that is virtually lossless, by halving the interval of its logarithm.
Choice mostLossless(Subject& subject, Way way, int rounds) {
    const double culling = subject.scene.reductionOf(subject.scene.culled());
    double good = culling, bad = 30 * culling;
    Choice best{culling, {}, {}, subject.truth.image};
    for (int round = 0; round < rounds; ++round) {
        const double middle = std::sqrt(good * bad);
        Choice choice = drawn(subject, middle, way);
        if (choice.error.luvMean <= kLosslessMean && choice.error.luvP99 <= kLosslessP99) {
            good = middle;
            best = std::move(choice);
        } else {
            bad = middle;
        }
    }
    return best;
}

std::string fileName(const std::string& scene, const std::string& what) {
    std::string name = "reductions-";
    for (const char c : scene)
        if (c == ',')
            name += '-';
        else if (c != ' ')
            name += c;
    return name + "-" + what;
}

/// The pictures of one scene, at full size.
std::pair<std::string, std::vector<Panel>> pictureRow(const Workbench& bench, const BenchVolume& volume,
                                                      const std::string& preset, double lossless) {
    SceneBench scene(bench, volume, preset, "anterior");
    Subject subject(scene, bench.fewerPixels());
    const auto panel = [&](const std::string& what, Image image) {
        return Panel{fileName(volume.name + "-" + preset, what), std::move(image)};
    };
    Choice medium = drawn(subject, kShownReductions[1], Way::counted);
    Image error = colourMapped(luvDifferences(medium.image, subject.truth.image), subject.truth.image.size,
                               kErrorScale);
    std::pair<std::string, std::vector<Panel>> row{volume.name + ", " + preset, {}};
    row.second.push_back(panel("lossless", drawn(subject, lossless, Way::counted).image));
    row.second.push_back(panel("80", std::move(medium.image)));
    row.second.push_back(panel("315", drawn(subject, kShownReductions[2], Way::counted).image));
    row.second.push_back(panel("80-error", std::move(error)));
    row.second.insert(row.second.begin(), panel("finest", std::move(subject.truth.image)));
    return row;
}

} // namespace

Report reductionsReport(const Workbench& bench) {
    const std::string size = std::to_string(bench.pixels());
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
        "was searched for. *Culling* leaves out bricks that the function shows nothing of and keeps the rest "
        "at "
        "level 0; *and occlusion* leaves out those behind opaque ones and those out of view too, which is "
        "what "
        "the source calls virtually lossless. *All visible* takes every brick in the view as wholly visible; "
        "*predicted* weighs it by what the bricks' rays predict of what hides what; *product* chooses like "
        "that, counts what a small picture of those levels sees of every brick, and chooses again; *as seen* "
        "weighs by the light that passes what lies before a brick, known "
        "from the finest data. Pages are the unit: a reduction counts all texels of the pages in use, free "
        "slots and what the volume's border cuts off included. Levels are chosen for pictures of " +
        size + " x " + size +
        " pixels; every second pixel each way is measured. Cameras: *anterior* (perspective), *left* "
        "(parallel), *near* (perspective, from half the distance), *inside* (in the volume, 110 degrees)."};
    Table lossless{"reductions",
                   "Virtually lossless up to a reduction of, by what the choice knows of visibility:",
                   {"scene", "culling", "and occlusion", "all visible", "mean", "p99", "predicted", "mean",
                    "p99", "product", "mean", "p99", "as seen", "mean", "p99"},
                   {},
                   true};
    Table errors{
        "reductions-errors", "At given reductions, mean and 99th percentile:", {"scene", "levels"}, {}, true};
    for (const double reduction : kShownReductions)
        for (const char* what : {" got", " mean", " p99"})
            errors.columns.push_back(formatCell(reduction) + ":1" + what);
    Table curve{"reductions-curve",
                "Errors by reduction, product, true and predicted:",
                {"scene", "reduction", "mean", "p99", "predicted mean", "predicted p99"},
                {},
                false};
    Plot plot{"reductions-plot",
              "Mean error by reduction, camera anterior, product:",
              "data reduction",
              "mean L*u*v* error",
              true,
              true,
              {}};
    Figure figure;
    figure.columns = {"finest", "virtually lossless", "80:1", "315:1", "error at 80:1"};
    figure.caption =
        "Side by side, camera anterior, product (error: 0 dark to " + formatCell(kErrorScale) + " bright):";
    std::array<int, kWays.size()> reached{};
    int scenes = 0;
    for (const BenchVolume& volume : bench.volumes)
        for (const std::string& preset : volume.presets) {
            double losslessAnterior = 1;
            std::vector<std::string> cameras = {"anterior"};
            if (!bench.quick && preset == volume.presets.front())
                cameras.insert(cameras.end(), {"left", "near", "inside"});
            for (const std::string& camera : cameras) {
                SceneBench scene(bench, volume, preset, camera, bench.fewerPixels());
                Subject subject(scene, bench.fewerPixels());
                const int rounds = bench.quick ? 3 : 5;
                std::vector<Cell> row = {scene.name(), scene.reductionOf(scene.culled()), subject.occluded};
                for (std::size_t n = 0; n < kWays.size(); ++n) {
                    const Choice most = mostLossless(subject, kWays[n].first, rounds);
                    row.insert(row.end(), {most.reduction, most.error.luvMean, most.error.luvP99});
                    reached[n] += most.reduction >= kShownReductions[0];
                    if (kWays[n].first == Way::counted && camera == "anterior")
                        losslessAnterior = most.reduction;
                    std::vector<Cell> given = {scene.name(), kWays[n].second};
                    for (const double reduction : kShownReductions) {
                        const Choice choice = drawn(subject, reduction, kWays[n].first);
                        given.insert(given.end(),
                                     {choice.reduction, choice.error.luvMean, choice.error.luvP99});
                    }
                    errors.rows.push_back(std::move(given));
                }
                lossless.rows.push_back(std::move(row));
                ++scenes;
                bench.done(scene.name());
                if (camera != "anterior")
                    continue;
                Plot::Curve line{volume.name + ", " + preset, {}};
                for (double reduction = 4; reduction <= 512; reduction *= bench.quick ? 4 : 2) {
                    const Choice choice = drawn(subject, reduction, Way::counted);
                    curve.rows.push_back({scene.name(), choice.reduction, choice.error.luvMean,
                                          choice.error.luvP99, choice.predicted.mean, choice.predicted.p99});
                    if (choice.error.luvMean > 0)
                        line.points.emplace_back(choice.reduction, choice.error.luvMean);
                }
                plot.curves.push_back(std::move(line));
            }
            if (preset == volume.presets.front()) // one function a volume: pictures are large
                figure.rows.push_back(pictureRow(bench, volume, preset, losslessAnterior));
        }
    report.tables = {std::move(lossless), std::move(errors), std::move(curve)};
    report.figures = {std::move(figure)};
    report.plots = {std::move(plot)};
    report.after = {"Virtually lossless at 6:1 or better, of " + std::to_string(scenes) + " scenes:"};
    for (std::size_t n = 0; n < kWays.size(); ++n)
        report.after.front() +=
            std::string(n ? ", " : " ") + std::to_string(reached[n]) + " " + kWays[n].second;
    report.after.front() += ".";
    return report;
}

} // namespace tessera::bench
