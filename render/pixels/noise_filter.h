// render/pixels/noise_filter.h: a filter for pictures by paths of light: non-local means between the two
// halves of every pixel's samples (F. Rousselle, C. Knaus, M. Zwicker, Adaptive Rendering with Non-Local
// Means Filtering, 2012). Weights of one half come from the other, so that noise does not choose its own
// company.
#pragma once

#include "core/image/image.h"
#include "render/pixels/pixel_sums.h"

#include <cstddef>
#include <glm/vec2.hpp>

namespace tessera {

/// The picture with less noise in its colours, and some bias. Pixels without both sets stay as they are.
/// @param threads  0: all processors
Image withoutNoise(const PixelSums& sums, int threads = 0);

/// RAM that it takes beside the sums.
/// @param threads  0: all processors
std::size_t noiseFilterBytes(const glm::ivec2& size, int threads);

} // namespace tessera
