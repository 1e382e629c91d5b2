// render/pixels/pixel_sums.h: the sums of a picture's pixel samples, and estimates of their error. Sums are
// in linear premultiplied light, set by set (pixel_places.h), so a picture is available at any time.
#pragma once

#include "core/image/image.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Standard errors of means over samples, estimated from the samples, over visible pixels (alpha above
/// 1/255). In linear light with all four components, and in CIE L*u*v* over black.
struct StandardError {
    double rms = 0, luvMean = 0, luvP99 = 0;
};

class PixelSums {
  public:
    /// Samples of a pixel from which on sums of floats would lose them: what rounding takes is kept beside
    /// them (T. J. Dekker's sums of two floats).
    static constexpr int kManySamples = 1024;

    /// @param most  samples of a pixel
    PixelSums(const glm::ivec2& size, int most)
        : size_(size), pixels_(rayCountOf(size)), rests_(most > kManySamples ? pixels_.size() : 0) {}
    const glm::ivec2& size() const { return size_; }
    std::size_t count() const { return pixels_.size(); }

    /// The ray through a pixel's centre: its value until it has samples; it is not one of them.
    void setMiddle(std::size_t pixel, const glm::vec4& colour) { pixels_[pixel].sum[0] = colour; }
    /// Adds the sum of further samples to one of a pixel's two sets.
    void add(std::size_t pixel, int set, const glm::dvec4& sum, int samples);
    int samplesOf(std::size_t pixel, int set) const { return pixels_[pixel].samples[set]; }
    int samples(std::size_t pixel) const { return samplesOf(pixel, 0) + samplesOf(pixel, 1); }
    bool hasBothSets(std::size_t pixel) const { return samplesOf(pixel, 0) > 0 && samplesOf(pixel, 1) > 0; }
    /// The value at its centre if there are no samples; 0 if that is unknown too.
    glm::vec4 mean(std::size_t pixel) const;
    /// A deviation of the mean with random sign: half the difference of both sets, if they have one size. The
    /// expectation of its square is the variance of the mean.
    glm::vec4 offset(std::size_t pixel) const;

    Image image() const;
    /// offset() of all pixels; 0 of those without two sets.
    Image offsets() const;
    /// The size of offset() by component: standard errors of means; 0 of pixels without two sets.
    Image errors() const;

    /// The sums of a pixel's sets and what rounding took from each: what a later run goes on from.
    using Kept = std::array<glm::vec4, 4>;
    Kept kept(std::size_t pixel) const;
    /// @param samples  of the pixel in both sets together, even
    void restore(std::size_t pixel, const Kept& kept, int samples);

    /// RAM per pixel.
    /// @param most  samples of a pixel
    static constexpr std::size_t bytesPerPixel(int most) {
        return sizeof(Pixel) + (most > kManySamples ? sizeof(Rests) : 0);
    }

  private:
    using Rests = std::array<glm::vec4, 2>;
    static std::size_t rayCountOf(const glm::ivec2& size) {
        return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    }
    struct Pixel {
        glm::vec4 sum[2] = {glm::vec4(0), glm::vec4(0)};
        std::uint16_t samples[2] = {0, 0};
    };
    glm::ivec2 size_;
    std::vector<Pixel> pixels_;
    std::vector<Rests> rests_; // of sums, by set; none where samples are few
};

/// Over pixels with two sets; the others count as exact.
StandardError standardError(const PixelSums& sums);
/// The same of pixels that are given one by one, always in the same order. Takes no memory that grows with
/// the picture: of large ones the order is gone through several times.
using PixelOffsets =
    std::function<void(const std::function<void(const glm::vec4& mean, const glm::vec4& offset)>& visit)>;
/// @param kept  pixels of pictures that are not large: 8 bytes each
StandardError standardError(const PixelOffsets& eachPixel, std::size_t kept = std::size_t{1} << 22);
/// Its rms alone, which takes no memory.
double rmsError(const PixelSums& sums);

// Each pixel's need for more samples: the possible error of its mean, from its own sets and its neighbours',
// against the allowed error.

/// Allowed standard error of a pixel: in linear light, the mean over all four components; and in L*, by the
/// effect of a component's error. 1/255 is a step of eight bits, and the allowed error of steps. A normally
/// distributed standard error of 1.2 gives 3 at the 99th percentile.
struct PixelTarget {
    double linear = 1.0 / 255, lightness = 1.2;
};

/// The standard error of each pixel relative to its target, row by row; above 1 it needs more samples. It is
/// estimated from the two sets of the pixel and of its neighbours, because two sets can be equal by chance.
/// For a pixel with only its centre it is the deviation of the 3x3 neighbourhood from a plane. That exceeds
/// the error for smooth light, and is about the error at edges. Neighbours with sets count too, because small
/// structures can miss many centres.
std::vector<float> sampleNeeds(const PixelSums& sums, const PixelTarget& target, int threads = 0);
/// Brings needs up to date: these pixels have other samples than when needs were estimated.
void updateNeeds(const PixelSums& sums, const PixelTarget& target, std::span<const std::uint32_t> sampled,
                 int threads, std::vector<float>& needs);

} // namespace tessera
