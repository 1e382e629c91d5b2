// render/verify/pixel_pairs.h: pixels of a picture beside their truth, as far as that is known.
#pragma once

#include "render/verify/pixel_sample.h"

#include <glm/vec4.hpp>
#include <vector>

namespace tessera {

/// Linear, premultiplied. The truth of a pixel is the mean of its replicates: means of equally many samples
/// each, drawn independently of one another (points of one low-discrepancy set are not: a randomisation a
/// replicate), so that how they differ tells what the truth does not know yet.
struct PixelPairs {
    PixelSample sample;
    int replicates = 0;             // an even number; 1: the truth is exact
    std::vector<glm::vec4> picture; // [sampled pixel]
    std::vector<glm::vec4> truth;   // [sampled pixel][replicate]
};

/// What a pixel errs by.
struct PixelError {
    int cluster = 0;
    bool shown = false;    // the truth's alpha is above the threshold: the pixel counts
    double square = 0;     // mean over the four components; unbiased: the truth's noise is taken out
    double luv = 0;        // CIE L*u*v* distance, clamped to what can be shown; with the truth's noise
    double luvNoisier = 0; // mean of luvHalves
    std::vector<double> luvHalves; // with half of the replicates, so with twice the noise's variance
};

/// Components that are not finite err by 1, and count as black.
/// @param alphaAbove  pixels count where the truth's alpha is above it: 0 (measureError())
/// or 1/255 (compare())
std::vector<PixelError> pixelErrors(const PixelPairs& pairs, float alphaAbove);

} // namespace tessera
