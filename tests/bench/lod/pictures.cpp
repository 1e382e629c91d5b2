// tests/bench/lod/pictures.cpp: see pictures.h.
#include "tests/bench/lod/pictures.h"

#include "core/base/error.h"
#include "core/image/colour.h"

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tessera::bench {

Image colourMapped(const std::vector<double>& numbers, const glm::ivec2& size, double fullScale) {
    // Equal steps of lightness from one anchor to the next, so that equal differences look equal (sRGB).
    constexpr std::array<glm::dvec3, 6> kAnchors = {
        glm::dvec3(0.05, 0.03, 0.20), glm::dvec3(0.22, 0.16, 0.48), glm::dvec3(0.13, 0.37, 0.55),
        glm::dvec3(0.12, 0.58, 0.51), glm::dvec3(0.50, 0.77, 0.26), glm::dvec3(0.99, 0.91, 0.14)};
    Image image(size);
    TESSERA_CHECK(numbers.size() == image.pixels.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const double at = std::clamp(numbers[i] / fullScale, 0.0, 1.0) * (kAnchors.size() - 1);
        const auto low = std::min(static_cast<std::size_t>(at), kAnchors.size() - 2);
        const glm::dvec3 c = glm::mix(kAnchors[low], kAnchors[low + 1], at - static_cast<double>(low));
        image.pixels[i] = glm::vec4(linearFromSrgb(c.r), linearFromSrgb(c.g), linearFromSrgb(c.b), 1);
    }
    return image;
}

std::vector<double> luvDifferences(const Image& image, const Image& truth) {
    TESSERA_CHECK(image.size == truth.size);
    const auto luv = [](const glm::vec4& p) {
        return luvFromLinear(glm::clamp(glm::dvec3(p), glm::dvec3(0.0), glm::dvec3(1.0)));
    };
    std::vector<double> out(image.pixels.size());
    for (std::size_t i = 0; i < out.size(); ++i)
        if (truth.pixels[i].a > 1.0f / 255)
            out[i] = glm::length(luv(image.pixels[i]) - luv(truth.pixels[i]));
    return out;
}

} // namespace tessera::bench
