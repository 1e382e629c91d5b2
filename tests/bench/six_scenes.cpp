// tests/bench/six_scenes.cpp: Tessera's engines and VTK's two volume mappers on a suite of pictures, unlit
// and lit, in one interleaved run: how long each takes to be just good enough.
//
//   tests/bench/run.sh six
//   xvfb-run -a six_scenes --stores torso=T.zarr,abdomen=A.zarr,chest=C.zarr --truths FOLDER --csv FILE.csv
//
// A picture is good enough at both an rms of 1/255 and a 99th percentile of 3 in CIE L*u*v* against the true
// integral in double. Every n-th pixel of every n-th row counts, 128 along the longer side. Errors are of
// linear light rounded to 8 bits, which is all that VTK hands out. In dark pictures rounding alone comes near
// 3, so that what the reference itself has when it is rounded is added in quadrature (--with-rounding 0: it
// is not). Renderers take ever finer settings until they meet that. The last setting that missed it and the
// first that met it are then timed, all renderers in turn. The time at the target is interpolated between the
// two, log-log. Times are wall-clock times from the request to the picture in memory, 8 bits of VTK's, floats
// of Tessera's. They exclude work done once per scene: tables, uploads, normals of VTK's CPU mapper. Lit
// scenes have no highlight, which the two define otherwise (vtk_renderer.h), and a camera in parallel
// projection, but for the one in the body. Pictures whose store is not given are left out, and named.
// References take a minute: they are kept (--truths).
#include "core/base/error.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/contest.h"
#include "tests/bench/engine_peer.h"
#include "tests/bench/peer_truth.h"
#include "tests/bench/six_tables.h"
#include "tests/bench/suite.h"
#include "tests/bench/truth_file.h"
#include "tests/bench/vtk_renderer.h"
#if TESSERA_WITH_IMAGE_FILES
#include "core/image/image_file.h"
#include "render/plan/planner.h"
#endif

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

