// core/image_metrics.cpp: see image_metrics.h.
#include "core/image_metrics.h"

#include "core/colour.h"
#include "core/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {

ImageDifference compare(const Image& image, const Image& truth) {
    TESSERA_CHECK(image.size == truth.size);
    ImageDifference d;
    double squares = 0, sum = 0;
    std::vector<double> luv;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const glm::vec4 a = image.pixels[i], b = truth.pixels[i];
        const bool masked = b.a > 1.0f / 255;
        for (int c = 0; c < 4; ++c) {
            const double e = static_cast<double>(a[c]) - static_cast<double>(b[c]);
            ++d.values;
            if (!std::isfinite(e))
                ++d.nonFinite;
            if (std::abs(e) > 0.004)
                ++d.valuesAbove004;
            if (std::abs(e) > 0.012)
                ++d.valuesAbove012;
            d.maxAbs = std::max(d.maxAbs, std::abs(e));
            if (masked) {
                squares += e * e;
                sum += e;
            }
        }
        if (!masked)
            continue;
        ++d.maskedPixels;
        const auto clamped = [](const glm::vec4& p) {
            return glm::clamp(glm::dvec3(p), glm::dvec3(0.0), glm::dvec3(1.0));
        };
        const double distance = glm::length(luvFromLinear(clamped(a)) - luvFromLinear(clamped(b)));
        luv.push_back(distance);
        d.luvMean += distance;
    }
    if (d.maskedPixels == 0)
        return d;
    const double count = static_cast<double>(d.maskedPixels);
    d.rms = std::sqrt(squares / (4 * count));
    d.bias = sum / (4 * count);
    d.luvMean /= count;
    const auto rank = static_cast<std::ptrdiff_t>(0.99 * (count - 1));
    std::nth_element(luv.begin(), luv.begin() + rank, luv.end());
    d.luvP99 = luv[static_cast<std::size_t>(rank)];
    return d;
}

} // namespace tessera
