// tests/bench/papers/splats.cpp: EWA volume splatting (Chen, Ren, Zwicker, Pfister 2004) beside the native
// march: error against the true integral and seconds of processors; tables 2 to 5 of the paper as ratios.
#include "core/base/error.h"
#include "render/backends/splat/splat_renderer.h"
#include "render/backends/splat/value_lists.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/picture/render_scene.h"
#include "tests/bench/papers/papers.h"
#include "tests/bench/papers/studied_scene.h"

#include <algorithm>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <sys/resource.h>

namespace tessera::bench {
namespace {

double processorSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto of = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return of(usage.ru_utime) + of(usage.ru_stime);
}

/// The least of some rounds.
double timed(int rounds, const std::function<void()>& run) {
    double least = std::numeric_limits<double>::infinity();
    for (int n = 0; n < rounds; ++n) {
        const double start = processorSeconds();
        run();
        least = std::min(least, processorSeconds() - start);
    }
    return least;
}

/// A volume, seen obliquely from so many times the fitted distance.
class SplatBench {
  public:
    SplatBench(const Workbench& bench, const BenchVolume& volume, const std::string& preset, double zoom)
        : ram_("RAM", "--ram", bench.ramBytes), gpu_("GPU memory", "--gpu-memory", std::size_t{2} << 30),
          store_(volume.store, ram_), rounds_(bench.quick ? 1 : 3) {
        scene_ = studiedScene(preset, bench.quick ? 64 : 192);
        scene_.quality.fetch = Fetch::exact;
        Camera camera = fitCamera(store_.info(), View::anterior, Projection::perspective, scene_.imageSize);
        camera.position = camera.focalPoint + zoom * glm::length(camera.position - camera.focalPoint) *
                                                  glm::normalize(glm::dvec3(0.4, -1, 0.35));
        scene_.camera = camera;
        // Where a pixel holds many voxels, the mean over its area is what it should be.
        scene_.quality.pixels.samples = zoom > 1 ? 64 : 1;
        truth_ = rendered(EngineKind::reference);
        scene_.quality.pixels.samples = 1;
    }

    struct Drawn {
        double seconds = 0;
        ImageDifference error;
        SplatReport report;
        Image image;
    };
    Drawn march(double step, int samples) {
        scene_.quality.stepVoxels = step;
        scene_.quality.pixels.samples = samples;
        const double planning = timed(rounds_, [&] { static_cast<void>(plan()); });
        Drawn drawn;
        const double all = timed(rounds_, [&] { drawn.image = rendered(EngineKind::native); });
        scene_.quality.pixels.samples = 1;
        drawn.seconds = all - planning;
        drawn.error = compare(drawn.image, truth_);
        return drawn;
    }
    Drawn splat(const SplatSettings& settings) {
        Planner p = plan();
        SplatRenderer renderer(EngineInput{}, settings);
        const FrameContext context(ram_, gpu_, 0);
        const RenderOptions options;
        RenderResult result;
        Image added;
        Drawn drawn;
        drawn.seconds = timed(rounds_, [&] { renderer.draw({scene_, p, context, options}, result, added); });
        drawn.report = renderer.report();
        drawn.image = std::move(result.image);
        drawn.error = compare(drawn.image, truth_);
        return drawn;
    }
    const Image& truth() const { return truth_; }

    /// Seconds of lighting so many places.
    double shading(double places) {
        const Planner p = plan();
        const Optics& optics = p.layer().optics;
        constexpr double kAtMost = 2e7;
        const auto count = static_cast<std::size_t>(std::min(places, kAtMost));
        glm::vec3 sum(0);
        const double seconds = timed(rounds_, [&] {
            glm::vec3 gradient(1, 2, 3), direction(0, 0.6f, 0.8f);
            for (std::size_t n = 0; n < count; ++n) {
                sum += shade(optics, glm::vec3(0.5f), gradient, direction);
                gradient = {gradient.y, gradient.z, gradient.x + 1e-3f};
            }
        });
        TESSERA_CHECK(sum.x >= 0); // it is computed
        return seconds * std::max(places / kAtMost, 1.0);
    }

