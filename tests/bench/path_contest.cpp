// tests/bench/path_contest.cpp: CPU seconds to equal noise: the product's paths beside delta tracking with
// one majorant (as many scatterings) and beside jittered marching (one scattering), in turns
// (docs/measurements/paths.md).
//
//   path_contest --scenes ct.zarr:bone,ct.zarr:soft-tissue --size 128 --samples 64 --others 4 --threads 2
//
// Noise is the root of half of the mean square difference of two seeds' colours. Variance falls as 1 over the
// samples, so variance times seconds compares ways of any number of samples. The product's seconds are whole
// pictures, with levels, bounds and bricks; those of the others are the tracing alone.
#include "core/scene/scene_presets.h"
#include "render/picture/render_scene.h"
#include "tests/bench/path_baselines.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <sstream>
#include <string>

namespace tessera::bench {
namespace {

/// Of one way to draw a scene.
struct Turns {
    std::vector<Image> images; // a seed each
    std::vector<double> seconds;
    PathWork work;

    template <typename Draw> void take(Draw&& draw) {
        const double before = cpuSeconds();
        images.push_back(draw());
        seconds.push_back(cpuSeconds() - before);
    }
    double variance() const {
        double sum = 0;
        for (std::size_t n = 0; n < images[0].pixels.size(); ++n)
            for (int i = 0; i < 3; ++i)
                sum += std::pow(double{images[0].pixels[n][i]} - double{images[1].pixels[n][i]}, 2);
        return sum / (6 * static_cast<double>(images[0].pixels.size()));
    }
    double mean() const {
        double sum = 0;
        for (const Image& image : images)
            for (const glm::vec4& pixel : image.pixels)
                sum += double{pixel.r} + double{pixel.g} + double{pixel.b};
        return sum / (3 * static_cast<double>(images.size() * images[0].pixels.size()));
    }
    double cost() const { return variance() * minimum(seconds); }
};

struct Sizes {
    int size, samples, others, threads;
    double stepVoxels, eyeStep;
};

/// One scene's times: of the product's over another's cost, with the same number of scatterings.
struct Gains {
    double oneMajorant, marching;
};

Gains contest(const std::string& path, const std::string& preset, const Sizes& sizes) {
    Budgets budgets;
    const StoreReader store(path, budgets.ram);
    Scene scene;
    SceneVolume volume;
    volume.transferFunction = preset;
    scene.volumes = {volume};
    scene.imageSize = glm::ivec2(sizes.size);
    scene.camera = fitCamera(store.info(), View::anterior, Projection::perspective, scene.imageSize);
    applyLook("cinematic", scene);
    Scene direct = scene;
    direct.lighting.transport->bounces = 1;
    const auto product = [&](Scene drawn, int seed, PathWork& work) {
        if (sizes.eyeStep > 0)
            drawn.quality.stepVoxels = sizes.eyeStep;
        drawn.quality.pixels.samples = sizes.samples;
        drawn.quality.pixels.seed = static_cast<std::uint32_t>(seed);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = sizes.threads;
        RenderResult result = renderScene(drawn, store, budgets.ram, budgets.gpu, options);
        work += result.work.paths;
        return std::move(result.image);
    };
    Turns many, one, majorant, marching;
    {
        // In turns; the others' plan and bricks are there before their time is taken.
        for (int seed = 1; seed <= 2; ++seed) {
            const auto number = static_cast<std::uint32_t>(seed);
            many.take([&] { return product(scene, seed, many.work); });
            {
                const PathBaseline other(scene, store, budgets, sizes.threads);
                majorant.take([&] {
                    return other.draw(Tracking::oneMajorant, sizes.others, number, sizes.stepVoxels,
                                      majorant.work);
                });
            }
            one.take([&] { return product(direct, seed, one.work); });
            const PathBaseline other(direct, store, budgets, sizes.threads);
            marching.take([&] {
                return other.draw(Tracking::marching, sizes.others, number, sizes.stepVoxels, marching.work);
            });
        }
    }
    const std::string name = path.substr(path.find_last_of('/') + 1) + ", " + preset;
    const auto row = [&](const char* way, const Turns& turns, int samples, double gain, double meanRatio) {
        std::printf("| %s | %s | %d | %.2f | %.1f | %.4f | %.5f | %.3f | %.1f |\n", name.c_str(), way,
                    samples, minimum(turns.seconds),
                    static_cast<double>(turns.work.lookUps) /
                        static_cast<double>(std::max<std::uint64_t>(turns.work.paths, 1)),
                    std::sqrt(turns.variance()), turns.cost(), meanRatio, gain);
    };
    const Gains gains{majorant.cost() / many.cost(), marching.cost() / one.cost()};
    row("paths", many, sizes.samples, 1, 1);
    row("one majorant", majorant, sizes.others, gains.oneMajorant, majorant.mean() / many.mean());
    row("paths, one scattering", one, sizes.samples, 1, 1);
    row("marching", marching, sizes.others, gains.marching, marching.mean() / one.mean());
    std::fflush(stdout);
    return gains;
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--scenes", ""}, // STORE:PRESET,...
                                 {"--size", "128"},
                                 {"--samples", "64"},
                                 {"--others", "4"},   // samples of the others
                                 {"--step", "1"},     // of marching, voxels
                                 {"--eye-step", "0"}, // voxels, of the product's rays of the eye; 0: its own
                                 {"--threads", "2"}});
    const Sizes sizes{std::stoi(options["--size"]),   std::stoi(options["--samples"]),
                      std::stoi(options["--others"]), std::stoi(options["--threads"]),
                      std::stod(options["--step"]),   std::stod(options["--eye-step"])};
    std::printf("%dx%d, %d threads, load %.1f\n\n| scene | way | samples | CPU s | look-ups a path | rms | "
                "rms² s | mean | time to equal noise |\n|---|---|---|---|---|---|---|---|---|\n",
                sizes.size, sizes.size, sizes.threads, loadAverage());
    std::fflush(stdout);
    double logs[2] = {0, 0};
    int count = 0;
    std::istringstream scenes(options["--scenes"]);
    for (std::string scene; std::getline(scenes, scene, ','); ++count) {
        const std::size_t colon = scene.rfind(':');
        if (colon == std::string::npos)
            throw InputError("--scenes: expected STORE:PRESET,..., found '" + scene + "'");
        const Gains gains = contest(scene.substr(0, colon), scene.substr(colon + 1), sizes);
        logs[0] += std::log(gains.oneMajorant);
        logs[1] += std::log(gains.marching);
    }
    if (count == 0)
        throw InputError("--scenes: expected STORE:PRESET,..., found nothing");
    std::printf(
        "\nGeometric means of %d scenes: one majorant %.1f, marching %.1f times as long. Load %.1f.\n", count,
        std::exp(logs[0] / count), std::exp(logs[1] / count), loadAverage());
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("path_contest", tessera::bench::run, argc, argv);
}
