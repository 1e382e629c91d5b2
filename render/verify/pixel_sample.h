// render/verify/pixel_sample.h: the sample of a picture's pixels that are drawn again. It is a probability
// sample: each pixel has the same known probability, and pixel values do not influence the choice.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

struct SampleDesign {
    int pixels = 1000;  // wanted number; up to a third more or one stratum more or less are taken
    int perCluster = 1; // pixels of one cluster
    int tile = 4;       // pixels along a side of the tile that a cluster's pixels lie in
    std::uint64_t seed = 0;
};

struct SampledPixel {
    glm::ivec2 at;
    int cluster = 0; // number of the cluster; clusters 2h and 2h+1 are those of stratum h
};

struct PixelSample {
    std::vector<SampledPixel> pixels; // by cluster
    int clusters = 0;                 // even, or as many as pixels if all are taken
    bool all = false;                 // all pixels were taken
    std::size_t population = 0;       // pixels in the population
    double chance = 0;                // probability of each pixel
};

/// Two stages (Cochran, Sampling Techniques, 3rd ed. 1977, sections 9A and 11.9). Tiles are ordered along a
/// Hilbert curve. Neighbours that together have fewer than 16 perCluster pixels to choose from count as one.
/// The row is divided into strata with equally many pixels. In each stratum two tiles are drawn
/// independently, each with a probability proportional to its pixels, and in each of these perCluster pixels
/// without replacement. So every pixel has the same probability, pixels / population, and the two clusters of
/// a stratum give its variance. All pixels are taken if there are at most a third more than wanted.
/// @param round  from 0 on: pixels of earlier rounds are not chosen again. A round samples what earlier ones
///     left, because pixels that decided when to stop cannot confirm the result.
/// @param frame  one per pixel, row by row: the population is those that are not 0. It must include every
///     pixel that could be visible, and must not depend on the picture. Empty: all.
PixelSample choosePixels(const glm::ivec2& size, const SampleDesign& design, int round = 0,
                         std::span<const std::uint8_t> frame = {});

} // namespace tessera
