// render/verify/pixel_pairs.h: pixels of a picture with estimates of their truth.
#pragma once

#include "render/verify/pixel_sample.h"

#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

/// Linear, premultiplied. The truth of a pixel is the mean of its replicates: means of equally many samples
/// each, drawn independently of one another. Points of one low-discrepancy set are not independent, so each
/// replicate has its own randomisation. The spread of replicates is the truth's own error.
struct PixelPairs {
    PixelSample sample;
    int replicates = 0;             // an even number; 1: the truth is exact
    std::vector<glm::vec4> picture; // [sampled pixel]
    std::vector<glm::vec4> truth;   // [sampled pixel][replicate]
};

/// The error of a pixel.
struct PixelError {
    int cluster = 0;
    bool shown = false;            // the truth's alpha is above the threshold: the pixel counts
    double square = 0;             // mean over the four components; unbiased: corrected for the truth's noise
    double luv = 0;                // CIE L*u*v* distance, of displayable colours; with the truth's noise
    double luvNoisier = 0;         // mean of luvHalves
    std::vector<double> luvHalves; // with half of the replicates, so with twice the noise's variance
};

/// Components that are not finite have an error of 1, and count as black.
/// @param alphaAbove  pixels count where the truth's alpha is above it: 0 (measureError())
/// or 1/255 (compare())
std::vector<PixelError> pixelErrors(const PixelPairs& pairs, float alphaAbove);

} // namespace tessera