namespace tessera::bench {
namespace {

constexpr int kComparedExtent = 128; // pixels along the longer side

using Options = std::map<std::string, std::string>;

/// A store and all its voxels, for the pictures that follow one another on it.
struct OpenStore {
    explicit OpenStore(const std::filesystem::path& path) : reader(path, ram), voxels(wholeVolume(reader)) {}
    MemoryBudget ram{"RAM", "--ram", std::size_t{4} << 30};
    StoreReader reader;
    std::vector<std::byte> voxels;
};

Truth truthOf(const SuitePicture& picture, const Scene& scene, const FramePlan& plan, OpenStore& store,
              const Options& options) {
    Truth truth;
    const glm::ivec2 size = scene.imageSize;
    truth.stride = (std::max(size.x, size.y) + kComparedExtent - 1) / kComparedExtent;
    truth.leftOut = borderPixels(plan, size, truth.stride);
    const auto make = [&] {
        const auto start = Clock::now();
        BrickCache cache(store.reader, store.ram, std::size_t{1} << 30, 0);
        Image image = referenceImage(cache, plan, scene.shading, size, truth.stride, glm::dvec2(0));
        std::fprintf(stderr, "%s: reference, %zu pixels, %.0f s\n", picture.label().c_str(),
                     image.pixels.size(), 1e-3 * msSince(start));
        return image;
    };
    const std::string key = truthKey(scene, store.reader.contentHash(), size, truth.stride);
    truth.picture = without(truthFromFile(options.at("--truths"), picture.label(), key, make), truth.leftOut);
    return truth;
}

/// All pictures of the finest settings that were drawn, side by side.
void writePictures(const std::string& folder, const SuitePicture& picture,
                   const std::vector<Image>& pictures) {
#if TESSERA_WITH_IMAGE_FILES
    const glm::ivec2 size = pictures.front().size;
    Image all(glm::ivec2(size.x * static_cast<int>(pictures.size()), size.y));
    for (std::size_t i = 0; i < pictures.size(); ++i)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                all.at(static_cast<int>(i) * size.x + x, y) = pictures[i].at(x, y);
    writeImage(std::filesystem::path(folder) / (picture.label() + ".png"), overBackground(all, glm::vec3(0)),
               "");
#else
    (void)folder, (void)picture, (void)pictures;
#endif
}

PictureResult contestOf(const SuitePicture& picture, const Scene& scene, const FramePlan& plan,
                        OpenStore& store, const Options& options, const ContestLimits& limits) {
    const VolumeInfo& info = store.reader.info();
    const glm::ivec2 size = scene.imageSize;
    const Truth truth = truthOf(picture, scene, plan, store, options);
    // VTK counts in mm along the ray, Tessera in voxels. By the smallest side of a voxel VTK's settings are
    // at least as fine as ours along any ray; which errors they come to is what is compared.
    const glm::dvec3 spacing = info.spacingMm();
    const double voxelMm = std::min({spacing.x, spacing.y, spacing.z});
    PictureResult result;
    result.name = picture.name, result.store = picture.store;
    result.lit = scene.shading.on, result.size = size;
    result.cpuMapperSeesTheLight = !scene.shading.on || plan.view.camera.projection == Projection::parallel;
    result.comparedPixels = truth.picture.pixels.size();
    result.loadBefore = loadAverage();
    result.roundingLuvP99 = compare(roundedTo8Bits(truth.picture), truth.picture).luvP99;
    if (options.at("--with-rounding") != "0")
        result.target.luvP99 = std::hypot(result.target.luvP99, result.roundingLuvP99);

    std::vector<std::unique_ptr<VtkRenderer>> vtk;
    const std::pair<VtkMapper, const char*> mappers[] = {{VtkMapper::cpu, kVtkCpu},
                                                         {VtkMapper::gpu, kVtkGpu}};
    for (const auto& [mapper, name] : mappers) {
        vtk.push_back(std::make_unique<VtkRenderer>(mapper, info, store.voxels, plan.layer().function,
                                                    scene.shading, plan.view.camera, size));
        VtkRenderer& renderer = *vtk.back();
        Contender contender;
        contender.name = name;
        contender.draw = [&renderer, voxelMm](double voxels) { return renderer.drawMs(voxels * voxelMm); };
        contender.picture = [&renderer] { return renderer.picture(); };
        result.contenders.push_back(std::move(contender));
    }
    std::vector<std::unique_ptr<EnginePeer>> engines;
    for (const EngineKind kind : parseEngines(options.at("--engines"), "--engines")) {
        engines.push_back(std::make_unique<EnginePeer>(kind, scene, store.reader, options.at("--device")));
        EnginePeer& engine = *engines.back();
        Contender contender;
        contender.name = name(kind);
        contender.tessera = true;
        contender.draw = [&engine](double voxels) { return engine.drawMs(voxels); };
        contender.picture = [&engine] { return engine.picture(); };
        contender.count = [&engine](double voxels) { return engine.count(voxels); };
        result.contenders.push_back(std::move(contender));
    }

    std::fprintf(stderr, "  target: rms %.5f, L*u*v* p99 %.2f; the reference rounded to 8 bits has %.2f\n",
                 result.target.rms, result.target.luvP99, result.roundingLuvP99);
    std::vector<Image> finest;
    for (Contender& contender : result.contenders) {
        climb(contender, parseNumbers(options.at("--distances"), "--distances"), truth, result.target,
              limits);
        finest.push_back(contender.picture());
        for (const Setting& s : contender.settings)
            std::fprintf(stderr, "  %-8s %-6g rms %.5f  L*u*v* p99 %5.2f  %7.0f ms\n", contender.name.c_str(),
                         s.voxels, s.error.rms, s.error.luvP99, s.firstMs);
    }
    if (!options.at("--pictures").empty())
        writePictures(options.at("--pictures"), picture, finest);

    const Contender& cpu = result.contenders.front();
    const std::size_t cpuBest = cheapestOfBest(cpu);
    std::vector<std::vector<std::size_t>> deciding;
    for (const Contender& contender : result.contenders)
        deciding.push_back(decidingSettings(contender, result.target,
                                            contender.tessera ? std::optional(cpu.settings[cpuBest].error.rms)
                                                              : std::nullopt));
    if (std::find(deciding.front().begin(), deciding.front().end(), cpuBest) == deciding.front().end())
        deciding.front().push_back(cpuBest);
    runRounds(result.contenders, deciding, limits);
    for (Contender& contender : result.contenders)
        if (const std::size_t to = timeAt(contender, result.target, minimum).to; contender.count)
            contender.settings[to].work = contender.count(contender.settings[to].voxels);
    for (Contender& contender : result.contenders) // their renderers are released
        contender.draw = nullptr, contender.picture = nullptr, contender.count = nullptr;
    result.loadAfter = loadAverage();
    std::fprintf(stderr, "  on %s; %s\n", vtk.back()->device().c_str(),
                 engines.empty() ? "no engine" : engines.front()->device().c_str());
    return result;
}

/// All engines of the program but those that show what is right; automatic is one of the others.
std::string contendingEngines() {
    std::string out;
    for (const EngineTraits& traits : engineTraits())
        if (traits.quick)
            out += (out.empty() ? "" : ",") + traits.name;
    return out;
}

void run(int argc, char** argv) {
    const Options options = parseOptions(argc, argv,
                                         {{"--suite", TESSERA_BENCH_SUITE},
                                          {"--stores", ""},
                                          {"--truths", "build/bench-results"},
                                          {"--truths-only", "0"},
                                          {"--engines", contendingEngines()},
                                          {"--device", "software"},
                                          {"--distances", "4,2,1,0.5,0.25,0.125"},
                                          {"--rounds", "9"},
                                          {"--most-seconds", "40"},
                                          {"--quick", "0"},
                                          {"--with-rounding", "1"},
                                          {"--only", ""},
                                          {"--pictures", ""},
                                          {"--csv", ""}});
    const auto number = [&](const char* option) { return parseNumbers(options.at(option), option).at(0); };
    const bool quick = options.at("--quick") != "0", truthsOnly = options.at("--truths-only") != "0";
    ContestLimits limits;
    limits.rounds = quick ? 1 : static_cast<int>(number("--rounds"));
    limits.mostMs = 1e3 * number("--most-seconds");
    if (quick)
        std::fprintf(stderr, "one round, few pictures: a look, not a measurement\n");
    std::filesystem::create_directories(options.at("--truths"));
    if (!options.at("--pictures").empty())
        std::filesystem::create_directories(options.at("--pictures"));

    std::unique_ptr<OpenStore> store;
    std::vector<PictureResult> results;
    for (const SuitePicture& picture :
         readSuite(options.at("--suite"), parseStores(options.at("--stores"), "--stores"))) {
        if (picture.label().find(options.at("--only")) == std::string::npos || (quick && !picture.quick))
            continue;
        if (picture.storePath.empty()) {
            std::fprintf(stderr, "%s: left out, no store \"%s\" is given\n", picture.label().c_str(),
                         picture.store.c_str());
            continue;
        }
        if (!store || store->reader.path() != picture.storePath) {
            store.reset(); // before the next one: they are large
            store = std::make_unique<OpenStore>(picture.storePath);
        }
        const auto start = Clock::now();
        const Planner plan = planView(picture.scene, store->reader, store->ram, 0);
        Scene scene = picture.scene;
        scene.camera = plan.view.camera;
        scene.volumes.front().transferFunction = plan.layer().function;
        if (truthsOnly) {
            truthOf(picture, scene, plan, *store, options);
            continue;
        }
        std::fprintf(stderr, "%s, load %.1f\n", picture.label().c_str(), loadAverage());
        results.push_back(contestOf(picture, scene, plan, *store, options, limits));
        std::fprintf(stderr, "  %.0f s, load %.1f\n", 1e-3 * msSince(start), loadAverage());
        if (!options.at("--csv").empty()) // after every picture: a run that is cut off leaves what it has
            writeSixCsv(options.at("--csv"), results);
    }
    printSixTables(results);
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("six_scenes", tessera::bench::run, argc, argv);
}
