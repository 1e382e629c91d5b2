// render/pixels/pixel_places.h: the positions of a pixel's samples (docs/sampling.md, "Pixels"). They are
// small (0,2)-nets, each scrambled independently, seeded by the pixel and the number of the set. Wider
// filters warp them.
#pragma once

#include "core/scene/scene.h" // PixelFilter

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

namespace tessera {

/// Largest number of samples of a set.
constexpr int kMostInSet = 128;
/// The Gaussian filter, in pixels: its standard deviation, and where it ends.
constexpr double kFilterDeviation = 0.5, kFilterReach = 1.5;

/// Maps [0,1) to a distance from the pixel's centre along an axis, by the filter.
double filteredOffset(double unit, PixelFilter filter);

class PixelPlaces {
  public:
    PixelPlaces(std::uint32_t seed, PixelFilter filter) : seed_(seed), filter_(filter) {}

    /// Samples `first`, `first + 1`, ... of a set, which is a (0,2)-sequence in base 2. The pixel's sides can
    /// be halved into 2^m boxes of equal size and shape in several ways. In each of them every box has one of
    /// the first 2^m samples, and of every 2^m after those. Sets are independent, and each sample is uniform
    /// in the pixel. So the mean over sets is unbiased, and the variance of sets estimates that of the mean.
    /// @param pixel  column, row
    /// @param set    of this pixel
    /// @param out    pixels from the picture's corner
    void put(const glm::ivec2& pixel, std::uint32_t set, int first, std::span<glm::vec2> out) const;

  private:
    std::uint32_t seed_;
    PixelFilter filter_;
};

} // namespace tessera
