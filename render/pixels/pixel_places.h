// render/pixels/pixel_places.h: the positions of a pixel's samples (docs/sampling.md, "Pixels"). They are
// small nets, each scrambled by itself, seeded by the pixel and the number of the set. Wider
// filters warp them.
#pragma once

#include "core/scene/scene.h" // PixelFilter

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

namespace tessera {

/// Samples of one set at most.
constexpr int kMostInSet = 128;
/// The Gaussian filter, in pixels: its standard deviation, and where it ends.
constexpr double kFilterDeviation = 0.5, kFilterReach = 1.5;

/// From [0,1) to a distance from the pixel's middle along an axis, as the filter has it.
double filteredOffset(double unit, PixelFilter filter);

class PixelPlaces {
  public:
    PixelPlaces(std::uint32_t seed, PixelFilter filter) : seed_(seed), filter_(filter) {}

    /// Samples `first`, `first + 1`, ... of a set, which is a (0,2)-sequence in base 2. The pixel's sides can
    /// be halved into 2^m boxes of equal size and shape in several ways. In each of them every box has one of
    /// the first 2^m samples, and of every 2^m after those. Sets are independent of one another, and each
    /// sample alone is anywhere in the pixel alike: so the mean over sets is unbiased, and their variance
    /// that of the mean.
    /// @param pixel  column, row
    /// @param set    of this pixel
    /// @param out    pixels from the picture's corner
    void put(const glm::ivec2& pixel, std::uint32_t set, int first, std::span<glm::vec2> out) const;

  private:
    std::uint32_t seed_;
    PixelFilter filter_;
};

} // namespace tessera
