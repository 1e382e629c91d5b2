// render/verify/pixel_sample.h: the sample of a picture's pixels that are drawn again. It is a probability
// sample: each pixel has the same known chance, and no value has an influence on the choice.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

struct SampleDesign {
    int pixels = 1000;  // wanted; up to a third more or one stratum more or less are taken
    int perCluster = 1; // pixels of one cluster
    int tile = 4;       // pixels along a side of the tile that a cluster's pixels lie in
    std::uint64_t seed = 0;
};

struct SampledPixel {
    glm::ivec2 at;
    int cluster = 0; // counted through; clusters 2h and 2h+1 are those of stratum h
};

struct PixelSample {
    std::vector<SampledPixel> pixels; // by cluster
    int clusters = 0;                 // even, or as many as pixels where all are taken
    bool all = false;                 // every pixel that there was to choose from
    std::size_t population = 0;       // pixels that there were to choose from
    double chance = 0;                // of each of them to be chosen
};

/// Two stages (Cochran, Sampling Techniques, 3rd ed. 1977, sections 9A and 11.9). Tiles stand in a row along
/// Hilbert's curve, neighbours that together have fewer than 16 perCluster pixels to choose from as one; the
/// row is cut into strata with equally many pixels; in each two tiles are drawn independently, each with a
/// chance proportional to its pixels, and in each of these perCluster pixels without repetition. So every
/// pixel has the same chance, pixels / population, and the two clusters of a stratum tell its variance.
/// All pixels are taken where there are at most a third more than are wanted.
/// @param round  from 0 on: pixels of earlier rounds are not chosen again. A round is a sample of what
///     earlier ones left, whatever was decided from those: pixels that decided when to stop can not certify.
/// @param frame  one a pixel, row by row: only those that are not 0 are chosen among. It must hold every
///     pixel that could show anything, and must not be made from the picture. Empty: all.
PixelSample choosePixels(const glm::ivec2& size, const SampleDesign& design, int round = 0,
                         std::span<const std::uint8_t> frame = {});

} // namespace tessera
