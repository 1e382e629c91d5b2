// render/pixels/pixel_sums.h: the sums of a picture's pixel samples, and estimates of their error. Sums are
// in linear premultiplied light, set by set (pixel_places.h), so a picture is there at any time.
#pragma once

#include "core/image/image.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

/// How far means over samples are off, estimated from those samples: over the pixels that show something
/// (alpha above 1/255), linear light with all four components, and CIE L*u*v* over black.
struct StandardError {
    double rms = 0, luvMean = 0, luvP99 = 0;
};

class PixelSums {
  public:
    explicit PixelSums(const glm::ivec2& size) : size_(size), pixels_(Image(size).pixels.size()) {}
    const glm::ivec2& size() const { return size_; }
    std::size_t count() const { return pixels_.size(); }

    /// The ray through a pixel's middle: all that is known of it until it has samples, of which it is none.
    void setMiddle(std::size_t pixel, const glm::vec4& colour) { pixels_[pixel].sum[0] = colour; }
    /// Further samples of one of a pixel's two sets, by their sum.
    void add(std::size_t pixel, int set, const glm::vec4& sum, int samples);
    int samplesOf(std::size_t pixel, int set) const { return pixels_[pixel].samples[set]; }
    int samples(std::size_t pixel) const { return samplesOf(pixel, 0) + samplesOf(pixel, 1); }
    bool hasBothSets(std::size_t pixel) const { return samplesOf(pixel, 0) > 0 && samplesOf(pixel, 1) > 0; }
    /// What its middle shows where there are no samples; nothing where that is not known either.
    glm::vec4 mean(std::size_t pixel) const;
    /// As far as the mean can be off, and in a direction that is as likely as its opposite: half the
    /// difference of both sets, where they are of one size. Its square is the variance of the mean, in the
    /// mean over all that the samples could have been.
    glm::vec4 offset(std::size_t pixel) const;

    Image image() const;

    /// RAM of a pixel.
    static constexpr std::size_t bytesPerPixel() { return sizeof(Pixel); }

  private:
    struct Pixel {
        glm::vec4 sum[2] = {glm::vec4(0), glm::vec4(0)};
        std::uint16_t samples[2] = {0, 0};
    };
    glm::ivec2 size_;
    std::vector<Pixel> pixels_;
};

/// Of pixels with two sets; the others are taken to be exact.
StandardError standardError(const PixelSums& sums);

} // namespace tessera
