// render/pixels/pixel_places.h: the positions of a pixel's samples (docs/sampling.md, "Pixels"). They are
// small (0,2)-nets, each scrambled independently, seeded by the pixel and the number of the set. Wider
// filters warp them.
#pragma once

#include "core/scene/scene.h" // PixelFilter

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Number of samples of a net: sets that are larger have several.
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
    /// @param first  of a net with all that are put: kMostInSet begin another
    /// @param out    pixels from the picture's corner
    void put(const glm::ivec2& pixel, std::uint32_t set, int first, std::span<glm::vec2> out) const;

  private:
    std::uint32_t seed_;
    PixelFilter filter_;
};

// The layout of samples in an array of rays. Samples of a pixel, and neighbouring pixels, are adjacent.
// Patches of 4 x 4 rays are ordered so that their halves and quarters, for narrower packets, are compact too.

constexpr std::size_t kPatchRays = 16;
constexpr std::size_t kPatchesAcross = 16; // as wide as two tiles of the native engine

/// Columns and rows of an array for a number of rays; less than a row of patches is unused.
inline glm::ivec2 rayArraySize(std::size_t rays) {
    const std::size_t patches = (rays + kPatchRays - 1) / kPatchRays;
    const std::size_t across = std::clamp<std::size_t>(patches, 1, kPatchesAcross);
    return {static_cast<int>(4 * across), static_cast<int>(4 * ((patches + across - 1) / across))};
}

/// Morton order: x in the even bits.
inline glm::ivec2 unzipped(std::uint32_t number) {
    const auto even = [](std::uint32_t n) { return static_cast<int>((n & 1u) | (n >> 1 & 2u)); };
    return {even(number), even(number >> 1)};
}

/// The number of ray k of the list in an array of such a size.
inline std::size_t raySlot(std::size_t k, const glm::ivec2& size) {
    const std::size_t patch = k / kPatchRays, across = static_cast<std::size_t>(size.x) / 4;
    const glm::ivec2 in = unzipped(static_cast<std::uint32_t>(k % kPatchRays));
    const std::size_t column = 4 * (patch % across) + static_cast<std::size_t>(in.x);
    const std::size_t row = 4 * (patch / across) + static_cast<std::size_t>(in.y);
    return row * static_cast<std::size_t>(size.x) + column;
}

/// Calls visit(column, row) for every pixel of a picture, by patches of 4 x 4.
template <typename Visit> void forEachPixel(const glm::ivec2& size, const Visit& visit) {
    for (int y = 0; y < size.y; y += 4)
        for (int x = 0; x < size.x; x += 4)
            for (std::uint32_t k = 0; k < kPatchRays; ++k) {
                const glm::ivec2 at = glm::ivec2(x, y) + unzipped(k);
                if (at.x < size.x && at.y < size.y)
                    visit(at);
            }
}

} // namespace tessera
