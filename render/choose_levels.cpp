// render/choose_levels.cpp: see choose_levels.h.
#include "render/choose_levels.h"

#include "bricking/predicted_visibility.h"
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

/// The finest level of at most 256 samples along every axis.
int quickLevel(const glm::ivec3& extentVoxels) {
    int level = 0;
    while (level + 1 < kLevelCount &&
           glm::any(glm::greaterThan(levelExtent(extentVoxels, level), glm::ivec3(256))))
        ++level;
    return level;
}

/// What predicting and choosing hold at once, besides the rays: errors, view weights, and their scratch.
std::size_t predictionBytes(std::size_t bricks) {
    return predictErrorsBytes(bricks) + selectLevelsBytes(bricks) +
           bricks * (4 * sizeof(float) + sizeof(std::uint8_t)); // view weights, visibility and its sums
}

/// Rays of the bricks that show something, where ram has room for them and for what is made of them.
std::optional<BrickRays> raysThatFit(const StoreReader& store, const std::vector<std::uint8_t>& shows,
                                     std::size_t shown, Ledger& ram, std::size_t kept, int threads) {
    constexpr std::size_t kReading = std::size_t{4} << 20; // parts of the statistics on their way
    const std::size_t bytes = (shown + BrickRays::kRowsPerPage) * kBrickRayParts * kBrickRayBytes +
                              shows.size() * (sizeof(std::uint32_t) + 1);
    if (ram.freeBytes() < kept + kReading + bytes + predictionBytes(shows.size()))
        return std::nullopt;
    BrickRays rays = noBrickRays(store.info(), kBrickRayParts, ram);
    addBrickRays(store, shows, rays, ram, threads);
    return rays;
}

} // namespace

ChosenLevels chooseLevels(const Scene& scene, const Camera& camera, const Statistics& statistics,
                          const TransferTable& table, const StoreReader& store, const TextureLimits& limits,
                          LevelChoice choice, const Ledger& gpu, std::size_t gpuFixed, Ledger& ram,
                          std::size_t ramKept, int threads) {
    const VolumeInfo& info = store.info();
    ChosenLevels chosen;
    const auto oneForAll = [&] {
        const auto packed = [&](const auto& counts) {
            return atlasBytes(pagesFor(counts), info.type, limits);
        };
        chosen.selection = selectOneLevel(
            statistics, table, info, gpu.freeBytes(), packed, choice != LevelChoice::oneForAllNothingCulled,
            gpu.option(), gpuFixed, choice == LevelChoice::quick ? quickLevel(info.extentVoxels) : 0);
        chosen.atlasPages = pagesFor(chosen.selection.counts);
        return chosen;
    };
    if (choice != LevelChoice::perBrick)
        return oneForAll();
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
    if (!rays) {
        if (scene.quality.maxError)
            throw InputError(
                ram.option() + ": " + formatBytes(ram.limitBytes()) +
                " cannot hold the statistics that --max-error needs; give more, or leave it out");
        return oneForAll();
    }
    const Charge charge = ram.charge(predictionBytes(shows.size()), "the prediction of errors");
    const LevelErrors errors = predictErrors(*rays, std::move(shows), table, info, threads);
    rays.reset();
    ViewWeights weights = viewWeights(camera, info, scene.imageSize, threads, errors.shows);
    keepWhatFilteringLoses(errors, weights);
    chosen.predicted = true;
    if (scene.quality.maxError) {
        chosen.selection = selectForError(errors, weights, statistics.brickMean, *scene.quality.maxError, {});
        const std::size_t wanted = pagesFor(chosen.selection.counts);
        chosen.error = predictError(chosen.selection, errors, weights);
        chosen.atlasPages = std::min(std::max<std::size_t>(1, wanted), pages);
        const std::size_t least =
            std::max<std::size_t>(1, std::min(wanted, neighbourhoodPages(scene.shading.on)));
        if (chosen.atlasPages < least)
            throw belowFloor(gpu, gpuFixed + atlasBytes(least, info.type, limits),
                             "picture, tables and the bricks around one sample");
    } else {
        // What is hidden needs no memory that what is seen could have.
        const std::vector<float> visible = predictVisibility(errors, camera, info, scene.imageSize, threads);
        chosen.selection = selectLevels(errors, weights, statistics.brickMean, pages, visible, threads);
        chosen.error = predictError(chosen.selection, errors, weights, visible);
        chosen.atlasPages = pagesFor(chosen.selection.counts);
    }
    return chosen;
}

} // namespace tessera
