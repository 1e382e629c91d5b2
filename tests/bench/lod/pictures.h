// tests/bench/lod/pictures.h: numbers as pictures.
#pragma once

#include "core/image/image.h"

#include <vector>

namespace tessera::bench {

/// Numbers from 0 to fullScale as colours from dark blue over green to yellow (beyond: yellow), opaque.
/// @param numbers  [y][x] of size
Image colourMapped(const std::vector<double>& numbers, const glm::ivec2& size, double fullScale);

/// CIE L*u*v* distance of every pixel, over black; 0 where the truth shows nothing (alpha at most 1/255), as
/// in image_metrics.h. Pictures of one size.
std::vector<double> luvDifferences(const Image& image, const Image& truth);

} // namespace tessera::bench
