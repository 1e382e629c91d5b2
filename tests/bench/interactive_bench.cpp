// tests/bench/interactive_bench.cpp: successive pictures: a camera goes around a volume in steps. For every
// step the CSV has the time to the first picture of the new view, the time to the last, and how far a single
// call of advance() exceeded its deadline. Runs are with and without the path known in advance.
//
//   interactive_bench --store t512.zarr --preset bone --size 512 --steps 12 --gpu-memory 64MiB --ram 512MiB
//                     --deadline-ms 16 --device auto
//
// With --edit PRESET the camera stays, and an edit of the transfer function is timed, as a window makes it.
// Times are to a first picture of few pixels, to one of all pixels, to one with all bricks at their levels,
// and to the last, whose light is complete too. Each has the program's CPU time until then. --light gives the
// scene a lighting preset, --relight another one that follows the edits; --engine native draws on the CPU.
#include "core/scene/preset.h"
#include "core/scene/scene_presets.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/native/native_engine.h"
#include "render/interactive/interactive_renderer.h"
#include "tests/bench/bench_tools.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <glm/ext/matrix_transform.hpp>
#include <glm/mat4x4.hpp>
#include <memory>

namespace tessera::bench {
namespace {

/// Cameras around the volume's vertical axis, a few degrees apart.
std::vector<Camera> orbit(const Camera& first, int steps, double degrees) {
    std::vector<Camera> cameras;
    for (int n = 0; n < steps; ++n) {
        const glm::dmat4 turn = glm::rotate(glm::dmat4(1), glm::radians(n * degrees), glm::dvec3(0, 0, 1));
        Camera camera = first;
        camera.position =
            first.focalPoint + glm::dvec3(turn * glm::dvec4(first.position - first.focalPoint, 0));
        cameras.push_back(camera);
    }
    return cameras;
}

struct Step {
    double firstMs = 0, lastMs = 0, lateMs = 0; // lateMs: most that a call went beyond its deadline
    int pictures = 0;
    std::uint64_t bricks = 0, bytes = 0, misses = 0;
};

/// Of an edit: when a picture was there, and what it took.
struct Moment {
    double ms = 0, cpuS = 0;
};
struct Edit {
    Moment fewPixels, allPixels, levels, whole;
    double lateMs = 0;
    int pictures = 0;
};

Edit measureEdit(InteractiveRenderer& renderer, const glm::ivec2& size, double deadlineMs) {
    Edit edit;
    const auto start = Clock::now();
    const std::clock_t before = std::clock();
    const auto moment = [&] {
        return Moment{msSince(start), static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC};
    };
    renderer.setHaste(InteractiveRenderer::Haste{glm::max(size / 2, glm::ivec2(1)), 1});
    for (bool converged = false; !converged;) {
        const auto call = Clock::now();
        const auto progress =
            renderer.advance(call + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double, std::milli>(deadlineMs)));
        edit.lateMs = std::max(edit.lateMs, msSince(call) - deadlineMs);
        converged = progress.converged && edit.pictures > 0;
        if (!progress.newPicture)
            continue;
        edit.whole = moment();
        if (++edit.pictures == 1) {
            edit.fewPixels = edit.whole;
            renderer.setHaste(std::nullopt);
            converged = false;
            continue;
        }
        if (edit.pictures == 2)
            edit.allPixels = edit.whole;
        if (edit.levels.ms == 0 && progress.movesLeft == 0 && !progress.choosing)
            edit.levels = edit.whole;
    }
    return edit;
}

Step measure(InteractiveRenderer& renderer, double deadlineMs) {
    Step step;
    const auto start = Clock::now();
    const Work before = renderer.work();
    const auto misses = renderer.cacheCounters().misses;
    for (bool converged = false; !converged;) {
        const auto call = Clock::now();
        const auto progress =
            renderer.advance(call + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double, std::milli>(deadlineMs)));
        step.lateMs = std::max(step.lateMs, msSince(call) - deadlineMs);
        if (progress.newPicture && ++step.pictures == 1)
            step.firstMs = msSince(start);
        if (progress.newPicture)
            step.lastMs = msSince(start);
        converged = progress.converged;
    }
    step.bricks = renderer.work().bricksUploaded - before.bricksUploaded;
    step.bytes = renderer.work().bytesUploaded - before.bytesUploaded;
    step.misses = renderer.cacheCounters().misses - misses;
    return step;
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--preset", "bone-1"},
                                 {"--size", "512"},
                                 {"--steps", "12"},
                                 {"--degrees", "10"},
                                 {"--deadline-ms", "16"},
                                 {"--device", "software"},
                                 {"--engine", "gpu"},
                                 {"--light", "plain"},
                                 {"--edit", ""},
                                 {"--relight", ""},
                                 {"--ram", "512MiB"},
                                 {"--gpu-memory", "256MiB"}});
    const auto number = [&](const std::string& name) { return parseNumbers(options[name], name).at(0); };
    const int size = static_cast<int>(number("--size")), steps = static_cast<int>(number("--steps"));
    const double deadlineMs = number("--deadline-ms"), degrees = number("--degrees");
    MemoryBudget ram("RAM", "--ram", parseBytes(options["--ram"], "--ram"));
    const GlContext context(GlDeviceChoice{options["--device"]});
    const std::string path = options["--store"];
    const StoreReader store(path, ram);
    Scene scene;
    scene.volumes = {{path, options["--preset"]}};
    scene.imageSize = glm::ivec2(size);
    scene.camera = fitCamera(store.info(), View::anterior, Projection::perspective, scene.imageSize);
    applyLook(options["--light"], scene);
    const bool onProcessor = options["--engine"] == "native";
    const auto engineFor = [&](MemoryBudget& gpu) -> std::unique_ptr<Engine> {
        if (onProcessor)
            return std::make_unique<NativeEngine>(0, gpu, ram);
        return std::make_unique<GpuEngine>(context, gpu, ram);
    };
    if (!options["--edit"].empty()) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", parseBytes(options["--gpu-memory"], "--gpu-memory"));
        const std::unique_ptr<Engine> engine = engineFor(gpu);
        InteractiveOptions choices;
        choices.dispatchMs = deadlineMs / 2;
        InteractiveRenderer renderer(scene, store, *engine, ram, gpu, choices);
        std::printf("edit,few pixels ms,CPU s,all pixels ms,CPU s,levels ms,CPU s,whole ms,CPU s,late "
                    "ms,pictures\n");
        const auto tell = [&](const std::string& name) {
            const Edit e = measureEdit(renderer, scene.imageSize, deadlineMs);
            std::printf("%s,%.0f,%.2f,%.0f,%.2f,%.0f,%.2f,%.0f,%.2f,%.0f,%d\n", name.c_str(), e.fewPixels.ms,
                        e.fewPixels.cpuS, e.allPixels.ms, e.allPixels.cpuS, e.levels.ms, e.levels.cpuS,
                        e.whole.ms, e.whole.cpuS, e.lateMs, e.pictures);
            std::fflush(stdout);
        };
        for (int n = 0; n < steps; ++n) { // there and back
            const std::string& name = n % 2 != 0 ? options["--edit"] : options["--preset"];
            renderer.setFunction(presetFunction(name, {-1024, 3071, true, 1, {}}));
            tell(name);
        }
        if (!options["--relight"].empty()) {
            applyLook(options["--relight"], scene);
            if (!renderer.setLight(scene.lighting, scene.shading))
                throw InputError("--relight: this look needs other planes of light");
            tell(options["--relight"]);
        }
        return;
    }
    const std::vector<Camera> cameras = orbit(std::get<Camera>(scene.camera), steps, degrees);
    std::printf("path told,step,first ms,last ms,late ms,pictures,bricks,MiB,chunks decoded,pages,repacks\n");
    for (const bool told : {false, true}) {
        MemoryBudget gpu("GPU memory", "--gpu-memory", parseBytes(options["--gpu-memory"], "--gpu-memory"));
        InteractiveOptions choices;
        choices.dispatchMs = deadlineMs / 2;
        const std::unique_ptr<Engine> engine = engineFor(gpu);
        InteractiveRenderer renderer(scene, store, *engine, ram, gpu, choices);
        for (int n = 0; n < steps; ++n) {
            renderer.setCamera(cameras[static_cast<std::size_t>(n)]);
            if (told && n + 1 < steps)
                renderer.setPath({cameras[static_cast<std::size_t>(n) + 1]});
            const Step s = measure(renderer, deadlineMs);
            std::printf("%s,%d,%.1f,%.1f,%.1f,%d,%llu,%.2f,%llu,%zu,%zu\n", told ? "yes" : "no", n, s.firstMs,
                        s.lastMs, s.lateMs, s.pictures, static_cast<unsigned long long>(s.bricks),
                        static_cast<double>(s.bytes) / (1 << 20), static_cast<unsigned long long>(s.misses),
                        pagesFor(renderer.resident().counts), renderer.repacks());
            std::fflush(stdout);
        }
    }
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("interactive_bench", tessera::bench::run, argc, argv);
}
