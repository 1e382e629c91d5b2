// render/pixels/pixel_sums.cpp: see pixel_sums.h.
#include "render/pixels/pixel_sums.h"

#include "core/colour.h"
#include "core/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {

void PixelSums::add(std::size_t pixel, const glm::vec4& mean, int samples) {
    Pixel& p = pixels_[pixel];
    const auto before = static_cast<float>(this->samples(pixel)), more = static_cast<float>(samples);
    if (p.sets > 0) {
        const glm::vec4 off = mean - this->mean(pixel);
        p.scatter += glm::dot(off, off) * before * more / (before + more);
    }
    const int half = p.samples[1] < p.samples[0] ? 1 : 0;
    p.half[half] += more * mean;
    p.samples[half] = static_cast<std::uint16_t>(p.samples[half] + samples);
    ++p.sets;
}

glm::vec4 PixelSums::mean(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    const int all = samples(pixel);
    return all > 0 ? (p.half[0] + p.half[1]) / static_cast<float>(all) : glm::vec4(0);
}

double PixelSums::variance(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    TESSERA_CHECK(p.sets > 1);
    return static_cast<double>(p.scatter) / (p.sets - 1);
}

glm::vec4 PixelSums::offset(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    TESSERA_CHECK(p.sets > 1);
    const auto a = static_cast<float>(p.samples[0]), b = static_cast<float>(p.samples[1]);
    // Halves of unequal size differ by more than the mean is off.
    return (p.half[0] / a - p.half[1] / b) * (std::sqrt(a * b) / (a + b));
}

Image PixelSums::image() const {
    Image image(size_);
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        image.pixels[i] = mean(i);
    return image;
}

std::size_t PixelSums::samplesTaken() const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        sum += static_cast<std::size_t>(samples(i));
    return sum;
}

int PixelSums::mostSamples() const {
    int most = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        most = std::max(most, samples(i));
    return most;
}

StandardError standardError(const Image& image, const std::vector<glm::vec4>& offsets) {
    TESSERA_CHECK(offsets.size() == image.pixels.size());
    const auto seen = [](const glm::vec4& v) {
        return luvFromLinear(glm::dvec3(glm::clamp(glm::vec3(v), 0.0f, 1.0f)));
    };
    StandardError e;
    std::vector<double> luv;
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        const glm::vec4 &mean = image.pixels[i], &off = offsets[i];
        if (!(mean.a > 1.0f / 255))
            continue;
        e.rms += static_cast<double>(glm::dot(off, off));
        luv.push_back(glm::length(seen(mean + off) - seen(mean)));
        e.luvMean += luv.back();
    }
    if (luv.empty())
        return {};
    e.rms = std::sqrt(e.rms / (4 * static_cast<double>(luv.size())));
    e.luvMean /= static_cast<double>(luv.size());
    const auto rank = static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(luv.size() - 1));
    std::nth_element(luv.begin(), luv.begin() + rank, luv.end());
    e.luvP99 = luv[static_cast<std::size_t>(rank)];
    return e;
}

} // namespace tessera
