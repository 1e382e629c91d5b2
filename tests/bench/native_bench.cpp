// tests/bench/native_bench.cpp: the distance of the native engine from the CPU's limit. A scene is drawn many
// times with every ISA that the CPU has, and milliseconds, samples per second and lanes in use are reported.
// The comparison is a bare loop with nothing but trilinear samples along a line.
//
//   native_bench --store build/bench-data/torso-thorax.zarr --preset bone --light on --step 0.5 --rounds 5
#include "tests/bench/bench_tools.h"

#include "core/base/error.h"
#include "core/base/names.h"
#include "render/backends/native/native_caster.h"
#include "render/picture/picture.h"
#include "render/plan/planner.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <string>

namespace tessera::bench {
namespace {

double cpuSeconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--store", ""},
                                 {"--preset", "bone-1"},
                                 {"--scene", ""},
                                 {"--light", "on"},
                                 {"--step", "0.5"},
                                 {"--rounds", "5"},
                                 {"--size", "512"},
                                 {"--threads", "0"},
                                 {"--gradient", "central"},
                                 {"--integrator", "midpoint"},
                                 {"--gpu-memory", "4096"},
                                 {"--blocks", "1"},
                                 {"--targets", "avx512,avx2,baseline"}});
    const int threads = static_cast<int>(std::stod(options["--threads"]));
    Budgets budgets(static_cast<std::size_t>(std::stod(options["--gpu-memory"])) << 20);
    const StoreReader store(options["--store"], budgets.ram);
    Scene scene;
    SceneVolume volume;
    volume.transferFunction = options["--preset"];
    scene.volumes = {volume};
    scene.camera = FittedView{View::anterior};
    scene.imageSize = glm::ivec2(static_cast<int>(std::stod(options["--size"])));
    if (!options["--scene"].empty())
        scene = loadScene(options["--scene"]);
    scene.imageSize = glm::ivec2(static_cast<int>(std::stod(options["--size"])));
    scene.shading.on = options["--light"] == "on";
    const auto named = [&](const auto& names, const std::string& name) {
        const auto at = std::find(names.begin(), names.end(), name);
        if (at == names.end())
            throw InputError("expected one of " + joinNames(names) + ", found " + name);
        return static_cast<int>(at - names.begin());
    };
    scene.shading.gradient = static_cast<Gradient>(named(gradientNames(), options["--gradient"]));
    scene.quality.integrator = static_cast<Integrator>(named(integratorNames(), options["--integrator"]));
    scene.quality.stepVoxels = std::stod(options["--step"]);
    NativeEngine engine(threads, budgets.gpu, budgets.ram);
    const auto preparing = Clock::now();
    Planner plan = planScene(scene, store, engine.limits(), {budgets.ram, budgets.gpu, threads});
    const double planMs = msSince(preparing);
    Work work;
    const auto loading = Clock::now();
    loadBricks(engine, plan, budgets.gpu, work);
    const double loadMs = msSince(loading);
    const auto settling = Clock::now();
    engine.settled();
    std::printf("plan %.1f ms, load %.1f ms, ghost layers %.1f ms, page edge %d, %s\n", planMs, loadMs,
                msSince(settling), plan.layer().pageEdge,
                plan.layer().mixed() ? "mixed levels" : "one level");
    const auto bareRate = [&](const NativeCaster& caster) {
        const native::PacketScene packets = caster.packetScene();
        std::int32_t brick[3] = {-1, 0, 0};
        for (std::size_t b = 0; b < engine.plane().bricks().size() && brick[0] < 0; ++b)
            if ((engine.plane().bricks()[b].low >> 24) == 0) {
                const glm::ivec3 at = gridPosition(b, engine.plane().grid());
                brick[0] = at.x, brick[1] = at.y, brick[2] = at.z;
            }
        if (brick[0] < 0)
            return 0.0;
        native::PacketJob job{};
        constexpr int kTurns = 400000;
        double best = 1e9;
        for (int round = 0; round < 5; ++round) {
            const double before = cpuSeconds();
            caster.target().bareSamples(packets, brick, kTurns, job);
            best = std::min(best, cpuSeconds() - before);
        }
        return 1e-6 * kTurns * caster.target().lanes() / best;
    };
    const native::PacketTargets targets = native::packetTargets();
    for (int n = targets.count - 1; n >= 0; --n) {
        const native::PacketTarget* const target = targets.all[n];
        if (options["--targets"].find(target->name) == std::string::npos)
            continue;
        NativeCaster caster(plan, engine, {}, budgets.gpu, target);
        if (std::stod(options["--blocks"]) != 0)
            caster.findBlocks();
        std::vector<double> ms, cpu;
        Work drawn;
        for (int round = 0; round < static_cast<int>(std::stod(options["--rounds"])); ++round) {
            drawn = Work();
            const auto start = Clock::now();
            const double before = cpuSeconds();
            caster.begin(raysOf(plan));
            drawToTheEnd(caster, engine, plan, Slicing{}, drawn);
            ms.push_back(msSince(start));
            cpu.push_back(1e3 * (cpuSeconds() - before));
        }
        std::printf("%-9s bare trilinear samples: %.0f M/s a core\n", target->name, bareRate(caster));
        const double seconds = 1e-3 * minimum(cpu);
        const NativeCaster::Lanes lanes = caster.lanes();
        std::printf(
            "%-9s %7.1f ms, cpu %7.1f ms; %.1f M turns, %.1f M segments, %.1f M samples; %.0f M samples/s a "
            "core; %.2f M pixels/s a core; lanes %.2f; blocks of %zu cells, the first time cpu %.1f ms "
            "more\n",
            target->name, minimum(ms), minimum(cpu), 1e-6 * static_cast<double>(drawn.iterations),
            1e-6 * static_cast<double>(drawn.segments), 1e-6 * static_cast<double>(drawn.samples),
            1e-6 * static_cast<double>(drawn.samples) / seconds,
            1e-6 * static_cast<double>(rayCount(scene.imageSize)) / seconds,
            static_cast<double>(lanes.used) / (static_cast<double>(lanes.turns) * lanes.width),
            caster.refinedCells(), cpu.front() - minimum(cpu));
    }
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("native_bench", tessera::bench::run, argc, argv);
}
