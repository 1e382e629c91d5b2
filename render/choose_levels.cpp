// render/choose_levels.cpp: see choose_levels.h.
#include "render/choose_levels.h"

#include "bricking/ray_statistics.h"
#include "core/error.h"

#include <algorithm>
#include <optional>

namespace tessera {
namespace {

/// Most pages whose box of a texture fits; 0: not even one.
std::size_t pagesThatFit(std::size_t bytes, ValueType type, const TextureLimits& limits) {
    std::size_t pages = std::min(bytes, limits.maxBytes) / atlasBytes(1, type, TextureLimits{});
    while (pages > 0 && atlasBytes(pages, type, limits) > bytes)
        --pages;
    return pages;
}

InputError belowFloor(const Ledger& gpu, std::size_t floorBytes, const char* what) {
    return InputError(gpu.option() + ": this scene needs at least " + formatBytes(floorBytes) + " (" + what +
                      "), but " + formatBytes(gpu.freeBytes()) + " are free");
}

/// What predicting holds at once, besides the rays: errors and view weights.
std::size_t predictionBytes(std::size_t bricks) {
    return bricks * (2 * kLevelCount * sizeof(float) + sizeof(float) + 3);
}

/// Rays of the bricks that show something, both parts where ram has room for them, else one; or nothing.
std::optional<BrickRays> raysThatFit(const StoreReader& store, const std::vector<std::uint8_t>& shows,
                                     std::size_t shown, Ledger& ram, std::size_t kept, int threads) {
    for (int parts = kBrickRayParts; parts > 0; --parts) {
        const std::size_t bytes = shown * static_cast<std::size_t>(parts) * kBrickRayBytes +
                                  shows.size() * (sizeof(std::uint32_t) + 1) +
                                  BrickRays::kRowsPerPage * kBrickRayParts * kBrickRayBytes;
        const std::size_t reading = statisticsFloorBytes(store.info(), threads); // chunks on their way
        if (ram.freeBytes() < kept + reading + bytes + predictionBytes(shows.size()))
            continue;
        BrickRays rays = noBrickRays(store.info(), parts, ram);
        addBrickRays(store, shows, rays, ram, threads);
        return rays;
    }
    return std::nullopt;
}

} // namespace

ChosenLevels chooseLevels(const Scene& scene, const Camera& camera, const Statistics& statistics,
                          const TransferTable& table, const StoreReader& store, const TextureLimits& limits,
                          LevelChoice choice, const Ledger& gpu, std::size_t gpuFixed, Ledger& ram,
                          std::size_t ramKept, int threads) {
    const VolumeInfo& info = store.info();
    ChosenLevels chosen;
    if (choice != LevelChoice::perBrick) {
        const auto packed = [&](const auto& counts) {
            return atlasBytes(pagesFor(counts), info.type, limits);
        };
        chosen.selection = selectOneLevel(statistics, table, info, gpu.freeBytes(), packed,
                                          choice == LevelChoice::oneForAll, gpu.option(), gpuFixed);
        chosen.atlasPages = pagesFor(chosen.selection.counts);
        return chosen;
    }
    const std::size_t forBricks = gpu.freeBytes() - std::min(gpu.freeBytes(), gpuFixed);
    const std::size_t pages = pagesThatFit(forBricks, info.type, limits);
    if (pages == 0 && !scene.quality.maxError)
        throw belowFloor(gpu, gpuFixed + atlasBytes(1, info.type, limits),
                         "picture, tables and a page of bricks");

    chosen.selection = cullBricks(statistics, table, info, 0, true);
    const std::size_t shown = chosen.selection.shownBricks();
    std::vector<std::uint8_t> shows(chosen.selection.levels.size());
    std::transform(chosen.selection.levels.begin(), chosen.selection.levels.end(), shows.begin(),
                   [](std::uint8_t level) { return level == Selection::kEmpty ? 0 : 1; });
    std::optional<BrickRays> rays = raysThatFit(store, shows, shown, ram, ramKept, threads);
    const Charge charge = ram.charge(rays ? predictionBytes(shows.size()) : 0, "the prediction of errors");
    LevelErrors errors;
    ViewWeights weights;
    if (rays) {
        errors = predictErrors(*rays, std::move(shows), table, info, threads);
        rays.reset();
        weights = viewWeights(camera, info, scene.imageSize, threads);
        keepWhatFilteringLoses(errors, weights);
    } else {
        errors.bricks = chosen.selection.bricks;
        errors.shows = std::move(shows);
    }
    if (scene.quality.maxError && !errors.errors.empty()) {
        chosen.selection = selectForError(errors, weights, statistics.brickMean, *scene.quality.maxError, {});
        const std::size_t wanted = pagesFor(chosen.selection.counts);
        chosen.atlasPages = std::min(std::max<std::size_t>(1, wanted), pages);
        const std::size_t least =
            std::max<std::size_t>(1, std::min(wanted, neighbourhoodPages(scene.shading.on)));
        if (chosen.atlasPages < least)
            throw belowFloor(gpu, gpuFixed + atlasBytes(least, info.type, limits),
                             "picture, tables and the bricks around one sample");
    } else if (!errors.errors.empty()) {
        chosen.selection = selectLevels(errors, weights, statistics.brickMean, pages, {}, threads);
        chosen.atlasPages = pagesFor(chosen.selection.counts);
    } else {
        if (scene.quality.maxError)
            throw InputError(
                ram.option() + ": " + formatBytes(ram.limitBytes()) +
                " cannot hold the statistics that --max-error needs; give more, or leave it out");
        chosen.selection = selectUniform(errors, statistics.brickMean, pages);
        chosen.atlasPages = pagesFor(chosen.selection.counts);
    }
    chosen.predicted = !errors.errors.empty();
    if (chosen.predicted)
        chosen.error = predictError(chosen.selection, errors, weights);
    return chosen;
}

} // namespace tessera
