// render/pixels/sample_needs.h: each pixel's need for more samples: the possible error of its mean, from its
// own sets and its neighbours', against the allowed error.
#pragma once

#include "render/pixels/pixel_sums.h"

#include <vector>

namespace tessera {

/// What a pixel's standard error may be: linear light, the mean over all four components; and L*, as far as a
/// component's error shows in it. 1/255 is what eight bits show, and what steps may err by. Errors of pixels
/// that just reach 1.2 are 3 at the 99th percentile where they are normally distributed.
struct PixelTarget {
    double linear = 1.0 / 255, lightness = 1.2;
};

/// The standard error of each pixel as a part of its target, row by row; above 1 it needs more. It follows
/// from the pixel's two sets, and from its neighbours', for two sets can be alike by chance. A pixel of which
/// only the middle is known is judged by how far it and its eight neighbours are from a plane: more than what
/// it is off by where light changes smoothly, about that at edges; and by neighbours that have sets, for what
/// few rays hit can miss many middles.
std::vector<float> sampleNeeds(const PixelSums& sums, const PixelTarget& target, int threads = 0);

} // namespace tessera
