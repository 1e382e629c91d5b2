// tests/bench/selection_bench.cpp: predictions, choices, costs and times of selection.
//
//   selection_bench --mode prediction --stores a.zarr,b.zarr   rank correlation of predicted and true errors
//   selection_bench --mode choice --stores a.zarr,b.zarr       choices by several measures at equal bytes
//   selection_bench --mode speed --bricks 64 --threads 2       time of re-selecting, on invented bricks
//   selection_bench --mode hierarchy --stores a.zarr           table 2.1 of the course notes, and real scans
//
// Rows are CSV on standard output. Times are only worth as much as the machine is quiet: the load is printed.
#include "bricking/levels/level_selection.h"
#include "bricking/levels/visibility.h"
#include "bricking/statistics/brick_rays.h"
#include "core/base/error.h"
#include "core/base/threads.h"
#include "core/image/image_metrics.h"
#include "core/scene/preset.h"
#include "render/backends/mirror/mirror.h"
#include "render/plan/planner.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/lod/brick_truth.h"
#include "tests/bench/lod/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <random>
#include <sstream>

namespace tessera::bench {
namespace {

struct NamedFunction {
    std::string name;
    TransferFunction function;
};

/// All presets that suit the values, and two that are hard: a narrow translucent peak and an opaque surface.
std::vector<NamedFunction> functionsFor(const ValueSummary& values) {
    std::vector<NamedFunction> functions;
    for (const std::string& name : presetNames())
        if (values.isHu || name == "auto")
            functions.push_back({name, presetFunction(name, values)});
    const auto points = presetFunction("auto", values).opacityPoints();
    const double range = values.highest - values.lowest, mm = values.spacingMm;
    const double peak = points[2].value, width = 0.03 * range, surface = points[0].value;
    functions.push_back({"peak", TransferFunction::fromOpacity(
                                     {{peak - width, 0}, {peak, 0.3}, {peak + width, 0}},
                                     {{peak - width, {1, 0.2, 0.1}}, {peak + width, {0.2, 0.4, 1}}}, mm)});
    functions.push_back({"surface", TransferFunction::fromOpacity(
                                        {{surface, 0}, {surface + 0.02 * range, 0.9}},
                                        {{surface, {1, 0.6, 0.4}}, {values.highest, {1, 1, 0.9}}}, mm)});
    return functions;
}

std::vector<std::string> split(const std::string& text) {
    std::vector<std::string> parts;
    std::stringstream stream(text);
    for (std::string part; std::getline(stream, part, ',');)
        parts.push_back(part);
    if (parts.empty())
        throw InputError("--stores: expected stores, separated by commas, found none");
    return parts;
}

std::vector<std::uint8_t> showsOf(const Selection& culled) {
    std::vector<std::uint8_t> shows;
    for (const std::uint8_t level : culled.levels)
        shows.push_back(level == Selection::kEmpty ? 0 : 1);
    return shows;
}

std::size_t shown(const std::vector<std::uint8_t>& shows) {
    return static_cast<std::size_t>(std::count(shows.begin(), shows.end(), 1));
}

// -- prediction

void prediction(const std::vector<std::string>& stores, int parts, int threads) {
    std::printf("scan,function,level,bricks,true mean,rank correlation,predicted over true,data error's "
                "correlation\n");
    std::vector<double> all, allData;
    for (const std::string& path : stores) {
        Budgets budgets;
        const StoreReader store(path, budgets.ram);
        const Statistics statistics = loadStatistics(store, budgets.ram, threads);
        const WholeLevels levels = loadLevels(store);
        BrickRays rays = noBrickRays(store.info(), parts, budgets.ram);
        for (const NamedFunction& f : functionsFor(summarise(statistics, store.info()))) {
            const TransferTable table = makeTable(f.function);
            const std::vector<std::uint8_t> shows =
                showsOf(cullBricks(statistics, table, store.info(), 0, Culling::unlit));
            if (shown(shows) < 10)
                continue;
            addBrickRays(store, shows, rays, budgets.ram, threads);
            const LevelErrors predicted = predictErrors(rays, shows, table, store.info(), threads);
            const LevelErrors truth = trueErrors(levels, shows, table, threads);
            const LevelErrors data = dataErrors(levels, shows, threads);
            for (std::size_t level = 1; level < kLevelCount; ++level) {
                std::vector<double> a, b, c;
                for (std::size_t brick = 0; brick < shows.size(); ++brick)
                    if (shows[brick]) {
                        a.push_back(static_cast<double>(predicted.errors[brick][level]));
                        b.push_back(static_cast<double>(truth.errors[brick][level]));
                        c.push_back(static_cast<double>(data.errors[brick][level]));
                    }
                const double sumA = std::accumulate(a.begin(), a.end(), 0.0),
                             sumB = std::accumulate(b.begin(), b.end(), 0.0);
                all.push_back(rankCorrelation(a, b));
                allData.push_back(rankCorrelation(c, b));
                std::printf("%s,%s,%zu,%zu,%.2f,%.3f,%.2f,%.3f\n", std::filesystem::path(path).stem().c_str(),
                            f.name.c_str(), level, a.size(), sumB / static_cast<double>(b.size()), all.back(),
                            sumA / sumB, allData.back());
            }
        }
    }
    if (all.empty())
        return;
    std::sort(all.begin(), all.end());
    std::printf("# rank correlation: median %.3f, first decile %.3f, least %.3f; data error: median %.3f\n",
                median(all), all[all.size() / 10], all.front(), median(allData));
}

// -- choice

Image drawn(Planner& p, const Selection& selection, int threads) {
    p.setSelection(selection);
    Work work;
    Image image(p.view.imageSize);
    const auto colours = mirrorRays<float>(mirrorInput(p, true), image.pixels.size(),
                                           frameRays(cast<float>(p.view.frame)), threads, work);
    std::copy(colours.begin(), colours.end(), image.pixels.begin());
    return image;
}

/// The visibility of each brick, as the GPU ray caster counts it. Rays through level 2, which is fine enough
/// to know what hides what.
std::vector<SeenBrick> visibleCounts(const WholeLevels& levels, const TransferTable& table,
                                     const Camera& camera, const glm::ivec2& size, int threads) {
    constexpr int level = 2;
    const VolumeInfo& info = levels.info;
    const glm::ivec3 bricks = brickGrid(info.extentVoxels), extent = levels.extents[level];
    const RayFrame<double> frame = rayFrame(camera, info, size, 1 << level);
    std::vector<std::vector<SeenBrick>> rows(static_cast<std::size_t>(size.y));
    parallelFor(rows.size(), threads, [&](std::size_t y) {
        rows[y].resize(cellCount(bricks));
        for (int x = 0; x < size.x; ++x) {
            const SegmentedRay<double> ray =
                segmentedRay(frame, glm::dvec2(x + 0.5, static_cast<double>(y) + 0.5));
            double through = 1;
            std::size_t last = cellCount(bricks);
            for (int i = 0; i < ray.count && through > 1.0 / 510; ++i) {
                const glm::dvec3 p = ray.entry + (i + 0.5) * ray.step;
                const glm::ivec3 sample =
                    glm::clamp(glm::ivec3(glm::floor(p / 4.0)), glm::ivec3(0), extent - 1);
                const std::size_t brick = linearIndex(sample / (kBrickExtent >> level), bricks);
                if (brick != last) {
                    rows[y][brick].light +=
                        static_cast<std::uint32_t>(std::lround(SeenBrick::kLightOfRay * through));
                    ++rows[y][brick].rays;
                }
                last = brick;
                const double value =
                    info.rescaleSlope *
                        static_cast<double>(levels.values[level][linearIndex(sample, extent)]) +
                    info.rescaleIntercept;
                const double entry = std::clamp((value - static_cast<double>(table.firstValue)) *
                                                    static_cast<double>(table.entriesPerValue),
                                                0.0, static_cast<double>(table.entries.size() - 1));
                through *= std::exp(-static_cast<double>(table.entries[static_cast<std::size_t>(entry)].a) *
                                    ray.segmentMm);
            }
        }
    });
    std::vector<SeenBrick> counts(cellCount(bricks));
    for (const auto& row : rows)
        for (std::size_t brick = 0; brick < counts.size(); ++brick) {
            counts[brick].light += row[brick].light;
            counts[brick].rays += row[brick].rays;
        }
    return counts;
}

void choice(const std::vector<std::string>& stores, int size, const std::vector<double>& reductions,
            bool shading, int threads) {
    std::printf("scan,function,reduction,pages,by,luv mean,luv p99,predicted mean,predicted p99\n");
    for (const std::string& path : stores) {
        Budgets budgets(std::size_t{16} << 30);
        const StoreReader store(path, budgets.ram);
        const Statistics statistics = loadStatistics(store, budgets.ram, threads);
        const WholeLevels levels = loadLevels(store);
        for (const NamedFunction& f : functionsFor(summarise(statistics, store.info()))) {
            Scene scene;
            scene.camera = FittedView{View::anterior, Projection::perspective, Fit::volume};
            scene.volumes = {{path, f.function}};
            scene.imageSize = glm::ivec2(size);
            scene.shading.on = shading;
            Planner p = planScene(scene, store, TextureLimits{}, {budgets.ram, budgets.gpu, threads},
                                  LevelChoice::oneForAll);
            const std::vector<std::uint8_t> shows =
                showsOf(cullBricks(statistics, p.layer().table, store.info(), 0, Culling::unlit));
            if (shown(shows) < 10)
                continue;
            BrickRays rays = noBrickRays(store.info(), kBrickRayParts, budgets.ram);
            addBrickRays(store, shows, rays, budgets.ram, threads);
            const LevelErrors predicted = predictErrors(rays, shows, p.layer().table, store.info(), threads);
            const LevelErrors truth = trueErrors(levels, shows, p.layer().table, threads);
            const LevelErrors data = dataErrors(levels, shows, threads);
            const LevelErrors sizes = sizeErrors(predicted.bricks, shows);
            const ViewWeights view =
                viewWeights(p.view.camera, store.info(), p.view.imageSize, threads, shows);
            const ViewWeights byDistance = distanceWeights(view);
            const std::span<const float> means = statistics.brickMean;
            const std::vector<float> seen = visibilityFactors(
                visibleCounts(levels, p.layer().table, p.view.camera, p.view.imageSize, threads),
                cullBricks(statistics, p.layer().table, store.info(), 0, Culling::unlit));
            ViewWeights unlimited = view;
            std::fill(unlimited.finest.begin(), unlimited.finest.end(), std::uint8_t{0});
            const Image finest = drawn(p, selectForError(predicted, unlimited, means, 0), threads);
            for (const double reduction : reductions) {
                const auto pages = static_cast<std::size_t>(static_cast<double>(shows.size()) / reduction);
                const auto row = [&](const char* by, const Selection& s) {
                    const ImageDifference d = compare(drawn(p, s, threads), finest);
                    const PredictedError e = predictError(s, predicted, view, seen);
                    std::printf("%s,%s,%.0f,%zu,%s,%.3f,%.3f,%.3f,%.3f\n",
                                std::filesystem::path(path).stem().c_str(), f.name.c_str(), reduction,
                                pagesOf(s), by, d.luvMean, d.luvP99, e.mean, e.p99);
                };
                row("predicted", selectLevels(predicted, view, means, pages, seen, threads));
                row("true", selectLevels(truth, view, means, pages, seen, threads));
                row("data", selectLevels(data, view, means, pages, seen, threads));
                row("predicted with all visible", selectLevels(predicted, view, means, pages, {}, threads));
                row("distance", selectLevels(sizes, byDistance, means, pages, seen, threads));
                row("uniform", selectUniform(predicted, means, pages));
                std::fflush(stdout);
            }
        }
    }
}

// -- speed

/// Rays of invented bricks: noise around a random value, smoother with the level.
BrickRays inventedRays(const glm::ivec3& bricks, const std::vector<std::uint8_t>& shows) {
    BrickRays rays;
    rays.bricks = bricks;
    rays.rowOf.assign(shows.size(), BrickRays::kNoRow);
    std::minstd_rand random(1);
    for (std::size_t brick = 0; brick < shows.size(); ++brick) {
        if (!shows[brick])
            continue;
        if (rays.rows % BrickRays::kRowsPerPage == 0)
            rays.pages.emplace_back(BrickRays::kRowsPerPage * rays.rowBytes());
        const std::span<std::uint8_t> row = rays.row(static_cast<std::uint32_t>(rays.rows));
        rays.rowOf[brick] = static_cast<std::uint32_t>(rays.rows++);
        for (std::size_t n = 0; n < kBrickRayParts; ++n) {
            BrickRayPart part;
            part.lo = -200 + static_cast<float>(random() % 300);
            part.hi = part.lo + static_cast<float>(random() % 600);
            part.axes = static_cast<std::uint16_t>(random() % 3 * 0x5555);
            for (std::uint8_t& code : part.codes)
                code = static_cast<std::uint8_t>(random() >> 8);
            encode(part,
                   std::span<std::uint8_t, kBrickRayBytes>(row.data() + n * kBrickRayBytes, kBrickRayBytes));
        }
    }
    return rays;
}

void speed(int edge, int threads, int repeats) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(edge * kBrickExtent);
    info.type = ValueType::i16;
    info.patientFromVoxel = patientFromVoxelOf({0, 0, 0}, {0.3, 0, 0}, {0, 0.3, 0}, {0, 0, 0.5});
    const glm::ivec3 bricks(edge);
    std::vector<std::uint8_t> shows(cellCount(bricks));
    std::minstd_rand random(7);
    for (std::uint8_t& show : shows)
        show = random() % 100 < 55 ? 1 : 0;
    const BrickRays rays = inventedRays(bricks, shows);
    const TransferTable table =
        makeTable(presetFunction("soft-tissue", ValueSummary{-1000, 2000, true, 0.3, {}}));
    const std::vector<float> means(shows.size());
    std::vector<double> afterEdit, afterMove, view;
    for (int n = 0; n < repeats; ++n) {
        const auto edited = Clock::now();
        const LevelErrors errors = predictErrors(rays, shows, table, info, threads);
        const auto moved = Clock::now();
        Camera camera = fitCamera(info, View::anterior, Projection::perspective, {1024, 1024});
        camera.position = camera.focalPoint + (1.0 - 0.05 * n) * (camera.position - camera.focalPoint);
        const ViewWeights weights = viewWeights(camera, info, {1024, 1024}, threads, shows);
        view.push_back(msSince(moved));
        const Selection s = selectLevels(errors, weights, means, 8192, {}, threads);
        afterMove.push_back(msSince(moved));
        afterEdit.push_back(msSince(edited));
        if (n == 0)
            std::printf("# %zu bricks, %zu not empty, %zu of 8192 pages, levels %zu %zu %zu %zu %zu %zu, "
                        "rays %zu MB\n",
                        shows.size(), shown(shows), pagesOf(s), s.counts[0], s.counts[1], s.counts[2],
                        s.counts[3], s.counts[4], s.counts[5],
                        rays.pages.size() * rays.pages[0].size() / 1000000);
    }
    std::printf("what,threads,median ms,least ms,load\n");
    std::printf("select/camera,%d,%.1f,%.1f,%.2f\n", threads, median(afterMove), minimum(afterMove),
                loadAverage());
    std::printf("select/camera/weights,%d,%.1f,%.1f,%.2f\n", threads, median(view), minimum(view),
                loadAverage());
    std::printf("select/function,%d,%.1f,%.1f,%.2f\n", threads, median(afterEdit), minimum(afterEdit),
                loadAverage());
}

// -- hierarchy

void costRow(const char* what, const BlockGrid& grid, const SelectionCost& cost, const char* scheme) {
    std::printf("%s,%s", what, scheme);
    std::size_t blocks = 0;
    for (const LevelCost& level : cost.levels) {
        std::printf(",%zu/%zu", level.blocks, level.samples);
        blocks += level.blocks;
    }
    for (std::size_t level = cost.levels.size(); level < kLevelCount; ++level)
        std::printf(",");
    const auto ratio = [&](std::size_t samples) {
        return static_cast<double>(fullSamples(grid)) /
               static_cast<double>(std::max<std::size_t>(samples, 1));
    };
    std::printf(",%zu,%zu,%.2f,%zu,%.2f\n", blocks, cost.samples, ratio(cost.samples),
                cost.samples - cost.ignored, ratio(cost.samples - cost.ignored));
}
void costRows(const char* what, const BlockGrid& grid) {
    costRow(what, grid, hierarchyCost(grid, true), "hierarchy 1");
    costRow(what, grid, hierarchyCost(grid, false), "hierarchy 2");
    costRow(what, grid, flatCost(grid), "flat");
}

void hierarchy(const std::vector<std::string>& stores, int threads) {
    std::printf("what,scheme,level 0,level 1,level 2,level 3,level 4,level "
                "5,blocks,samples,reduction,samples without "
                "the outside,reduction without the outside\n");
    std::printf("# levels as the notes number them, 0 the coarsest: blocks/samples\n");
    costRows("table 2.1", table21Grid());
    // Other sizes and places of a round object.
    const std::array<std::array<double, 4>, 4> discs = {
        {{24, 26, 23, 19}, {26, 28, 22, 22}, {32, 32, 24, 24}, {30, 34, 18, 26}}}; // centre, half axes
    for (const auto& d : discs) {
        const BlockGrid grid = gridOfShape(2, {8, 8, 1}, 8, [&](const glm::ivec3& p) {
            const double x = (p.x + 0.5 - d[0]) / d[2], y = (p.y + 0.5 - d[1]) / d[3];
            return x * x + y * y < 1;
        });
        char name[64];
        std::snprintf(name, sizeof name, "ellipse %.0f:%.0f %.0fx%.0f", d[0], d[1], d[2], d[3]);
        costRows(name, grid);
    }
    for (const std::string& path : stores) {
        Budgets budgets;
        const StoreReader store(path, budgets.ram);
        const Statistics statistics = loadStatistics(store, budgets.ram, threads);
        for (const NamedFunction& f : functionsFor(summarise(statistics, store.info()))) {
            // Outside: shows nothing. Interior: no point of the function's opacity lies within the brick's
            // range, so that what it shows varies along one straight piece at most. Boundary: all others.
            const TransferTable table = makeTable(f.function);
            const Selection culled = cullBricks(statistics, table, store.info(), 0, Culling::unlit);
            BlockGrid grid{3, culled.bricks, kBrickExtent, {}};
            for (std::size_t brick = 0; brick < culled.levels.size(); ++brick) {
                const double a = store.info().rescaleSlope * static_cast<double>(statistics.brickMin[brick]) +
                                 store.info().rescaleIntercept;
                const double b = store.info().rescaleSlope * static_cast<double>(statistics.brickMax[brick]) +
                                 store.info().rescaleIntercept;
                const auto& points = f.function.opacityPoints();
                const bool crossed = std::any_of(points.begin(), points.end(), [&](const OpacityPoint& p) {
                    return p.value > std::min(a, b) && p.value < std::max(a, b);
                });
                grid.needs.push_back(culled.levels[brick] == Selection::kEmpty ? Need::outside
                                     : crossed                                 ? Need::boundary
                                                                               : Need::interior);
            }
            costRows((std::filesystem::path(path).stem().string() + " " + f.name).c_str(), grid);
        }
    }
}

void run(int argc, char** argv) {
    const auto options = parseOptions(argc, argv,
                                      {{"--mode", "speed"},
                                       {"--stores", ""},
                                       {"--bricks", "64"},
                                       {"--threads", "2"},
                                       {"--repeats", "9"},
                                       {"--parts", "2"},
                                       {"--size", "256"},
                                       {"--shading", "0"},
                                       {"--reductions", "6,20,80"}});
    const std::string& mode = options.at("--mode");
    const auto number = [&](const char* name) {
        return static_cast<int>(parseNumbers(options.at(std::string("--") + name), name).front());
    };
    const int threads = number("threads");
    if (mode == "speed")
        speed(number("bricks"), threads, number("repeats"));
    else if (mode == "prediction")
        prediction(split(options.at("--stores")), std::clamp(number("parts"), 1, kBrickRayParts), threads);
    else if (mode == "choice")
        choice(split(options.at("--stores")), number("size"),
               parseNumbers(options.at("--reductions"), "--reductions"), options.at("--shading") == "1",
               threads);
    else if (mode == "hierarchy")
        hierarchy(options.at("--stores").empty() ? std::vector<std::string>{} : split(options.at("--stores")),
                  threads);
    else
        throw badFile("--mode", "prediction, choice, speed or hierarchy", "\"" + mode + "\"");
}

} // namespace
} // namespace tessera::bench

int main(int argc, char** argv) {
    return tessera::bench::runMain("selection_bench", tessera::bench::run, argc, argv);
}