    /// After an edit: samples of bricks by lists that are kept, and classified anew. Seconds of both, and of
    /// making the lists.
    struct Edited {
        double making = 0, byLists = 0, anew = 0;
        std::size_t bricks = 0;
    };
    Edited edit() {
        const Planner p = plan();
        const Selection& selection = p.layer().selection;
        const float low = p.layer().statistics.lowest, wide = p.layer().statistics.highest - low;
        const auto shows = [&](float value) { return lookUp<float>(p.layer().optics, value).a > 0; };
        std::vector<std::vector<float>> bricks;
        LatticeReader samples(*p.layer().cache, p.info(), 0, nullptr);
        std::vector<double> cube(cellCount(glm::ivec3(kBrickExtent)));
        constexpr std::size_t kMostBricks = 200;
        for (std::size_t n = 0; n < selection.levels.size() && bricks.size() < kMostBricks; ++n)
            if (selection.levels[n] == 0) {
                samples.cube<kBrickExtent>(gridPosition(n, selection.bricks) * kBrickExtent, cube.data());
                bricks.emplace_back(cube.begin(), cube.end());
            }
        Intervals shown;
        constexpr int kParts = 16;
        for (int n = 0; n < kParts * ValueLists::kIntervals; ++n)
            if (shows(low + wide * static_cast<float>(n) / (kParts * ValueLists::kIntervals)) &&
                (shown.empty() || shown.back().second <= n / kParts))
                shown.emplace_back(n / kParts, n / kParts + 1);
        Edited edited;
        edited.bricks = bricks.size();
        std::vector<ValueLists> lists;
        edited.making = timed(rounds_, [&] {
            lists.clear();
            for (const std::vector<float>& brick : bricks)
                lists.emplace_back(brick, low, low + wide);
        });
        std::vector<std::uint16_t> out;
        edited.byLists = timed(rounds_, [&] {
            out.clear();
            for (const ValueLists& list : lists)
                for (int slice = 0; slice < kBrickExtent; ++slice)
                    list.collect(2, slice, shown, out);
        });
        edited.anew = timed(rounds_, [&] {
            out.clear();
            for (const std::vector<float>& brick : bricks)
                for (std::size_t n = 0; n < brick.size(); ++n)
                    if (shows(brick[n]))
                        out.push_back(static_cast<std::uint16_t>(n));
        });
        return edited;
    }

  private:
    Planner plan() {
        return planScene(scene_, store_, TextureLimits{}, {ram_, gpu_, 0}, LevelChoice::finest);
    }
    Image rendered(EngineKind engine) {
        RenderOptions options;
        options.engine = engine;
        options.levels = LevelChoice::finest;
        return renderScene(scene_, store_, ram_, gpu_, options).image;
    }

    MemoryBudget ram_, gpu_;
    StoreReader store_;
    Scene scene_;
    Image truth_;
    int rounds_;
};

const char* nameOfFilter(SplatFilter filter) {
    switch (filter) {
    case SplatFilter::reconstruction:
        return "reconstruction";
    case SplatFilter::lowPass:
        return "low-pass";
    case SplatFilter::full:
        return "full";
    default:
        return "adaptive";
    }
}

} // namespace

