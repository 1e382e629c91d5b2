// tests/bench/splat_bench.cpp: splats beside the native march, by error against the true integral and seconds
// of processors: deviations of kernels, both compositions, filters, samples by value. Levels are the finest.
//
//   splat_bench --store thorax.zarr --function ct-bone --size 256 --zoom 1 --threads 2 --lit 1 --pictures out
#include "core/image/image_file.h"
#include "core/image/image_metrics.h"
#include "render/backends/splat/splat_renderer.h"
#include "render/backends/splat/value_lists.h"
#include "render/contract/lattice.h"
#include "render/picture/render_scene.h"
#include "tests/bench/bench_tools.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <sys/resource.h>
#include <vector>

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

struct Study {
    Budgets& budgets;
    const StoreReader store;
    Scene scene;
    int threads, rounds;
    std::string pictures;
    std::optional<Image> truth;

    Image rendered(EngineKind engine) const {
        RenderOptions o;
        o.engine = engine;
        o.threads = threads;
        o.levels = LevelChoice::finest;
        return renderScene(scene, store, budgets.ram, budgets.gpu, o).image;
    }
    Planner plan() {
        return planScene(scene, store, TextureLimits{}, {budgets.ram, budgets.gpu, threads},
                         LevelChoice::finest);
    }
    void tell(const std::string& name, double seconds, const Image& image, const std::string& more) {
        const ImageError e = measureError(image, *truth);
        std::printf("%-34s %8.3f s  rms %.5f  luv p99 %6.2f  ssim %.4f  bias %+.4f  %s\n", name.c_str(),
                    seconds, e.rmse, e.luvP99, e.ssim, e.bias, more.c_str());
        std::fflush(stdout);
        if (!pictures.empty())
            writeImage(pictures + "/" + name + ".png", overBackground(image, glm::vec3(0)), "{}");
    }
    /// The least of some rounds, without what the plan takes.
    double timed(const std::function<void()>& draw) const {
        double least = 1e30;
        for (int n = 0; n < rounds; ++n) {
            const double start = processorSeconds();
            draw();
            least = std::min(least, processorSeconds() - start);
        }
        return least;
    }
    void march(double step, int samples) {
        scene.quality.stepVoxels = step;
        scene.quality.pixels.samples = samples;
        const double planning = timed([&] { static_cast<void>(plan()); });
        Image image;
        const double all = timed([&] { image = rendered(EngineKind::native); });
        scene.quality.pixels.samples = 1;
        tell("march-" + std::to_string(step).substr(0, 5) + "-" + std::to_string(samples), all - planning,
             image, "");
    }
    void splat(const std::string& name, const SplatSettings& settings) {
        Planner p = plan();
        EngineInput input;
        input.threads = threads;
        SplatRenderer renderer(input, settings);
        const FrameContext context(budgets.ram, budgets.gpu, threads);
        const RenderOptions o;
        RenderResult result;
        Image added;
        const double seconds = timed([&] { renderer.draw({scene, p, context, o}, result, added); });
        const SplatReport& r = renderer.report();
        char more[160];
        std::snprintf(more, sizeof more,
                      "%zu splats (%zu, %zu, %zu by filter), listing %.3f s, drawing %.3f s", r.counts.drawn,
                      r.counts.byFilter[0], r.counts.byFilter[1], r.counts.byFilter[2], r.secondsListing,
                      r.secondsDrawing);
        tell(name, seconds, result.image, more);
    }
    /// A function that changes: samples of bricks by their intervals, and classified anew.
    void lists() {
        const Planner p = plan();
        const Selection& selection = p.layer().selection;
        const float low = p.layer().statistics.lowest, wide = p.layer().statistics.highest - low;
        const auto shows = [&](float value) { return lookUp<float>(p.layer().optics, value).a > 0; };
        std::vector<std::vector<float>> bricks;
        LatticeReader samples(*p.layer().cache, p.info(), 0, nullptr);
        std::vector<double> cube(32 * 32 * 32);
        for (std::size_t n = 0; n < selection.levels.size() && bricks.size() < 200; ++n)
            if (selection.levels[n] == 0) {
                samples.cube<32>(gridPosition(n, selection.bricks) * 32, cube.data());
                bricks.emplace_back(cube.begin(), cube.end());
            }
        Intervals shown;
        for (int n = 0; n < 16 * ValueLists::kIntervals; ++n)
            if (shows(low + wide * static_cast<float>(n) / (16 * ValueLists::kIntervals)) &&
                (shown.empty() || shown.back().second <= n / 16))
                shown.emplace_back(n / 16, n / 16 + 1);
        std::vector<ValueLists> lists;
        const double making = timed([&] {
            lists.clear();
            for (const std::vector<float>& brick : bricks)
                lists.emplace_back(brick, low, low + wide);
        });
        std::vector<std::uint16_t> out;
        const double byLists = timed([&] {
            out.clear();
            for (const ValueLists& list : lists)
                for (int slice = 0; slice < 32; ++slice)
                    list.collect(2, slice, shown, out);
        });
        const std::size_t collected = out.size();
        const double anew = timed([&] {
            out.clear();
            for (const std::vector<float>& brick : bricks)
                for (std::size_t n = 0; n < brick.size(); ++n)
                    if (shows(brick[n]))
                        out.push_back(static_cast<std::uint16_t>(n));
        });
        std::printf(
            "lists of %zu bricks: made in %.3f s; an edit: %.5f s by intervals (%zu), %.5f s anew (%zu)\n",
            lists.size(), making, byLists, collected, anew, out.size());
    }
};

