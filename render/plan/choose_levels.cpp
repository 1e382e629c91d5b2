// render/plan/choose_levels.cpp: see choose_levels.h.
#include "render/plan/choose_levels.h"

#include "bricking/levels/level_chooser.h"
#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "render/parts/process_group.h"
#include "render/plan/frame_plan.h"
#include "render/plan/quick_level.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

namespace tessera {
namespace {

OverBudget belowFloor(const MemoryBudget& gpu, std::size_t floorBytes, const char* what) {
    return OverBudget(gpu.option() + ": this scene needs at least " + formatBytes(floorBytes) + " (" + what +
                      "), but " + formatBytes(gpu.freeBytes()) + " are free");
}

/// Share of the error bound for levels; steps get the rest.
constexpr double kShareOfLevels = 0.5;

/// Extra pages that one level for all may take over a sufficient mix: a mix is drawn more slowly, but pages
/// take time to load (docs/measurements/performance.md). As a share of the mix's pages, which loads quickly;
/// and one per this number of rays through bricks, for the gain.
constexpr std::size_t kShareForSpeed = 4, kRaysForPage = 100;
/// The cost of a stride of a mix, in strides of one level: 2.5 to 3.3 on the CPU. There are more of them than
/// stridesOfRays() counts, because they are short beside finer bricks.
constexpr double kMixedStride = 4;

/// Strides of rays through bricks where they are visible, in strides through a brick of level 0. A ray counts
/// for every such brick, and half as much per level.
double stridesOfRays(const Selection& s, const ViewWeights& weights, Visibility visible) {
    double strides = 0;
    for (std::size_t brick = 0; brick < s.levels.size(); ++brick)
        if (s.levels[brick] != Selection::kEmpty)
            strides += std::ldexp(static_cast<double>(weights.area[brick]), -s.levels[brick]) *
                       (visible.empty() ? 1 : static_cast<double>(visible[brick]));
    return strides;
}

/// Gives every non-empty brick one level.
void setLevels(Selection& s, int level) {
    for (std::uint8_t& mine : s.levels)
        if (mine != Selection::kEmpty) {
            --s.counts[mine];
            mine = static_cast<std::uint8_t>(level);
            ++s.counts[mine];
        }
}

/// Number of levels finer than a pixel that the mean of its samples still shows: a level averages values, a
/// pixel averages colours. With two of them levels cost 0.07 to 0.3 (L*u*v*, 99th percentile; pictures of 48
/// to 320 pixels, three scans). With one they cost 1.9 to 2.8, with none 4.5 to 8.9.
constexpr int kLevelsWithinPixels = 2;

/// View weights reach half a brick, 16 voxels: the reach of a gradient with its samples at this level.
constexpr int kCoarsestWithinReach = 2;

/// Returns how many bricks were left out.
std::size_t leaveOutUnseen(Selection& s, const ViewWeights& weights) {
    std::size_t unseen = 0;
    for (std::size_t brick = 0; brick < s.levels.size(); ++brick) {
        std::uint8_t& level = s.levels[brick];
        if (level == Selection::kEmpty || weights.area[brick] > 0)
            continue;
        --s.counts[level];
        level = Selection::kEmpty;
        ++unseen;
    }
    s.counts[Selection::kEmpty] += unseen;
    return unseen;
}

/// One level for all in place of a mix without finer ones, if it fits the pages and loading costs no more
/// than drawing gains.
std::optional<Selection> oneForMix(const Selection& mix, int level, const ViewWeights& weights,
                                   std::size_t pages, Visibility visible) {
    Selection one = mix;
    setLevels(one, level);
    const double strides = stridesOfRays(one, weights, visible);
    if (strides > kMixedStride * stridesOfRays(mix, weights, visible))
        return std::nullopt;
    const std::size_t mixed = pagesFor(mix.counts);
    const std::size_t forSpeed = static_cast<std::size_t>(std::ldexp(strides, level)) / kRaysForPage;
    if (pagesFor(one.counts) > std::min(pages, mixed + std::max(mixed / kShareForSpeed, forSpeed)))
        return std::nullopt;
    return one;
}

} // namespace

int quickLevel(const glm::ivec3& extentVoxels) {
    int level = 0;
    while (level + 1 < kLevelCount &&
           glm::any(glm::greaterThan(levelExtent(extentVoxels, level), glm::ivec3(128))))
        ++level;
    return level;
}

Unseen unseenBy(const Lighting& lighting, const Shading& shading, bool reflects) {
    return lighting.surfaceOcclusion || lighting.transport || reflects || reachOf(shading.gradient) > 1
               ? Unseen::kept
               : Unseen::leftOut;
}

BestLevels bestLevels(const LevelChooser& chooser, std::span<const float> means, std::size_t pages,
                      Visibility visible, Unseen unseen) {
    BestLevels best{chooser.best(means, pages, visible), {}, 0};
    Selection& s = best.selection;
    best.error = chooser.predict(s, visible);
    if (best.error.mean > 0 || s.uniform())
        return best;
    const int finest = s.finest();
    if (unseen == Unseen::leftOut && finest <= kCoarsestWithinReach)
        best.unseenBricks = leaveOutUnseen(s, chooser.weights());
    if (s.uniform())
        return best;
    if (std::optional<Selection> one = oneForMix(s, finest, chooser.weights(), pages, visible))
        s = std::move(*one);
    return best;
}

namespace {

/// HU. Scans have air down to here.
constexpr double kLeastOfAir = -1100;

/// For planes, means of rays and radiographs: the finest level that a pixel can show of any brick. The
/// maximum of averaged values is not the maximum, so other modes take the finest level.
/// @param lowest  physical value; a radiograph takes those below air for air, which means hide
int finestForValues(const Scene& scene, const ViewWeights& weights, double lowest) {
    const bool plane = scene.mode == Mode::slice && !(scene.slice.thicknessMm > 0);
    const bool linear = plane || reductionOf(scene) == Reduction::average ||
                        (scene.mode == Mode::radiograph && lowest >= kLeastOfAir);
    if (!linear || scene.quality.maxError.value_or(0) > 0)
        return 0;
    int finest = kLevelCount - 1;
    for (std::size_t brick = 0; brick < weights.area.size(); ++brick)
        if (weights.area[brick] > 0)
            finest = std::min<int>(finest, weights.finest[brick]);
    return std::max(0, finest - (scene.quality.pixels.samples != 1 ? kLevelsWithinPixels : 0));
}

/// The finest levels of which every process has its bricks in so many pages.
/// @param best  of so many pages for all
template <typename Best> BestLevels bestTogether(const Best& best, int processes, std::size_t pages) {
    for (std::size_t all = pages * static_cast<std::size_t>(processes);;) {
        BestLevels found = best(all);
        const PartTree parts(found.selection, processes);
        std::size_t most = 0;
        for (int part = 0; part < processes; ++part)
            most = std::max(most,
                            pagesFor(countsOf(parts.bricksAround(part, found.selection), found.selection)));
        if (most <= pages || all <= pages)
            return found;
        all = std::max(pages, all * pages / most);
    }
}

/// This process's part of a volume, and the pages for its bricks and those that rays may wait for.
void share(ProcessGroup& group, std::size_t pages, std::size_t waited, ChosenLevels& chosen) {
    const Selection& all = chosen.selection;
    chosen.shared = std::make_shared<const SharedVolume>(SharedVolume{group, PartTree(all, group.size())});
    const std::size_t mine = pagesFor(countsOf(chosen.shared->parts.bricksAround(group.rank(), all), all));
    chosen.atlasPages = std::max<std::size_t>(1, std::min({pages, pagesFor(all.counts), mine + waited}));
    chosen.chooser.reset(); // no process has all bricks, whose visibility would be counted
}

} // namespace

ChosenLevels chooseLevels(const Scene& scene, const Camera& camera, const DrawnPart& part, const Layer& layer,
                          const TextureLimits& limits, LevelChoice choice, std::size_t gpuFixed,
                          std::size_t ramKept, const FrameContext& context) {
    const Statistics& statistics = layer.statistics;
    const TransferTable& table = layer.table;
    const MemoryBudget& gpu = context.gpu;
    MemoryBudget& ram = context.ram;
    const int threads = context.threads;
    const VolumeInfo& info = layer.info();
    ChosenLevels chosen;
    const Culling culling = cullingFor(scene.shading);
    const bool takesGradients =
        scene.shading.on || !table.gradientOpacity.isOne() || scene.lighting.transport;
    const auto chooseOneForAll = [&] {
        const auto packed = [&](const auto& counts) {
            return atlasBytes(pagesFor(counts), info.type, limits);
        };
        chosen.selection = selectOneLevel(
            statistics, table, info, gpu.freeBytes(), packed,
            choice == LevelChoice::oneForAllNothingCulled ? Culling::none : culling, gpu.option(), gpuFixed,
            choice == LevelChoice::quick ? quickLevel(info.extentVoxels) : 0);
        chosen.unseenBricks =
            leaveOutUndrawn(chosen.selection, part, info, pitchesOfGradients(takesGradients, scene.shading));
        chosen.atlasPages = pagesFor(chosen.selection.counts);
        if (context.group)
            share(*context.group, chosen.atlasPages, chosen.atlasPages, chosen);
    };
    if (choice != LevelChoice::perBrick && choice != LevelChoice::finest) {
        chooseOneForAll();
        return chosen;
    }
    const std::size_t forBricks = gpu.freeBytes() - std::min(gpu.freeBytes(), gpuFixed);
    const std::size_t pages = pagesThatFit(forBricks, info.type, limits);
    // Fewer pages than the selection has: rays wait for bricks.
    const auto inPasses = [&] {
        const std::size_t wanted = pagesFor(chosen.selection.counts);
        // By default an integrator with values at ends is used only with room for far more pages than it
        // needs.
        const Integrator named = scene.quality.integrator;
        const bool takesEnds = named != Integrator::automatic && named != Integrator::midpoint;
        chosen.atlasPages = std::min(std::max<std::size_t>(1, wanted), pages);
        const std::size_t least = std::max<std::size_t>(
            1, std::min(wanted, neighbourhoodPages(takesGradients, takesEnds || !scene.surfaces.empty())));
        if (chosen.atlasPages < least)
            throw belowFloor(gpu, gpuFixed + atlasBytes(least, info.type, limits),
                             "picture, tables and the bricks around one sample");
    };
    const bool sums = reductionOf(scene) == Reduction::sum;
    if (reductionOf(scene) != Reduction::composite) {
        const Selection all = cullBricks(statistics, table, info, 0, culling);
        std::vector<std::uint8_t> shows(all.levels.size());
        for (std::size_t brick = 0; brick < shows.size(); ++brick)
            shows[brick] = all.levels[brick] != Selection::kEmpty;
        const ViewWeights weights = viewWeights(camera, info, scene.imageSize, threads, shows);
        const bool finest = choice == LevelChoice::finest;
        for (int level = finest ? 0 : finestForValues(scene, weights, summarise(statistics, info).lowest);
             level < kLevelCount; ++level) {
            chosen.selection = all;
            setLevels(chosen.selection, level);
            chosen.unseenBricks = leaveOutUndrawn(chosen.selection, part, info,
                                                  pitchesOfGradients(sums && takesGradients, scene.shading));
            if (level <= kCoarsestWithinReach)
                chosen.unseenBricks += leaveOutUnseen(chosen.selection, weights);
            chosen.atlasPages = pagesFor(chosen.selection.counts);
            if (finest || scene.quality.maxError) {
                inPasses();
                break;
            }
            if (chosen.atlasPages <= pages)
                break;
        }
        return chosen;
    }
    if (choice == LevelChoice::finest) {
        chosen.selection = cullBricks(statistics, table, info, 0, culling);
        chosen.unseenBricks =
            leaveOutUndrawn(chosen.selection, part, info, pitchesOfGradients(takesGradients, scene.shading));
        inPasses();
        return chosen;
    }
    if (pages == 0 && !scene.quality.maxError)
        throw belowFloor(gpu, gpuFixed + atlasBytes(1, info.type, limits),
                         "picture, tables and a page of bricks");

    const std::size_t shown = cullBricks(statistics, table, info, 0, culling).shownBricks();
    if (ram.freeBytes() < ramKept + LevelChooser::bytes(shown, cellCount(brickGrid(info.extentVoxels)))) {
        if (scene.quality.maxError)
            throw OverBudget(
                ram.option() + ": " + formatBytes(ram.limitBytes()) +
                " cannot hold the statistics that --max-error needs; give more, or leave it out");
        chooseOneForAll();
        return chosen;
    }
    auto chooser = std::make_unique<LevelChooser>(*layer.store, ram, threads, layer.masked.get());
    chooser->setFunction(statistics, table, culling);
    chooser->keepFunction();
    chooser->setCamera(camera, scene.imageSize);
    if (scene.quality.maxError.value_or(0) > 0)
        chooser->allowSubpixelLevels(kLevelCount);
    else if (scene.quality.pixels.samples != 1 && !scene.quality.maxError)
        chooser->allowSubpixelLevels(kLevelsWithinPixels);
    chosen.predicted = true;
    // With cuts, nothing counts as hidden, because cuts uncover bricks.
    const std::vector<float> visible = part.any() ? std::vector<float>() : chooser->predictedVisibility();
    if (scene.quality.maxError) {
        Selection& s = chosen.selection;
        s = chooser->within(statistics.brickMean, kShareOfLevels * *scene.quality.maxError);
        // More accurate, and faster. The number of pages does not matter for this picture.
        Selection mix = s;
        const bool leavesOut = unseenBy(scene.lighting, scene.shading, reflects(scene)) == Unseen::leftOut &&
                               s.finest() <= kCoarsestWithinReach;
        const std::size_t unseen = leavesOut ? leaveOutUnseen(mix, chooser->weights()) : 0;
        if (std::optional<Selection> one =
                oneForMix(mix, s.finest(), chooser->weights(), SIZE_MAX, visible)) {
            s = std::move(*one);
            chosen.unseenBricks = unseen;
        }
        chosen.error = chooser->predict(s);
        chosen.unseenBricks +=
            leaveOutUndrawn(s, part, info, pitchesOfGradients(takesGradients, scene.shading));
        inPasses();
    } else {
        // Hidden bricks must not take memory from visible ones.
        const auto bestOf = [&](std::size_t most) {
            BestLevels best = bestLevels(*chooser, statistics.brickMean, most, visible,
                                         unseenBy(scene.lighting, scene.shading, reflects(scene)));
            best.unseenBricks += leaveOutUndrawn(best.selection, part, info,
                                                 pitchesOfGradients(takesGradients, scene.shading));
            return best;
        };
        BestLevels best = context.group ? bestTogether(bestOf, context.group->size(), pages) : bestOf(pages);
        chosen.selection = std::move(best.selection);
        chosen.error = best.error;
        chosen.unseenBricks = best.unseenBricks;
        if (context.group) {
            inPasses();
            share(*context.group, pages, neighbourhoodPages(takesGradients, true), chosen);
            return chosen;
        }
        chosen.atlasPages = pagesFor(chosen.selection.counts);
        if (chosen.error.mean > 0 && !part.any()) { // memory is scarce: better visibility pays
            chosen.atlasPages = pages;
            chosen.chooser = std::move(chooser);
        }
    }
    return chosen;
}

} // namespace tessera
