// bricking/levels/level_selection.h: the pure function (predicted errors, view, visibility, budget) -> level
// or nothing, per brick: the flat multiresolution. Every brick has its own level, whatever its neighbours
// have. Empty bricks cost nothing. The others share the pages so that the weighted sum of predicted errors
// falls fastest per byte. Source: course notes on advanced volume ray casting, sections 2.8.3 and 2.9.3.
//
// The cost of a brick: a page holds 32^3 texels and bricks of one level only, 8^level of them. At the
// coarsest level a brick is its mean and costs nothing. A selection costs the sum over levels of ceil(count /
// 8^level) pages. That sum, and not its fractions, is kept within the budget.
#pragma once

#include "bricking/levels/level_error.h"
#include "bricking/levels/selection.h"
#include "bricking/levels/view_weight.h"
#include "core/base/brick.h"

#include <cstddef>
#include <span>

namespace tessera {

/// Bricks of a level that one page holds.
constexpr std::size_t bricksPerPage(int level) {
    return std::size_t{1} << (3 * level);
}
/// Pages that a selection takes.
std::size_t pagesOf(const Selection& selection);

/// How visible bricks are: a factor in [0,1] per brick, [z][y][x]. Nothing: all of them wholly.
using Visibility = std::span<const float>;

/// A pixel needs no finer samples than its own size, as long as filtering before the transfer function only
/// averages what the pixel would average. Where it shifts the mean colour of a brick noticeably (more than 2
/// in L*u*v*), thin things vanish or thicken: there weights.finest goes down to the level that keeps them.
void limitPrefilterLoss(const LevelErrors& errors, ViewWeights& weights);

/// The best selection of at most `pages` pages: greedy on the lower convex hull of each brick's weighted
/// error against its share of a page. Free slots of pages that are paid for are then filled. No brick is
/// finer than a pixel can show; bricks of no weight stand as their means. Deterministic; the same for any
/// number of threads; linear in the number of bricks.
/// @param means  Statistics::brickMean
Selection selectLevels(const LevelErrors& errors, const ViewWeights& weights, std::span<const float> means,
                       std::size_t pages, Visibility visibility = {}, int threads = 0);

/// Memory that selectLevels() takes at most, its result included.
std::size_t selectLevelsBytes(std::size_t bricks);

/// A cheap selection whose predicted error (PredictedError::p99) is at most maxError, in L*u*v* units, at
/// least 0. Every visible brick takes the coarsest level whose mean error is within one limit. The limit is
/// the largest with which the whole meets maxError. With maxError 0, every visible brick has the finest level
/// that a pixel can show.
Selection selectForError(const LevelErrors& errors, const ViewWeights& weights, std::span<const float> means,
                         double maxError, Visibility visibility = {});

/// All showing bricks at one level, the finest that fits (the comparison of
/// docs/measurements/level-of-detail.md, and the simplest thing that works); the view counts for nothing.
Selection selectUniform(const LevelErrors& errors, std::span<const float> means, std::size_t pages);

/// What a selection is predicted to cost the picture, in L*u*v* units, against the finest level that a pixel
/// can show. The model: what is seen is shared out among the visible bricks by area times visibility. The
/// errors of a brick's pixels are distributed exponentially around its mean. That has no constant to tune and
/// is what errors of many small causes look like. It leaves out that several bricks share a pixel. Their
/// errors add up where they are translucent. All but the first count too much while nothing is known of
/// visibility.
struct PredictedError {
    double mean = 0, p99 = 0;
};
PredictedError predictError(const Selection& selection, const LevelErrors& errors, const ViewWeights& weights,
                            Visibility visibility = {});

} // namespace tessera