void run(int argc, char** argv) {
    auto o = parseOptions(argc, argv,
                          {{"--store", ""},
                           {"--function", "ct-bone"},
                           {"--size", "256"},
                           {"--zoom", "1"},
                           {"--threads", "1"},
                           {"--lit", "1"},
                           {"--rounds", "3"},
                           {"--pictures", ""}});
    Budgets budgets;
    Study s{budgets,
            StoreReader(o["--store"], budgets.ram),
            {},
            std::stoi(o["--threads"]),
            std::stoi(o["--rounds"]),
            o["--pictures"],
            {}};
    const double zoom = std::stod(o["--zoom"]);
    s.scene.volumes = {SceneVolume()};
    s.scene.volumes[0].transferFunction = o["--function"];
    s.scene.imageSize = glm::ivec2(std::stoi(o["--size"]));
    s.scene.shading.on = o["--lit"] == "1";
    s.scene.quality.fetch = Fetch::exact;
    Camera camera = fitCamera(s.store.info(), View::anterior, Projection::perspective, s.scene.imageSize);
    camera.position = camera.focalPoint + zoom * glm::length(camera.position - camera.focalPoint) *
                                              glm::normalize(glm::dvec3(0.4, -1, 0.35));
    s.scene.camera = camera;
    // Where a pixel holds many voxels, the mean over its area is what it should be.
    s.scene.quality.pixels.samples = zoom > 1 ? 64 : 1;
    s.truth = s.rendered(EngineKind::reference);
    s.scene.quality.pixels.samples = 1;
    if (!s.pictures.empty())
        writeImage(s.pictures + "/truth.png", overBackground(*s.truth, glm::vec3(0)), "{}");
    for (const double step : {0.5, 1.0, 2.0, 4.0, 8.0})
        s.march(step, 1);
    if (zoom > 1)
        for (const double step : {1.0, 4.0, 8.0})
            s.march(step, 16);
    for (const double sigma : {0.5, 0.6, 0.7, 0.8})
        for (const bool every : {false, true})
            s.splat("splat-" + std::to_string(sigma).substr(0, 3) + (every ? "-every" : "-sheet"),
                    {sigma, 0.5, 3, SplatFilter::adaptive,
                     every ? SplatComposition::every : SplatComposition::sheet});
    for (const auto& [filter, name] : {std::pair(SplatFilter::full, "full"),
                                       {SplatFilter::reconstruction, "reconstruction"},
                                       {SplatFilter::lowPass, "low-pass"}})
        s.splat(std::string("splat-0.6-") + name, {0.6, 0.5, 3, filter, SplatComposition::sheet});
    s.lists();
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("splat_bench", tessera::bench::run, argc, argv);
}
