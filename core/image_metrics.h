// core/image_metrics.h: how far two pictures are apart (NUMERICS C3 columns), in linear premultiplied float.
#pragma once

#include "core/image.h"

#include <cstddef>

namespace tessera {

struct ImageDifference {
    double rms = 0, maxAbs = 0;     // over all four components of the masked pixels
    double bias = 0;                // mean signed difference
    double luvMean = 0, luvP99 = 0; // CIE L*u*v* distance over black, masked pixels
    std::size_t maskedPixels = 0;   // pixels where the second picture's alpha is above 1/255
    std::size_t valuesAbove004 = 0, valuesAbove012 = 0, values = 0; // of all components of all pixels
    std::size_t nonFinite = 0;
};

/// Compares a picture against a truth of the same size (checked).
ImageDifference compare(const Image& image, const Image& truth);

} // namespace tessera
