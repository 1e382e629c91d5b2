// render/verify/pixel_sample.h: the sample of a picture's pixels that are drawn again. It is a probability
// sample: each pixel has the same known probability, and pixel values do not influence the choice.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

// Random numbers, the same on every machine and with every compiler.

/// SplitMix64 (Steele, Lea, Flood 2014): a counter, mixed. Streams of a seed are unrelated.
class RandomNumbers {
  public:
    explicit RandomNumbers(std::uint64_t seed, std::uint64_t stream = 0)
        : state_(mixed(mixed(seed) + 0x9E3779B97F4A7C15u * (stream + 1))) {}
    std::uint64_t next() { return mixed(state_ += 0x9E3779B97F4A7C15u); }
    /// From 0 to below 1.
    double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    /// Uniform from 0 to count - 1: values of the incomplete last interval of 2^64 are rejected.
    std::uint64_t below(std::uint64_t count) {
        const std::uint64_t leftOver = (0 - count) % count;
        for (;;)
            if (const std::uint64_t drawn = next(); drawn >= leftOver)
                return drawn % count;
    }

  private:
    static std::uint64_t mixed(std::uint64_t v) {
        v = (v ^ (v >> 30)) * 0xBF58476D1CE4E5B9u;
        v = (v ^ (v >> 27)) * 0x94D049BB133111EBu;
        return v ^ (v >> 31);
    }
    std::uint64_t state_;
};

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

// Pixels of a picture with estimates of their truth.

/// Linear, premultiplied. The truth of a pixel is the mean of its replicates: means of equally many samples
/// each, drawn independently of one another. Points of one low-discrepancy set are not independent, so each
/// replicate has its own randomisation. The spread of replicates is the truth's own error.
struct PixelPairs {
    PixelSample sample;
    int replicates = 0;             // an even number; 1: the truth is exact
    std::vector<glm::vec4> picture; // [sampled pixel]
    std::vector<glm::vec4> truth;   // [sampled pixel][replicate]
};

/// The error of a pixel.
struct PixelError {
    int cluster = 0;
    bool shown = false;            // the truth's alpha is above the threshold: the pixel counts
    double square = 0;             // mean over the four components; unbiased: corrected for the truth's noise
    double luv = 0;                // CIE L*u*v* distance, of displayable colours; with the truth's noise
    double luvNoisier = 0;         // mean of luvHalves
    std::vector<double> luvHalves; // with half of the replicates, so with twice the noise's variance
};

/// Components that are not finite have an error of 1, and count as black.
/// @param alphaAbove  pixels count where the truth's alpha is above it: 0 (measureError())
/// or 1/255 (compare())
std::vector<PixelError> pixelErrors(const PixelPairs& pairs, float alphaAbove);

} // namespace tessera
