// render/pixels/pixel_places.h: where the samples of a pixel lie (docs/sampling.md, "Pixels"): small nets,
// each scrambled by itself, seeded by the pixel and the number of the set; wider filters by warping them.
#pragma once

#include "core/scene.h" // PixelFilter

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

namespace tessera {

/// Samples of one set at most: 4 x 4 strata.
constexpr int kMostInSet = 16;
/// The Gaussian filter, in pixels: its standard deviation, and where it ends.
constexpr double kFilterDeviation = 0.5, kFilterReach = 1.5;

/// From [0,1) to a distance from the pixel's middle along an axis, as the filter has it.
double filteredOffset(double unit, PixelFilter filter);

class PixelPlaces {
  public:
    PixelPlaces(std::uint32_t seed, PixelFilter filter) : seed_(seed), filter_(filter) {}

    /// A (0,m,2)-net in base 2: whatever 2^m boxes of equal size and shape halve a pixel's sides into, each
    /// has one sample. Sets are independent of one another, and each sample alone is anywhere in the pixel
    /// alike: so the mean over sets is unbiased, and their variance that of the mean.
    /// @param pixel  column, row
    /// @param set    of this pixel
    /// @param out    its size is 2^m: 1, 2, 4, 8 or 16; pixels from the picture's corner
    void put(const glm::ivec2& pixel, std::uint32_t set, std::span<glm::vec2> out) const;

  private:
    std::uint32_t seed_;
    PixelFilter filter_;
};

} // namespace tessera
