// bricking/visibility.h: what the last frame saw of each brick, as a factor for the next selection that does
// not flicker. For the interactive path; pictures that must depend on their scene alone start from all
// visible (level_selection.h) and take a fixed number of passes without memory.
#pragma once

#include "bricking/level_selection.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// A hidden brick keeps this much: the frame in which it appears then has at least something coarse of it.
constexpr float kHiddenVisibility = 1.0f / 64;

/// Factors in [kHiddenVisibility, 1] per brick, [z][y][x], for selectLevels().
/// The fraction of a brick that is seen is counts / (countPerPixel * area), at most 1.
/// - A factor moves only when the fraction is more than twice or less than half the last one; counts that
///   jitter leave the selection as it is.
/// - It rises at once. It falls by half a call while the last selection holds samples of the brick, so that
///   what is uncovered a moment later is still there, and at once where there is nothing to lose.
/// @param counts  integers, so that their sum does not depend on the order of pixels
/// @param countPerPixel  what a pixel adds that sees the brick wholly, at least 1
/// @param last  the last result, or nothing: factors then follow the fractions at once
std::vector<float> visibilityFactors(std::span<const std::uint32_t> counts, std::uint32_t countPerPixel,
                                     const ViewWeights& weights, const Selection& selection,
                                     Visibility last = {});

} // namespace tessera
