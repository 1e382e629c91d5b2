// tests/bench/lod/area_truth.h: the truth of a picture's pixels, found without anything that the product
// measures errors with: pixels, places and sums of its own.
#pragma once

#include "core/image/image.h"
#include "core/image/image_metrics.h"
#include "core/scene/scene.h"

#include <cstddef>
#include <cstdint>

namespace tessera::bench {

struct AreaTruthEffort {
    int side = 16;       // samples of a pixel: this squared
    double noisy = 0.15; // L*u*v*: pixels that can be off by more get four times the samples, all anew
    double stepVoxels = 1.0 / 16; // of the rays
    int referencePixels = 200;    // at random of those that show something: compared with the reference's
    int referenceSide = 8;
    std::uint64_t seed = 20240229;
};

struct AreaTruth {
    Image means;            // of all pixels
    Image halves[2];        // the same of half of the samples each, independent of one another
    std::size_t shown = 0;  // pixels that show something: alpha above 1/255
    std::size_t noisy = 0;  // pixels with four times the samples
    double noiseLuvP99 = 0; // of the truth itself, from how the halves differ
    int referencePixels = 0;
    double referenceLuvP99 = 0, referenceRms = 0; // native to reference, rays through the same places
    double secondsNative = 0, secondsReference = 0;
};

/// The mean over each pixel's area (box) by the native engine: exact fetches, finest levels, short steps, no
/// ray ended early; and how far that is from the reference's integral.
/// @param scene  its camera is spelled out
AreaTruth areaTruth(const Scene& scene, const AreaTruthEffort& effort, std::size_t ramBytes);

/// compare(), but rms and mean without what the truth's own noise adds: its variance, as the halves tell it,
/// is taken from the squares; the mean is extrapolated, as a square, from the truth and its halves, which
/// have twice the variance, to none.
ImageDifference differenceTo(const AreaTruth& truth, const Image& image);

} // namespace tessera::bench
