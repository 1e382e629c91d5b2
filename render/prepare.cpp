// render/prepare.cpp: see prepare.h.
#include "render/prepare.h"

#include "core/error.h"
#include "core/threads.h"
#include "render/lattice.h"
#include "render/march.h" // March::stateBytes

#include <algorithm>

namespace tessera {

ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info) {
    ValueSummary summary;
    const double a = info.rescaleSlope * static_cast<double>(statistics.lowest) + info.rescaleIntercept;
    const double b = info.rescaleSlope * static_cast<double>(statistics.highest) + info.rescaleIntercept;
    summary.lowest = std::min(a, b);
    summary.highest = std::max(a, b);
    summary.isHu = info.unit == "HU";
    for (const std::uint64_t count : statistics.histogram)
        summary.histogram.push_back(static_cast<double>(count));
    if (info.rescaleSlope < 0) std::reverse(summary.histogram.begin(), summary.histogram.end());
    return summary;
}

PreparedScene prepareScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                           Ledger& ram, const Ledger& gpu, int threads, bool culling) {
    PreparedScene p;
    p.store = &store;
    const VolumeInfo& info = store.info();
    p.imageSize = scene.imageSize;
    p.imageCharge = ram.charge(2 * sizeof(glm::vec4) * static_cast<std::size_t>(scene.imageSize.x) *
                                   static_cast<std::size_t>(scene.imageSize.y),
                               "the picture");
    p.statistics = loadStatistics(store, ram, threads);
    const TransferChoice& choice = scene.volumes.at(0).transferFunction;
    if (const auto* name = std::get_if<std::string>(&choice))
        p.function = presetFunction(*name, summarise(p.statistics, info));
    else
        p.function = std::get<TransferFunction>(choice);
    p.table = makeTable(p.function);
    p.optics = makeOptics(p.table, info, scene.shading, scene.quality.terminationTransmittance);
    if (const auto* view = std::get_if<FittedView>(&scene.camera))
        p.camera = fitCamera(info, view->view, view->projection, scene.imageSize);
    else
        p.camera = std::get<Camera>(scene.camera);

    // GPU memory: what every level costs first, then as fine a level as the rest holds.
    const std::size_t fixed = March::stateBytes(scene.imageSize) + Atlas::indexBytes(brickGrid(info.extentVoxels)) +
                              p.optics.table.size() * sizeof(glm::vec4) +
                              (scene.quality.skipping ? cellCount(cellGrid(info.extentVoxels)) : 0);
    const auto packed = [&](std::size_t bricks, int level) {
        return atlasBytes(bricks, level, info.type, limits);
    };
    if (gpu.freeBytes() < fixed)
        throw InputError(gpu.option() + ": this scene needs at least " +
                         formatBytes(fixed + packed(1, kLevelCount - 1)) + " (picture, index and tables, one page of bricks), but the budget is " +
                         formatBytes(gpu.limitBytes()));
    p.selection = selectOneLevel(p.statistics, p.table, info, gpu.freeBytes() - fixed, packed, culling, gpu.option(), fixed);
    if (scene.quality.skipping)
        p.occupancy = makeOccupancy(p.statistics, p.table, info, p.selection, ram);
    p.frame = rayFrame(p.camera, info, scene.imageSize,
                       scene.quality.stepVoxels * static_cast<double>(1 << p.selection.level));

    // The cache takes what is left, less room for shard indices and upload staging.
    const int cacheThreads = threads > 0 ? threads : defaultThreads();
    const std::size_t spare = ram.freeBytes() / 8 + (std::size_t{1} << 20);
    // Every CPU renderer's thread pins the chunks of one neighbourhood while the loaders need one each.
    const std::size_t floor =
        std::max(BrickCache::floorBytes(store, cacheThreads),
                 store.chunkBytes() * (LatticeReader::kPinnedChunks + 1) * static_cast<std::size_t>(cacheThreads));
    const std::size_t left = ram.freeBytes() > spare ? ram.freeBytes() - spare : 0;
    if (left < floor)
        throw InputError(ram.option() + ": this scene needs at least " +
                         formatBytes(ram.limitBytes() - left + floor) + ", but the budget is " +
                         formatBytes(ram.limitBytes()));
    p.cache = std::make_unique<BrickCache>(store, ram, left, cacheThreads);
    return p;
}

} // namespace tessera
