// core/image/image_metrics.h: differences between two pictures, in linear premultiplied float.
#pragma once

#include "core/image/image.h"

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

/// Errors of a picture, for reports of error against run time. Means and percentiles are over the pixels
/// where the truth's alpha is above 0, so background does not lower them. For compare() alpha must be above
/// 1/255, because it is about visible pixels. The maximum maxAbs includes pixels where the truth is empty.
struct ImageError {
    std::size_t maskedPixels = 0; // where the truth's alpha is above 0
    std::size_t nanCount = 0; // components, of all pixels, that are not finite; they count as an error of 1
    // Linear premultiplied RGBA.
    double rmse = 0, bias = 0;  // bias: mean signed difference
    double maxAbs = 0;          // of all pixels
    double p999 = 0;            // 99.9th percentile of |difference| over components
    double fracAbove1Of255 = 0; // part of the components that differ by more than 1/255
    // After the display transform: over black, clamped to [0,1], sRGB curve, not rounded to 8 bits.
    double psnr = 0;                // dB, peak 1, of the three colours; infinity where they are equal
    double ssim = 1;                // of luma (Rec. 709 weights), mean over windows around masked pixels
    double luvMean = 0, luvP99 = 0; // CIE 1976 L*u*v*
};
/// Window of the structural similarity: Wang, Bovik, Sheikh, Simoncelli 2004, K1 = 0.01, K2 = 0.03; near the
/// picture's edge the part of the window that is inside, its weights normalised.
constexpr int kSsimWindow = 11; // pixels an axis
constexpr double kSsimSigma = 1.5;

/// Against a truth of the same size (checked). A truth that shows nothing leaves means and percentiles at 0.
ImageError measureError(const Image& image, const Image& truth);

} // namespace tessera