Report splatsReport(const Workbench& bench) {
    Report report;
    report.name = "splats";
    report.title = "EWA volume splatting (Chen et al. 2004)";
    report.text = {"`--engine splat` draws samples as footprints, a slice of the volume after another. "
                   "Errors are against the true integral of "
                   "the interpolated field at the finest level. Seconds are of all processors together, "
                   "without planning, the least of three. "
                   "*Every* composites each splat, where *sheet* adds the optical depths of a slice first. "
                   "Kernels are Gaussians of *sigma* samples."};
    Table errors{"splats-error",
                 "Error against time, beside the native march:",
                 {"scene", "how", "CPU s", "rms", "L*u*v* mean", "p99"},
                 {},
                 true};
    Table zoomed{"splats-zoomed",
                 "The same from eight times the distance, against the mean of each pixel's area:",
                 {"scene", "how", "CPU s", "rms", "L*u*v* mean", "p99"},
                 {},
                 true};
    Table ratios{"splats-ratios",
                 "Ratios of times (the paper's tables 3, 4 and 5: 9 to 21 % gained, 7 to 24 and 9 to 13 "
                 "times on a GPU of 2004; by shading once a splat it gained 5 to 10 %):",
                 {"scene", "full to adaptive", "listing and drawing to drawing",
                  "an edit: classified anew to lists", "lists made, s", "bricks",
                  "shading at every pixel to once a splat", "pixels a splat"},
                 {},
                 true};
    Figure figure{
        "Splats beside the truth.", {"truth", "march, 1 voxel", "splats, sheet", "splats, every"}, {}};
    for (const BenchVolume& volume : bench.volumes) {
        if (volume.name != "abdomen" && volume.name != "head" && !(volume.name == "torso" && bench.quick))
            continue;
        const std::string& preset = volume.presets.front();
        const std::string name = volume.name + ", " + preset;
        const auto row = [&](Table& table, const std::string& how, const SplatBench::Drawn& d) {
            table.rows.push_back({name, how, d.seconds, d.error.rms, d.error.luvMean, d.error.luvP99});
        };
        SplatBench near(bench, volume, preset, 1);
        for (const double step : {0.5, 1.0, 2.0, 4.0, 8.0})
            row(errors, "march, " + formatCell(step) + " voxels", near.march(step, 1));
        for (const double sigma : {0.5, 0.6, 0.7, 0.8})
            for (const auto composition : {SplatComposition::sheet, SplatComposition::every}) {
                SplatSettings settings;
                settings.sigma = sigma;
                settings.composition = composition;
                row(errors,
                    "splats, sigma " + formatCell(sigma) +
                        (composition == SplatComposition::sheet ? ", sheet" : ", every"),
                    near.splat(settings));
            }
        std::vector<double> seconds;
        for (const SplatFilter filter :
             {SplatFilter::full, SplatFilter::adaptive, SplatFilter::reconstruction, SplatFilter::lowPass}) {
            SplatSettings settings;
            settings.filter = filter;
            const SplatBench::Drawn drawn = near.splat(settings);
            seconds.push_back(drawn.report.secondsDrawing);
            row(errors, std::string("splats, filter ") + nameOfFilter(filter), drawn);
        }
        const SplatBench::Drawn plain = near.splat({});
        const SplatBench::Edited edited = near.edit();
        const auto splats = static_cast<double>(plain.report.counts.drawn);
        const double pixels = plain.report.counts.pixels * std::numbers::pi / 4; // boxes hold ellipses
        const double shadedByPixel = 1 + (near.shading(pixels) - near.shading(splats)) / plain.seconds;
        ratios.rows.push_back(
            {name, seconds[0] / seconds[1],
             (plain.report.secondsListing + plain.report.secondsDrawing) / plain.report.secondsDrawing,
             edited.anew / std::max(edited.byLists, 1e-6), edited.making, static_cast<double>(edited.bricks),
             shadedByPixel, pixels / splats});
        SplatSettings every;
        every.composition = SplatComposition::every;
        figure.rows.push_back({name,
                               {Panel{"splats-" + volume.name + "-truth", near.truth()},
                                Panel{"splats-" + volume.name + "-march", near.march(1, 1).image},
                                Panel{"splats-" + volume.name + "-sheet", plain.image},
                                Panel{"splats-" + volume.name + "-every", near.splat(every).image}}});
        SplatBench far(bench, volume, preset, 8);
        for (const auto& [step, samples] :
             {std::pair(1.0, 1), std::pair(1.0, 16), std::pair(4.0, 16), std::pair(8.0, 16)})
            row(zoomed, "march, " + formatCell(step) + " voxels, " + std::to_string(samples) + " samples",
                far.march(step, samples));
        for (const SplatFilter filter : {SplatFilter::adaptive, SplatFilter::full}) {
            SplatSettings settings;
            settings.filter = filter;
            row(zoomed, std::string("splats, filter ") + nameOfFilter(filter), far.splat(settings));
        }
        bench.done(name);
    }
    report.tables = {std::move(errors), std::move(zoomed), std::move(ratios)};
    report.figures = {std::move(figure)};
    return report;
}

} // namespace tessera::bench
