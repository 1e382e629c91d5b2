// tests/bench/frame_bench.cpp: time of whole frames of committed scenes by resolution and fetch mode, with
// the work behind each, as CSV. Runs on a bare GPU machine: it needs neither importers, nor image files, nor
// the viewer. The volume is a store, which is generated if it is absent.
//
//   frame_bench --store build/bench-data/torso-thorax.zarr --sizes 128,256,512,1024 --repeats 7 --device auto
//
// --check 1 first compares every scene's GPU picture with the float mirror's, and ends where they differ.
//
// All cases run once a round, every other round backwards, after one round of warming up that also counts the
// work. Timed frames do not count: the counters are compiled out of them. Frames above --slow-ms are timed
// once.
#include "tests/bench/bench_tools.h"

#include "core/base/error.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/gpu_engine.h"
#include "render/backends/mirror/mirror.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>

namespace tessera::bench {
namespace {

struct Case {
    std::string scene;
    SceneOnDevice* onDevice = nullptr;
    double stepVoxels = 0.5;
    int size = 0; // pixels an axis
    Fetch fetch = Fetch::hardware;
    Work work;
    std::vector<double> ms, wallMs;
};

std::vector<std::filesystem::path> sceneFiles(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    if (std::filesystem::is_directory(folder))
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            if (entry.path().extension() == ".json")
                files.push_back(entry.path());
    if (files.empty())
        throw InputError("--scenes: expected a folder with scenes (.json), found none in " + folder.string());
    std::sort(files.begin(), files.end());
    return files;
}

void runRound(std::vector<Case>& cases, bool backwards, bool warmUp, double slowMs) {
    for (std::size_t i = 0; i < cases.size(); ++i) {
        Case& c = cases[backwards ? cases.size() - 1 - i : i];
        if (!c.ms.empty() && minimum(c.ms) > slowMs)
            continue; // once is enough; the column "repeats" says so
        std::uint32_t features = c.onDevice->features(c.fetch);
        if (warmUp)
            features |= kFeatureCounting;
        const Frame frame = c.onDevice->draw(glm::ivec2(c.size), c.stepVoxels, features, nullptr);
        if (warmUp) {
            c.work = frame.work;
            continue;
        }
        c.ms.push_back(frame.ms);
        c.wallMs.push_back(frame.wallMs);
        c.work.longestDispatchMs = std::max(c.work.longestDispatchMs, frame.work.longestDispatchMs);
    }
}

/// The GPU ray caster with exact fetches must give the float mirror's result on the device's own rays
/// (docs/sampling.md, "Equalities and tolerances").
void checkAgainstMirror(const std::string& name, Scene scene, const StoreReader& store,
                        const GlContext& context, Budgets& budgets) {
    constexpr float kMost = 1e-5f;
    scene.imageSize = glm::ivec2(96);
    scene.quality.fetch = Fetch::exact;
    GpuEngine engine(context, budgets.gpu, budgets.ram);
    Planner plan =
        planScene(scene, store, engine.limits(), {budgets.ram, budgets.gpu, 0}, LevelChoice::oneForAll);
    Work work;
    loadBricks(engine, plan, budgets.gpu, work);
    const auto caster = engine.caster({}, budgets.gpu);
    caster->begin(raysOf(plan));
    drawToTheEnd(*caster, engine, plan, Slicing{}, work);
    const Image picture = caster->image();
    const std::vector<SegmentedRay<float>> rays = gpuRays(plan.view.frame, budgets.gpu);
    const std::vector<glm::vec4> mirror = mirrorRays<float>(
        mirrorInput(plan, plan.view.quality.skipping), rays.size(), [&](std::size_t i) { return rays[i]; }, 0,
        work);
    float largest = 0;
    for (std::size_t i = 0; i < rays.size(); ++i)
        for (int c = 0; c < 4; ++c)
            largest = std::max(largest, std::abs(picture.pixels[i][c] - mirror[i][c]));
    std::fprintf(stderr, "%s: march and mirror differ by at most %.2g\n", name.c_str(),
                 static_cast<double>(largest));
    if (!(largest <= kMost))
        throw Error(name + ": expected a march within 1e-5 of the mirror; see docs/sampling.md");
}

void printCsv(const std::vector<Case>& cases, const std::string& device, double loadBefore) {
    std::printf("device,scene,fetch,pixels,step_voxels,level,repeats,time_min_ms,time_med_ms,wall_med_ms,"
                "iterations,segments,samples,fetches,dispatches,longest_dispatch_ms,bricks,bytes_uploaded,"
                "load_before,load_after\n");
    std::string plainDevice = device;
    std::replace(plainDevice.begin(), plainDevice.end(), ',', ';');
    for (const Case& c : cases) {
        const Work& w = c.work;
        const Work& u = c.onDevice->uploadWork();
        const auto n = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
        std::printf(
            "%s,%s,%s,%dx%d,%g,%d,%zu,%.2f,%.2f,%.2f,%llu,%llu,%llu,%llu,%llu,%.1f,%llu,%llu,%.2f,%.2f\n",
            plainDevice.c_str(), c.scene.c_str(), c.fetch == Fetch::exact ? "exact" : "hardware", c.size,
            c.size, c.stepVoxels, c.onDevice->prepared().layer().selection.finest(), c.ms.size(),
            minimum(c.ms), median(c.ms), median(c.wallMs), n(w.iterations), n(w.segments), n(w.samples),
            n(w.fetches), n(w.dispatches), w.longestDispatchMs, n(u.bricksUploaded), n(u.bytesUploaded),
            loadBefore, loadAverage());
    }
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--phantom", "512x512x749"},
                                 {"--scenes", TESSERA_BENCH_SCENES},
                                 {"--only", ""},
                                 {"--sizes", "128,256,512,1024"},
                                 {"--fetch", "both"},
                                 {"--repeats", "7"},
                                 {"--slow-ms", "10000"},
                                 {"--device", "auto"},
                                 {"--check", "0"},
                                 {"--gpu-memory", "4GiB"}});
    const GlContext context(GlDeviceChoice{options["--device"]});
    Budgets budgets(parseBytes(options["--gpu-memory"], "--gpu-memory"));
    std::map<std::filesystem::path, std::unique_ptr<StoreReader>> stores;
    std::vector<std::unique_ptr<SceneOnDevice>> scenes;
    std::vector<Case> cases;
    std::vector<Fetch> fetches = {Fetch::hardware, Fetch::exact};
    if (options["--fetch"] != "both")
        fetches = {parseName<Fetch>(options["--fetch"], "--fetch")};
    for (const std::filesystem::path& file : sceneFiles(options["--scenes"])) {
        if (file.stem().string().find(options["--only"]) == std::string::npos)
            continue;
        const Scene scene = loadScene(file);
        const std::filesystem::path path =
            options["--store"].empty() ? scene.volumes.at(0).path : std::filesystem::path(options["--store"]);
        ensurePhantomStore(path, "torso", parseExtent(options["--phantom"], "--phantom"));
        auto& store = stores[path];
        if (!store)
            store = std::make_unique<StoreReader>(path, budgets.ram);
        if (options["--check"] == "1")
            checkAgainstMirror(file.stem().string(), scene, *store, context, budgets);
        scenes.push_back(std::make_unique<SceneOnDevice>(scene, *store, context, budgets));
        for (const double size : parseNumbers(options["--sizes"], "--sizes"))
            for (const Fetch fetch : fetches)
                cases.push_back({file.stem().string(),
                                 scenes.back().get(),
                                 scene.quality.stepVoxels,
                                 static_cast<int>(size),
                                 fetch,
                                 {},
                                 {},
                                 {}});
    }
    if (cases.empty())
        throw InputError("--only: expected part of a scene's name, found \"" + options["--only"] + "\"");
    const int repeats = static_cast<int>(parseNumbers(options["--repeats"], "--repeats").at(0));
    const double slowMs = parseNumbers(options["--slow-ms"], "--slow-ms").at(0);
    const double load = loadAverage();
    for (int round = 0; round <= repeats; ++round)
        runRound(cases, round % 2 == 0, round == 0, slowMs);
    if (!context.errors().empty())
        throw Error("OpenGL: " + context.errors().front());
    printCsv(cases, context.renderer(), load);
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("frame_bench", tessera::bench::run, argc, argv);
}
