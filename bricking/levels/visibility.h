// bricking/levels/visibility.h: visibility measured by a picture, as a factor per brick for the next choice
// of levels. The factor does not flicker.
#pragma once

#include "bricking/levels/selection.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// What rays saw of a brick; whole numbers, so that their sum does not depend on the order of rays.
struct SeenBrick {
    static constexpr std::uint32_t kLightOfRay = 256;
    std::uint32_t light = 0; // sum over rays of what was left when they entered, in 1/kLightOfRay
    std::uint32_t rays = 0;  // that entered
};

/// A hidden brick keeps this much: the picture in which it appears then has at least something coarse of it.
constexpr float kHiddenVisibility = 1.0f / 64;

/// Factors in [kHiddenVisibility, 1] per brick, [z][y][x], for selectLevels(): the mean light that entered; 1
/// where no ray did.
/// With `last`, for pictures that follow one another:
/// - A factor moves only when the light is more than twice or less than half the last one; counts that
///   jitter leave the selection as it is.
/// - It rises at once. It falls by half a call while the last selection holds samples of the brick, so that
///   what is uncovered a moment later is still there, and at once where there is nothing to lose.
/// @param last  the last result, or nothing: factors then follow at once
std::vector<float> visibilityFactors(std::span<const SeenBrick> seen, const Selection& selection,
                                     std::span<const float> last = {});

} // namespace tessera
