// bricking/levels/level_selection.h: the pure function (predicted errors, view, visibility, budget) -> level
// or nothing, per brick: the flat multiresolution. Every brick has its own level, whatever its neighbours
// have. Empty bricks cost nothing. The others get pages such that the weighted sum of predicted errors falls
// fastest per byte. Source: course notes on advanced volume ray casting, sections 2.8.3 and 2.9.3.
//
// The cost of a brick: a page holds 32^3 texels and bricks of one level only, 8^level of them. At the
// coarsest level a brick is its mean and costs nothing. A selection costs the sum over levels of ceil(count /
// 8^level) pages. That sum of whole pages is kept within the budget.
#pragma once

#include "bricking/levels/level_error.h"
#include "bricking/levels/selection.h"
#include "bricking/levels/view_weight.h"
#include "core/base/brick.h"

#include <cstddef>
#include <span>

namespace tessera {

/// Bricks of a level per page.
constexpr std::size_t bricksPerPage(int level) {
    return std::size_t{1} << (3 * level);
}
/// Pages of a selection.
std::size_t pagesOf(const Selection& selection);

/// Visibility of bricks: a factor in [0,1] per brick, [z][y][x]. Empty: all 1.
using Visibility = std::span<const float>;

/// A pixel needs no finer samples than its own size while prefiltering only averages what the pixel would
/// average. If prefiltering shifts the mean colour of a brick noticeably (more than 2 in L*u*v*), thin
/// structures vanish or thicken. There weights.finest is lowered to the level that keeps them.
void limitPrefilterLoss(const LevelErrors& errors, ViewWeights& weights);

/// The best selection of at most `pages` pages: greedy on the lower convex hull of each brick's weighted
/// error against its share of a page. Free slots of allocated pages are then filled. No brick is finer than a
/// pixel can show; bricks without weight are drawn as their means. Deterministic; the same for any number of
/// threads; linear in the number of bricks.
/// @param means  Statistics::brickMean
Selection selectLevels(const LevelErrors& errors, const ViewWeights& weights, std::span<const float> means,
                       std::size_t pages, Visibility visibility = {}, int threads = 0);

/// Upper bound on the memory of selectLevels() with its result.
std::size_t selectLevelsBytes(std::size_t bricks);

/// A cheap selection whose predicted error (PredictedError::p99) is at most maxError, in L*u*v* units, at
/// least 0. Every visible brick takes the coarsest level whose mean error is within one limit. The limit is
/// the largest for which the whole meets maxError. With maxError 0, every visible brick has the finest level
/// that a pixel can show.
Selection selectForError(const LevelErrors& errors, const ViewWeights& weights, std::span<const float> means,
                         double maxError, Visibility visibility = {});

/// All visible bricks at one level, the finest that fits (the baseline of
/// docs/measurements/level-of-detail.md); independent of the view.
Selection selectUniform(const LevelErrors& errors, std::span<const float> means, std::size_t pages);

/// Predicted error of a selection, in L*u*v* units, against the finest level that a pixel can show. In the
/// model, visible bricks share the picture by area times visibility. The errors of a brick's pixels have an
/// exponential distribution around its mean, which has no free constant and suits errors with many small
/// causes. The model ignores that several bricks share a pixel. Errors of translucent bricks add up. Without
/// known visibility all but the first brick count too much.
struct PredictedError {
    double mean = 0, p99 = 0;
};
PredictedError predictError(const Selection& selection, const LevelErrors& errors, const ViewWeights& weights,
                            Visibility visibility = {});

} // namespace tessera
