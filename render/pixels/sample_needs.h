// render/pixels/sample_needs.h: each pixel's need for more samples: the possible error of its mean, from its
// own sets and its neighbours', against the allowed error.
#pragma once

#include "render/pixels/pixel_sums.h"

#include <vector>

namespace tessera {

/// Allowed standard error of a pixel: in linear light, the mean over all four components; and in L*, by the
/// effect of a component's error. 1/255 is a step of eight bits, and the allowed error of steps. A normally
/// distributed standard error of 1.2 gives 3 at the 99th percentile.
struct PixelTarget {
    double linear = 1.0 / 255, lightness = 1.2;
};

/// The standard error of each pixel relative to its target, row by row; above 1 it needs more samples. It is
/// estimated from the two sets of the pixel and of its neighbours, because two sets can be equal by chance.
/// For a pixel with only its centre it is the deviation of the 3x3 neighbourhood from a plane. That exceeds
/// the error for smooth light, and is about the error at edges. Neighbours with sets count too, because small
/// structures can miss many centres.
std::vector<float> sampleNeeds(const PixelSums& sums, const PixelTarget& target, int threads = 0);

} // namespace tessera
