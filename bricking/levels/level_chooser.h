// bricking/levels/level_chooser.h: levels from a store, a transfer function and a camera. Steps are: read
// statistics, predict errors, weigh the view; each runs again only if its inputs have changed.
#pragma once

#include "bricking/levels/level_selection.h"
#include "bricking/statistics/brick_rays.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/scene/camera.h"

#include <span>
#include <vector>

namespace tessera {

class LevelChooser {
  public:
    /// store must outlive this.
    /// @param threads  0: all processors
    /// @param masked   what is drawn in place of the store, or null; outlives this as well
    LevelChooser(const StoreReader& store, MemoryBudget& ram, int threads,
                 const MaskedSource* masked = nullptr);

    /// Upper bound on memory for so many non-empty bricks of all, before and after the sampled rays are
    /// released.
    static std::size_t bytes(std::size_t shownBricks, std::size_t bricks);

    /// Predicts errors under a function. Must be called first. Reads missing rays.
    void setFunction(const Statistics& statistics, const TransferTable& table, Culling culling);
    /// Releases the sampled rays; no other function may follow.
    void keepFunction();
    /// Sets the view; after the function, and again after each new function.
    void setCamera(const Camera& camera, const glm::ivec2& imageSize);
    /// Number of levels finer than a pixel that matter too: a pixel that is the mean of many samples shows
    /// them. Errors are against the finest of these. After the view.
    void allowSubpixelLevels(int levels);

    const std::vector<std::uint8_t>& shows() const { return errors_.shows; } // [z][y][x] over bricks
    const LevelErrors& errors() const { return errors_; }
    const ViewWeights& weights() const { return weights_; }
    /// Visibility of bricks, predicted from their rays.
    std::vector<float> predictedVisibility() const;

    /// The functions of level_selection.h.
    /// @param means  Statistics::brickMean
    Selection best(std::span<const float> means, std::size_t pages, Visibility visibility = {}) const;
    Selection within(std::span<const float> means, double maxError) const;
    PredictedError predict(const Selection& selection, Visibility visibility = {}) const;

  private:
    const StoreReader& store_;
    const MaskedSource* masked_;
    MemoryBudget& ram_;
    int threads_;
    BrickRays rays_;
    LevelErrors errors_;
    ViewWeights weights_;
    Camera camera_;
    glm::ivec2 imageSize_{0};
    Charge charge_;
};

} // namespace tessera
