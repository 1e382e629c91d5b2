// render/contract/gradient_numbers.h: gradient opacity as plain numbers, one text for all engines. Packets
// include it, so it brings no functions.
#pragma once

#include <cstdint>

namespace tessera::leaf {

constexpr int kMostGradientPoints = 16;

/// Points of the factor, by the length of the gradient in patient space, stored units per mm. From a point on
/// the factor goes on by its slope, until the next one; before the first it is the first one's.
template <typename N> struct GradientNumbers {
    std::int32_t count = 0; // 0: there is none
    N length[kMostGradientPoints] = {}, factor[kMostGradientPoints] = {}, slope[kMostGradientPoints] = {};
};

} // namespace tessera::leaf
