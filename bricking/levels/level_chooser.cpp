// bricking/levels/level_chooser.cpp: see level_chooser.h.
#include "bricking/levels/level_chooser.h"

#include "bricking/levels/visibility.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

/// Memory of prediction and choice, besides the rays: errors, view weights, and scratch.
std::size_t predictionBytes(std::size_t bricks) {
    return predictErrorsBytes(bricks) + selectLevelsBytes(bricks) +
           bricks * (4 * sizeof(float) + sizeof(std::uint8_t)); // view weights, visibility and its sums
}

} // namespace

LevelChooser::LevelChooser(const StoreReader& store, MemoryBudget& ram, int threads,
                           const MaskedSource* masked)
    : store_(store), masked_(masked), ram_(ram), threads_(threads),
      rays_(noBrickRays(store.info(), kBrickRayParts, ram)),
      charge_(ram.charge(predictionBytes(rays_.rowOf.size()), "the prediction of errors")) {}

std::size_t LevelChooser::bytes(std::size_t shownBricks, std::size_t bricks) {
    constexpr std::size_t kReading = std::size_t{12} << 20; // parts of the statistics on their way
    return kReading + (shownBricks + BrickRays::kRowsPerPage) * kBrickRayParts * kBrickRayBytes +
           bricks * (sizeof(std::uint32_t) + 1) + predictionBytes(bricks);
}

void LevelChooser::setFunction(const Statistics& statistics, const TransferTable& table, Culling culling) {
    const Selection culled = cullBricks(statistics, table, store_.info(), 0, culling);
    std::vector<std::uint8_t> shows(culled.levels.size());
    std::transform(culled.levels.begin(), culled.levels.end(), shows.begin(),
                   [](std::uint8_t level) { return level == Selection::kEmpty ? 0 : 1; });
    addBrickRays(store_, shows, rays_, ram_, threads_, masked_);
    errors_ = {};
    if (table.surfaces.empty()) {
        errors_ = predictErrors(rays_, std::move(shows), table, store_.info(), threads_);
        return;
    }
    const glm::dvec3 spacing = store_.info().spacingMm();
    const double voxelMm = std::cbrt(spacing.x * spacing.y * spacing.z);
    errors_ =
        predictErrors(rays_, std::move(shows), table.withSurfacesAsSteps(voxelMm), store_.info(), threads_);
}

void LevelChooser::keepFunction() {
    rays_ = {};
}

void LevelChooser::setCamera(const Camera& camera, const glm::ivec2& imageSize) {
    camera_ = camera;
    imageSize_ = imageSize;
    weights_ = viewWeights(camera, store_.info(), imageSize, threads_, errors_.shows);
    limitPrefilterLoss(errors_, weights_);
}

void LevelChooser::allowSubpixelLevels(int levels) {
    for (std::size_t brick = 0; brick < weights_.finest.size(); ++brick)
        if (weights_.area[brick] > 0)
            weights_.finest[brick] = static_cast<std::uint8_t>(std::max(0, weights_.finest[brick] - levels));
}

std::vector<float> LevelChooser::predictedVisibility() const {
    return predictVisibility(errors_, camera_, store_.info(), imageSize_, threads_);
}

Selection LevelChooser::best(std::span<const float> means, std::size_t pages, Visibility visibility) const {
    return selectLevels(errors_, weights_, means, pages, visibility, threads_);
}

Selection LevelChooser::within(std::span<const float> means, double maxError) const {
    return selectForError(errors_, weights_, means, maxError);
}

PredictedError LevelChooser::predict(const Selection& selection, Visibility visibility) const {
    return predictError(selection, errors_, weights_, visibility);
}

} // namespace tessera
