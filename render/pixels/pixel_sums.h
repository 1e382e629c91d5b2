// render/pixels/pixel_sums.h: what the samples of a picture's pixels come to, and how far that can be off.
// Sums are in linear premultiplied light, set by set (pixel_places.h), so that a picture is there at any
// time.
#pragma once

#include "core/image.h"

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

    /// A set of samples of a pixel, by its mean.
    void add(std::size_t pixel, const glm::vec4& mean, int samples);
    int samples(std::size_t pixel) const { return pixels_[pixel].samples[0] + pixels_[pixel].samples[1]; }
    int sets(std::size_t pixel) const { return pixels_[pixel].sets; }
    /// Nothing where there are no samples.
    glm::vec4 mean(std::size_t pixel) const;
    /// Between its sets, all components together: of one sample, where sets vary as their samples would
    /// alone; as far as sets are stratified it is less. Of two sets at least.
    double variance(std::size_t pixel) const;
    /// As far as the mean can be off, and in a direction that is as likely as its opposite: half the
    /// difference of two halves of the sets. Its square is the variance of the mean, in the mean over all
    /// that the samples could have been. Of two sets at least.
    glm::vec4 offset(std::size_t pixel) const;

    Image image() const;
    std::size_t samplesTaken() const;
    int mostSamples() const;

    /// RAM of a pixel.
    static constexpr std::size_t bytesPerPixel() { return sizeof(Pixel); }

  private:
    struct Pixel {
        glm::vec4 half[2] = {glm::vec4(0), glm::vec4(0)}; // sums over samples
        float scatter = 0; // of the means of sets around the mean of all, times their samples
        std::uint16_t samples[2] = {0, 0};
        std::uint16_t sets = 0;
    };
    glm::ivec2 size_;
    std::vector<Pixel> pixels_;
};

/// @param offsets  of every pixel, as PixelSums::offset()
StandardError standardError(const Image& image, const std::vector<glm::vec4>& offsets);

} // namespace tessera
