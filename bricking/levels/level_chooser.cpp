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

/// Errors of a brick all of whose cells hold borders of labels, per level. Measured (labels of 59 organs at
/// 3 mm, and 6 of a phantom; one level for all bricks against level 0): 17, 28, 40, 55, 80 times the share of
/// such cells, in the mean over pixels.
constexpr std::array<float, kLevelCount> kBorderErrors = {0, 17, 28, 40, 55, 80};
/// Of these what remains if a pixel averages them.
constexpr float kBorderBias = 0.3f;

/// Errors of what labels leave of the function, and of their borders.
void takeLabels(const std::vector<Statistics::LabelledBrick>& labels, LevelErrors& errors) {
    for (std::size_t b = 0; b < labels.size(); ++b) {
        if (errors.shows[b] == 0)
            continue;
        const Statistics::LabelledBrick& brick = labels[b];
        for (std::size_t level = 0; level < kBorderErrors.size(); ++level) {
            const float border = brick.borders * kBorderErrors[level];
            errors.errors[b][level] = brick.function * errors.errors[b][level] + border;
            errors.biases[b][level] = brick.function * errors.biases[b][level] + kBorderBias * border;
        }
        errors.transmittances[b] =
            std::pow(errors.transmittances[b], brick.function) * (1 - std::min(1.0f, brick.medium));
    }
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
    const glm::dvec3 spacing = store_.info().spacingMm();
    const double voxelMm = std::cbrt(spacing.x * spacing.y * spacing.z);
    errors_ = table.surfaces.empty()
                  ? predictErrors(rays_, std::move(shows), table, store_.info(), threads_)
                  : predictErrors(rays_, std::move(shows), table.withSurfacesAsSteps(voxelMm), store_.info(),
                                  threads_);
    takeLabels(statistics.labelledBricks, errors_);
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
