// tests/bench/path_bench.cpp: paths of light: error against run time, the error that pictures tell beside the
// one that they make, and how wrong light of voxels and maps of shadows are (docs/measurements/paths.md).
//
//   path_bench --store ct.zarr --preset bone --size 256 --samples 4,16,64,256 --light 1
//
//   path_bench --store huge.zarr --gpu-memory 256MiB --ram 512MiB --samples 0 --levels 16
//   path_bench --store head.zarr --scene skin-over-bone.json --samples 0 --previews 16
//
// The made error needs no truth: pictures of two seeds are independent, so half of the mean square of their
// difference is the variance of one. The error of kept light needs none either. Its picture less one by
// response "contract", through the same places, has the light's error and noise. Over two seeds the noise
// is independent, so the mean product of the two differences is the mean square of the error alone.
#include "core/scene/scene_presets.h"
#include "render/picture/render_scene.h"
#include "tests/bench/bench_tools.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <utility>

namespace tessera::bench {
namespace {

struct Bench {
    const StoreReader& store;
    Budgets& budgets;
    int threads;

    RenderResult draw(Scene scene, int samples, int seed) const {
        scene.quality.pixels.samples = samples;
        scene.quality.pixels.seed = static_cast<std::uint32_t>(seed);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.threads = threads;
        return renderScene(scene, store, budgets.ram, budgets.gpu, options);
    }
};

double meanProduct(const Image& a, const Image& b, const Image& c, const Image& d) {
    double sum = 0;
    std::size_t shown = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n) {
        if (!(a.pixels[n].a > 0))
            continue;
        ++shown;
        for (int i = 0; i < 4; ++i)
            sum += static_cast<double>(a.pixels[n][i] - b.pixels[n][i]) *
                   static_cast<double>(c.pixels[n][i] - d.pixels[n][i]) / 4;
    }
    return shown > 0 ? sum / static_cast<double>(shown) : 0;
}
/// In the mean over colours of pixels that show something.
double meanDifference(const Image& a, const Image& b) {
    double sum = 0;
    std::size_t shown = 0;
    for (std::size_t n = 0; n < a.pixels.size(); ++n)
        if (a.pixels[n].a > 0) {
            ++shown;
            for (int i = 0; i < 3; ++i)
                sum += static_cast<double>(a.pixels[n][i] - b.pixels[n][i]) / 3;
        }
    return shown > 0 ? sum / static_cast<double>(shown) : 0;
}
double meanLight(const Image& image) {
    return meanDifference(image, Image(image.size));
}
double rootOf(double square) {
    return std::copysign(std::sqrt(std::abs(square)), square);
}

void errorAgainstTime(const Bench& bench, Scene scene, const std::vector<double>& numbers) {
    applyLook("cinematic", scene);
    std::printf(
        "| samples | s | paths a ms | look-ups a path | null collisions | told rms | made rms | made / "
        "told |\n|---|---|---|---|---|---|---|---|\n");
    for (const double number : numbers) {
        const int samples = static_cast<int>(number);
        std::vector<Image> images;
        double seconds = 1e30, told = 0;
        PathWork work;
        for (int seed = 1; seed <= 2; ++seed) {
            const auto start = Clock::now();
            RenderResult result = bench.draw(scene, samples, seed);
            seconds = std::min(seconds, 1e-3 * msSince(start));
            told += std::pow(result.pixels.error ? result.pixels.error->rms : 0, 2) / 2;
            work = result.work.paths;
            images.push_back(std::move(result.image));
        }
        const double made = std::sqrt(meanProduct(images[0], images[1], images[0], images[1]) / 2);
        const auto paths = static_cast<double>(work.paths);
        std::printf("| %d | %.2f | %.0f | %.1f | %.1f | %.4f | %.4f | %.2f |\n", samples, seconds,
                    1e-3 * paths / seconds, static_cast<double>(work.lookUps) / paths,
                    static_cast<double>(work.nullCollisions) / paths, std::sqrt(told), made,
                    made / std::sqrt(told));
    }
}

/// @param level  of the light
void errorOfKeptLight(const Bench& bench, const Scene& given, int level, int samples) {
    for (const bool occludes : {false, true})
        for (const bool casts : {false, true}) {
            Scene kept = given;
            kept.quality.integrator = Integrator::midpoint;
            kept.lighting.finestLevel = level;
            Light light;
            light.kind = LightKind::directional;
            light.direction = {-0.6, 0.8, 1};
            light.shadow = casts;
            kept.lighting.lights = {light};
            if (occludes) {
                kept.lighting.occlusion = Occlusion{};
                kept.lighting.occlusion->gamma = 1;
            }
            Scene contract = kept;
            contract.lighting.transport = Transport{TransportResponse::contract};
            std::vector<Image> of, truth;
            double keptSeconds = 0, truthSeconds = 0;
            for (int seed = 1; seed <= 2; ++seed) {
                auto start = Clock::now();
                of.push_back(bench.draw(kept, samples, seed).image);
                keptSeconds = 1e-3 * msSince(start);
                start = Clock::now();
                truth.push_back(bench.draw(contract, samples, seed).image);
                truthSeconds = 1e-3 * msSince(start);
            }
            std::printf("| %s | %d | %.4f | %+.4f | %.1f | %.1f |\n",
                        occludes ? casts ? "both" : "occlusion" : (casts ? "a shadow" : "no light of voxels"),
                        level, rootOf(meanProduct(of[0], truth[0], of[1], truth[1])),
                        (meanDifference(of[0], truth[0]) + meanDifference(of[1], truth[1])) / 2, keptSeconds,
                        truthSeconds);
        }
}

/// The error of the levels that small budgets leave, apart from noise. Pictures of one seed by these and by
/// large budgets differ by levels' error and noise. Over two seeds noise is independent.
void errorOfLevels(const Bench& small, Scene scene, int samples) {
    applyLook("cinematic", scene);
    Budgets large(std::size_t{4} << 30, std::size_t{4} << 30);
    const Bench finer{small.store, large, small.threads};
    std::vector<Image> images[2]; // of small budgets and of large ones
    std::string levels[2];
    for (int seed = 1; seed <= 2; ++seed)
        for (const bool isLarge : {false, true}) {
            RenderResult result = (isLarge ? finer : small).draw(scene, samples, seed);
            images[isLarge].push_back(std::move(result.image));
            levels[isLarge].clear();
            for (const std::size_t bricks : result.bricksOfLevel)
                levels[isLarge] += " " + std::to_string(bricks);
        }
    const std::vector<Image>&a = images[0], &b = images[1];
    std::printf(
        "\n| samples | bricks of levels 0, 1, ... and empty | by 4 GiB | rms of levels | in the mean | rms "
        "of noise |\n|---|---|---|---|---|---|\n| %d |%s |%s | %.5f | %+.5f | %.5f |\n",
        samples, levels[0].c_str(), levels[1].c_str(), rootOf(meanProduct(a[0], b[0], a[1], b[1])),
        (meanDifference(a[0], b[0]) + meanDifference(a[1], b[1])) / 2,
        rootOf(meanProduct(a[0], a[1], a[0], a[1]) / 2));
}

/// Of previews, apart from noise, against paths with four times the samples: seeds are others, so the noise
/// of all pictures is independent.
void errorOfPreviews(const Bench& bench, Scene scene, int samples) {
    std::printf("\n| preview | CPU s | rms of bias | in the mean | rms of noise |\n|---|---|---|---|---|\n");
    const Image truth[2] = {bench.draw(scene, 4 * samples, 3).image, bench.draw(scene, 4 * samples, 4).image};
    const double light = (meanLight(truth[0]) + meanLight(truth[1])) / 2;
    for (const auto& [preview, name] : {std::pair{PathPreview::none, "none"},
                                        {PathPreview::few, "few"},
                                        {PathPreview::squared, "squared"}}) {
        scene.lighting.transport->preview = preview;
        const std::clock_t before = std::clock();
        const Image of[2] = {bench.draw(scene, samples, 1).image, bench.draw(scene, samples, 2).image};
        const double seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / 2;
        std::printf("| %s | %.2f | %.4f | %+.1f %% | %.4f |\n", name, seconds,
                    rootOf(meanProduct(of[0], truth[0], of[1], truth[1])),
                    100 * (meanDifference(of[0], truth[0]) + meanDifference(of[1], truth[1])) / 2 / light,
                    rootOf(meanProduct(of[0], of[1], of[0], of[1]) / 2));
    }
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--scene", ""}, // of previews; "": the preset by the look cinematic
                                 {"--preset", "bone"},
                                 {"--size", "256"},
                                 {"--samples", "4,16,64"}, // 0: no first table
                                 {"--light", "0"},         // samples of the second table; 0: none
                                 {"--levels", "0"},        // samples of the third; 0: none
                                 {"--previews", "0"},      // samples of the fourth; 0: none
                                 {"--zoom", "1"},          // into the middle
                                 {"--gpu-memory", "4GiB"},
                                 {"--ram", "2GiB"},
                                 {"--threads", "0"}});
    Budgets budgets(parseBytes(options["--gpu-memory"], "--gpu-memory"),
                    parseBytes(options["--ram"], "--ram"));
    const StoreReader store(options["--store"], budgets.ram);
    const Bench bench{store, budgets, std::stoi(options["--threads"])};
    Scene scene;
    SceneVolume volume;
    volume.transferFunction = options["--preset"];
    scene.volumes = {volume};
    scene.imageSize = glm::ivec2(std::stoi(options["--size"]));
    Camera camera = fitCamera(bench.store.info(), View::anterior, Projection::perspective, scene.imageSize);
    camera.viewAngle /= std::stod(options["--zoom"]);
    scene.camera = camera;
    std::printf("%s, %s, %dx%d, load %.1f\n\n", options["--store"].c_str(), options["--preset"].c_str(),
                scene.imageSize.x, scene.imageSize.y, loadAverage());
    if (options["--samples"] != "0")
        errorAgainstTime(bench, scene, parseNumbers(options["--samples"], "--samples"));
    if (const int samples = std::stoi(options["--levels"]); samples > 0)
        errorOfLevels(bench, scene, samples);
    if (const int samples = std::stoi(options["--previews"]); samples > 0) {
        Scene paths = scene;
        applyLook("cinematic", paths);
        if (const std::string file = options["--scene"]; !file.empty()) {
            paths = loadScene(file);
            paths.imageSize = scene.imageSize;
        }
        errorOfPreviews(bench, paths, samples);
    }
    if (const int samples = std::stoi(options["--light"]); samples > 0) {
        std::printf(
            "\n| light | finestLevel | rms of light | mean | s | s by paths |\n|---|---|---|---|---|---|\n");
        for (const int level : {0, 1})
            errorOfKeptLight(bench, scene, level, samples);
    }
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("path_bench", tessera::bench::run, argc, argv);
}
