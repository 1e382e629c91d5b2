// render/plan/picture_check.h: estimates of a picture's error from itself: some pixels drawn again with other
// steps and with exact fetches. Each cause is estimated separately. Comparisons are with better pictures of
// the same renderer, not with the truth.
#pragma once

#include "core/image/image.h"
#include "core/image/image_metrics.h"
#include "render/contract/ray.h"

#include <glm/vec2.hpp>
#include <optional>

namespace tessera {

/// The grid of thinned() with the least stride that leaves at most kMostPixels pixels along an axis.
class PixelGrid {
  public:
    static constexpr int kMostPixels = 48;
    explicit PixelGrid(const glm::ivec2& imageSize);
    const glm::ivec2& size() const { return size_; } // pixels of the grid
    /// Draws the picture's rays through the grid's pixels, with segments of a length in voxels.
    RayFrame<double> frame(const RayFrame<double>& picture, double segmentVoxels) const;
    Image of(const Image& picture) const;

  private:
    glm::ivec2 picture_, size_;
    int every_;
};

/// An error of a picture, over the grid's pixels: linear light, all four components; CIE L*u*v*.
struct EstimatedError {
    double rms = 0, largest = 0, luvMean = 0, luvP99 = 0;
};

struct StepError {
    EstimatedError error; // of the picture's step, against a quarter of it
    double order = 0;     // order of convergence: of the difference to half the step
};

/// @param picture, half, quarter  the grid's pixels with the picture's step, half and a quarter of it
StepError stepError(const Image& picture, const Image& half, const Image& quarter);
/// The error of a picture against a better one.
EstimatedError errorBetween(const Image& picture, const Image& better);

/// The estimated errors of a picture by cause. None: unknown, or no such cause.
struct PictureErrors {
    int pixels = 0; // pixels drawn again
    std::optional<StepError> step;
    std::optional<EstimatedError> filtering; // filtered against exact fetches
    double terminationBound = 0;             // upper bound of a component's loss in a pixel; linear light
    double tableRelativeError = 0;           // of extinction, relative to its largest
    std::optional<double> levelsLuvP99;      // predicted
    /// Sum of the 99th percentiles of step, filtering and levels, L*u*v*.
    double luvP99() const;
};

} // namespace tessera
