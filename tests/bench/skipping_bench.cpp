// tests/bench/skipping_bench.cpp: savings and cost of empty-space skipping.
//
//   skipping_bench --stores a.zarr,b.zarr --functions bone,vessels --size 512 --repeats 5
//   skipping_bench --map 1024 --repeats 5
//
// The first prints, per scan and function, samples against those of an oracle that knows which strides have
// extinction before a ray's end. It also prints milliseconds of a frame without skipping, with a map of
// bricks, and with a map of cells. The second times proof and map for a made-up volume of cubic extent: all
// of it, after a change of the function, and after changes of some bricks' levels.
#include "core/base/error.h"
#include "core/scene/preset.h"
#include "render/backends/gpu/features.h"
#include "render/backends/gpu/gl/context.h"
#include "render/backends/gpu/march.h"
#include "render/backends/gpu/skipping_binding.h"
#include "tests/bench/bench_tools.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <random>
#include <sstream>

namespace tessera::bench {
namespace {

/// A ball with a thick shell and noise, as statistics alone.
Statistics madeUpStatistics(int edge, VolumeInfo& info) {
    info.extentVoxels = glm::ivec3(edge);
    info.type = ValueType::i16;
    Statistics s;
    s.cells = cellGrid(info.extentVoxels);
    s.bricks = brickGrid(info.extentVoxels);
    s.lowest = 0;
    s.highest = 1000;
    std::mt19937 random(1);
    std::uniform_real_distribution<float> noise(0, 60);
    glm::ivec3 at(0);
    for (at.z = 0; at.z < s.cells.z; ++at.z)
        for (at.y = 0; at.y < s.cells.y; ++at.y)
            for (at.x = 0; at.x < s.cells.x; ++at.x) {
                const glm::vec3 p = (glm::vec3(at) + 0.5f) / glm::vec3(s.cells) * 2.0f - 1.0f;
                const float shells = 500.0f + 400.0f * std::sin(20.0f * glm::dot(p, p));
                const float value = glm::dot(p, p) < 0.9f ? shells : 0.0f;
                s.cellMin.push_back(std::max(value - noise(random), 0.0f));
                s.cellMax.push_back(value + noise(random));
            }
    const std::size_t bricks = cellCount(s.bricks);
    s.brickMean.resize(bricks);
    s.brickMin.assign(bricks, s.highest);
    s.brickMax.assign(bricks, s.lowest);
    std::size_t cell = 0;
    for (at.z = 0; at.z < s.cells.z; ++at.z)
        for (at.y = 0; at.y < s.cells.y; ++at.y)
            for (at.x = 0; at.x < s.cells.x; ++at.x, ++cell) {
                const std::size_t b = linearIndex(at / kCellsPerBrick, s.bricks);
                s.brickMin[b] = std::min(s.brickMin[b], s.cellMin[cell]);
                s.brickMax[b] = std::max(s.brickMax[b], s.cellMax[cell]);
            }
    for (std::size_t b = 0; b < bricks; ++b)
        s.brickMean[b] = 0.5f * (s.brickMin[b] + s.brickMax[b]);
    s.wideMin = s.brickMin; // a layer more than there is: these pictures are not lit
    s.wideMax = s.brickMax;
    return s;
}

/// Milliseconds of all threads together: what a busy machine does not change.
double cpuMs() {
    return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void benchMap(int edge, int repeats) {
    MemoryBudget ram("RAM", "--ram", std::size_t{16} << 30);
    VolumeInfo info;
    const Statistics statistics = madeUpStatistics(edge, info);
    const auto table = [](double from) {
        return makeTable(TransferFunction::fromOpacity({{from, 0}, {from + 200, 0.5}}, {}, 1));
    };
    const TransferTable tables[2] = {table(600), table(640)};
    std::mt19937 random(2);
    for (const bool mixed : {false, true})
        for (const MapScale scale : {MapScale::cells, MapScale::bricks}) {
            Selection s = cullBricks(statistics, tables[0], info, 0, Culling::unlit);
            std::vector<std::size_t> shown;
            for (std::size_t b = 0; b < s.levels.size(); ++b)
                if (s.levels[b] != Selection::kEmpty) {
                    shown.push_back(b);
                    if (mixed)
                        s.levels[b] = static_cast<std::uint8_t>(random() % 3);
                }
            const auto recount = [&] {
                s.counts = {};
                for (const std::uint8_t level : s.levels)
                    ++s.counts[level];
            };
            recount();
            const auto input = [&](int t) { return OccupancyInput{statistics, tables[t], info, s}; };
            enum Edit { kFresh, kFunction, kOneBrick, k300, kScattered, kTogether, kEdits };
            std::vector<double> ms[kEdits], cpu[kEdits];
            std::size_t occupied = 0;
            const auto timed = [&](Edit edit, const auto& change) {
                const double cpuBefore = cpuMs();
                const auto start = Clock::now();
                change();
                ms[edit].push_back(msSince(start));
                cpu[edit].push_back(cpuMs() - cpuBefore);
            };
            const Selection before = s;
            for (int i = 0; i < repeats; ++i) {
                Occupancy o;
                s = before;
                timed(kFresh, [&] { o = Occupancy(input(0), scale, ram); });
                occupied = o.occupiedCells();
                for (int change = 0; change < 2; ++change)
                    timed(kFunction, [&] { o.functionChanged(input(1 - change)); });
                const auto levels = [&](Edit edit, std::size_t first, std::size_t count, bool scattered) {
                    for (std::size_t n = 0; n < count; ++n) {
                        std::uint8_t& level =
                            s.levels[shown[scattered ? random() % shown.size() : first + n]];
                        level = static_cast<std::uint8_t>((level + 1) % 4);
                    }
                    recount();
                    timed(edit, [&] { o.levelsChanged(input(0)); });
                };
                for (int n = 0; n < 5; ++n)
                    levels(kOneBrick, 0, 1, true);
                levels(k300, 0, 300, true);
                const std::size_t part = shown.size() / 20;
                levels(kScattered, 0, part, true);
                levels(kTogether, random() % (shown.size() - part), part, false); // in the order of [z][y][x]
            }
            std::printf("%d^3,%s,%s,%zu,%.3f", edge, mixed ? "mixed" : "level 0",
                        scale == MapScale::cells ? "cells" : "bricks", statistics.cellMin.size(),
                        static_cast<double>(occupied) / static_cast<double>(statistics.cellMin.size()));
            for (int edit = 0; edit < kEdits; ++edit)
                std::printf(",%.2f,%.2f", minimum(ms[edit]), minimum(cpu[edit]));
            std::printf(",%zu,%.2f\n", Occupancy::bytes(info.extentVoxels, scale), loadAverage());
        }
}

enum Way { kNone, kPlainChebyshev, kBricks, kCells, kBlocks, kWays };
constexpr const char* kWayNames[kWays] = {"none", "plain", "bricks", "cells", "blocks"};

/// One scan under one function, drawn every way.
struct SkippingCase {
    std::unique_ptr<SceneOnDevice> onDevice;
    Occupancy ways[kWays];
    Work work[kWays];
    std::vector<double> ms[kWays], refineMs[kWays];
    double oracle = 0;
    std::size_t refined = 0;
    Image picture;
    bool same = true;
};

void draw(SkippingCase& c, int way, bool counting, Fetch fetch, int size, Budgets& budgets) {
    const FramePlan& p = c.onDevice->prepared();
    std::uint32_t features = c.onDevice->features(fetch) & ~std::uint32_t{kFeatureSkipping};
    if (way != kNone)
        features |= kFeatureSkipping;
    if (counting)
        features |= kFeatureCounting | kFeatureShading;
    const RayFrame<double> frame =
        rayFrame(p.view.camera, p.info(), glm::ivec2(size), p.view.quality.stepVoxels);
    March march(features, frame, p.info(), p.strides(), p.layer().optics,
                way == kNone ? nullptr : &c.ways[way], budgets.gpu);
    const FieldSource& source = c.onDevice->engine().field();
    if (way == kBlocks) {
        const auto start = Clock::now();
        c.refined = refineSkipping(march.skippingMap(), c.ways[way], p.layer().table, p.layer().optics,
                                   features, p.info(), source, budgets.gpu);
        c.refineMs[way].push_back(msSince(start));
    }
    Work work;
    march.run(source, Slicing{}, work);
    if (!counting) {
        c.ms[way].push_back(work.marchMs);
        return;
    }
    c.work[way] = work;
    c.oracle = static_cast<double>(work.samples - work.segments) / 6; // each of its samples has a gradient
    Image picture = march.image();
    if (way == kNone)
        c.picture = std::move(picture);
    else
        c.same = c.same && std::memcmp(picture.pixels.data(), c.picture.pixels.data(),
                                       picture.pixels.size() * sizeof(glm::vec4)) == 0;
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, ',');)
        parts.push_back(part);
    return parts;
}

void benchScenes(std::map<std::string, std::string>& options, int repeats) {
    const GlContext context(GlDeviceChoice{options["--device"]});
    Budgets budgets(std::size_t{4} << 30);
    const int size = static_cast<int>(parseNumbers(options["--size"], "--size").at(0));
    const Fetch fetch = parseName<Fetch>(options["--fetch"], "--fetch");
    std::printf("scan,function,fetch,pixels,oracle,all,cells,blocks,cells_per_oracle,blocks_per_oracle,"
                "iterations_plain,iterations_cells,iterations_blocks,same");
    for (const char* way : kWayNames)
        std::printf(",%s_ms", way);
    std::printf(",refine_ms,refined_cells,load\n");
    for (const std::string& store : split(options["--stores"])) {
        const StoreReader reader(store, budgets.ram);
        const bool hu = reader.info().unit == "HU";
        for (const std::string& function : split(hu ? options["--functions"] : std::string("auto"))) {
            Scene scene;
            scene.camera = FittedView{View::anterior, Projection::perspective, Fit::volume};
            SceneVolume volume;
            volume.transferFunction = function;
            scene.volumes = {volume};
            scene.shading.on = false;
            scene.quality.fetch = fetch;
            SkippingCase c;
            c.onDevice = std::make_unique<SceneOnDevice>(scene, reader, context, budgets);
            const FramePlan& p = c.onDevice->prepared();
            const OccupancyInput input{p.layer().statistics, p.layer().table, p.info(), p.layer().selection,
                                       p.view.quality.edgeFunction};
            for (const Way way : {kCells, kBlocks})
                c.ways[way] = Occupancy(input, MapScale::cells, budgets.ram);
            c.ways[kBricks] = Occupancy(input, MapScale::bricks, budgets.ram);
            c.ways[kPlainChebyshev] = c.ways[kCells].plainChebyshev(budgets.ram);
            for (int way = 0; way < kWays; ++way)
                draw(c, way, true, fetch, size, budgets);
            for (int i = 0; i < repeats; ++i)
                for (int way = 0; way < kWays; ++way)
                    draw(c, i % 2 == 0 ? way : kWays - 1 - way, false, fetch, size, budgets);
            const auto n = [](std::uint64_t value) { return static_cast<double>(value); };
            std::printf("%s,%s,%s,%d,%.0f,%.0f,%.0f,%.0f,%.2f,%.3f,%.0f,%.0f,%.0f,%s",
                        std::filesystem::path(store).stem().c_str(), function.c_str(),
                        options["--fetch"].c_str(), size, c.oracle, n(c.work[kNone].segments),
                        n(c.work[kCells].segments), n(c.work[kBlocks].segments),
                        n(c.work[kCells].segments) / c.oracle, n(c.work[kBlocks].segments) / c.oracle,
                        n(c.work[kPlainChebyshev].iterations), n(c.work[kCells].iterations),
                        n(c.work[kBlocks].iterations), c.same ? "yes" : "NO");
            for (const auto& ms : c.ms)
                std::printf(",%.1f", minimum(ms));
            std::printf(",%.1f,%zu,%.2f\n", minimum(c.refineMs[kBlocks]), c.refined, loadAverage());
            std::fflush(stdout);
        }
    }
}

void run(int argc, char** argv) {
    auto options = parseOptions(argc, argv,
                                {{"--map", ""},
                                 {"--stores", ""},
                                 {"--functions", "bone,vessels,soft-tissue"},
                                 {"--size", "512"},
                                 {"--fetch", "hardware"},
                                 {"--device", "auto"},
                                 {"--repeats", "5"}});
    const int repeats = static_cast<int>(parseNumbers(options["--repeats"], "--repeats").at(0));
    if (!options["--map"].empty()) {
        std::printf("extent,levels,map,cells,occupied");
        for (const char* edit : {"all", "function", "one_brick", "300_bricks", "5%_scattered", "5%_together"})
            std::printf(",%s_ms,%s_cpu_ms", edit, edit);
        std::printf(",bytes,load\n");
        for (const double edge : parseNumbers(options["--map"], "--map"))
            benchMap(static_cast<int>(edge), repeats);
    }
    if (!options["--stores"].empty())
        benchScenes(options, repeats);
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("skipping_bench", tessera::bench::run, argc, argv);
}
