// render/verify/pixel_pairs.cpp: see pixel_pairs.h.
#include "render/verify/pixel_pairs.h"

#include "core/base/error.h"
#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

glm::dvec3 luvOf(const glm::dvec4& pixel) {
    const auto inside = [](double c) { return std::isfinite(c) ? std::clamp(c, 0.0, 1.0) : 0.0; };
    return luvFromLinear({inside(pixel.r), inside(pixel.g), inside(pixel.b)});
}

/// Mean over the components of (picture - truth)^2, less the variance of the truth's mean.
double squareWithoutNoise(const glm::dvec4& picture, std::span<const glm::vec4> replicates) {
    double sum = 0;
    const auto count = static_cast<double>(replicates.size());
    for (int c = 0; c < 4; ++c) {
        double mean = 0, squares = 0;
        for (const glm::vec4& r : replicates)
            mean += double{r[c]} / count;
        for (const glm::vec4& r : replicates)
            squares += (r[c] - mean) * (r[c] - mean);
        const double d = picture[c] - mean;
        if (!std::isfinite(d) || !std::isfinite(squares)) {
            sum += 1;
            continue;
        }
        sum += d * d;
        if (replicates.size() > 1)
            sum -= squares / (count * (count - 1));
    }
    return sum / 4;
}

/// The truth by half of the replicates: two groups of two, or every pair of four.
std::vector<glm::dvec4> halvesOf(std::span<const glm::vec4> replicates) {
    const std::size_t groups = replicates.size() % 4 == 0 ? 4 : 2, each = replicates.size() / groups;
    std::vector<glm::dvec4> means(groups, glm::dvec4(0)), halves;
    for (std::size_t i = 0; i < replicates.size(); ++i)
        means[i / each] += glm::dvec4(replicates[i]) / static_cast<double>(each);
    if (groups == 2)
        return means;
    for (std::size_t a = 0; a < groups; ++a)
        for (std::size_t b = a + 1; b < groups; ++b)
            halves.push_back(0.5 * (means[a] + means[b]));
    return halves;
}

} // namespace

std::vector<PixelError> pixelErrors(const PixelPairs& pairs, float alphaAbove) {
    const auto each = static_cast<std::size_t>(pairs.replicates);
    TESSERA_CHECK(pairs.replicates == 1 || (pairs.replicates > 0 && pairs.replicates % 2 == 0));
    TESSERA_CHECK(pairs.picture.size() == pairs.sample.pixels.size() &&
                  pairs.truth.size() == each * pairs.picture.size());
    std::vector<PixelError> errors;
    for (std::size_t i = 0; i < pairs.picture.size(); ++i) {
        const std::span<const glm::vec4> replicates(&pairs.truth[i * each], each);
        const glm::dvec4 picture(pairs.picture[i]);
        glm::dvec4 truth(0);
        for (const glm::vec4& r : replicates)
            truth += glm::dvec4(r) / static_cast<double>(each);
        PixelError& e = errors.emplace_back();
        e.cluster = pairs.sample.pixels[i].cluster;
        e.shown = !(truth.a <= alphaAbove); // what is not finite counts
        e.square = squareWithoutNoise(picture, replicates);
        e.luv = glm::length(luvOf(picture) - luvOf(truth));
        if (each == 1)
            e.luvHalves = {e.luv};
        else
            for (const glm::dvec4& half : halvesOf(replicates))
                e.luvHalves.push_back(glm::length(luvOf(picture) - luvOf(half)));
        for (const double luv : e.luvHalves)
            e.luvNoisier += luv / static_cast<double>(e.luvHalves.size());
    }
    return errors;
}

} // namespace tessera
