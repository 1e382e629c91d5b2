// render/pixels/pixel_sums.cpp: see pixel_sums.h.
#include "render/pixels/pixel_sums.h"

#include "core/base/error.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {

void PixelSums::add(std::size_t pixel, int set, const glm::vec4& sum, int samples) {
    Pixel& p = pixels_[pixel];
    if (this->samples(pixel) == 0)
        p.sum[0] = glm::vec4(0); // the middle
    p.sum[set] += sum;
    p.samples[set] = static_cast<std::uint16_t>(p.samples[set] + samples);
}

glm::vec4 PixelSums::mean(std::size_t pixel) const {
    const Pixel& p = pixels_[pixel];
    const int all = samples(pixel);
    return all > 0 ? (p.sum[0] + p.sum[1]) / static_cast<float>(all) : p.sum[0];
}

glm::vec4 PixelSums::offset(std::size_t pixel) const {
    TESSERA_CHECK(hasBothSets(pixel));
    const Pixel& p = pixels_[pixel];
    const auto a = static_cast<float>(p.samples[0]), b = static_cast<float>(p.samples[1]);
    // Sets of unequal size differ by more than the error of the mean.
    return (p.sum[0] / a - p.sum[1] / b) * (std::sqrt(a * b) / (a + b));
}

Image PixelSums::image() const {
    Image image(size_);
    for (std::size_t i = 0; i < pixels_.size(); ++i)
        image.pixels[i] = mean(i);
    return image;
}

StandardError standardError(const PixelSums& sums) {
    const auto seen = [](const glm::vec4& v) {
        return luvFromLinear(glm::dvec3(glm::clamp(glm::vec3(v), 0.0f, 1.0f)));
    };
    StandardError e;
    std::vector<double> luv;
    for (std::size_t i = 0; i < sums.count(); ++i) {
        const glm::vec4 mean = sums.mean(i);
        if (!(mean.a > 1.0f / 255))
            continue;
        const glm::vec4 off = sums.hasBothSets(i) ? sums.offset(i) : glm::vec4(0);
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
