// render/pixels/sample_needs.cpp: see sample_needs.h.
#include "render/pixels/sample_needs.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

std::size_t indexOf(const glm::ivec2& at, const glm::ivec2& size) {
    return static_cast<std::size_t>(at.y) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(at.x);
}

template <typename Visit>
void forEachAround(const glm::ivec2& at, const glm::ivec2& size, const Visit& visit) {
    for (int y = std::max(0, at.y - 1); y <= std::min(size.y - 1, at.y + 1); ++y)
        for (int x = std::max(0, at.x - 1); x <= std::min(size.x - 1, at.x + 1); ++x)
            visit(indexOf({x, y}, size));
}

/// Of one sample of a pixel's neighbours that have two sets, in the mean over those, all components together.
double varianceOfNeighbours(const PixelSums& sums, const glm::ivec2& at) {
    double variance = 0;
    int count = 0;
    forEachAround(at, sums.size(), [&](std::size_t n) {
        if (n == indexOf(at, sums.size()) || !sums.hasBothSets(n))
            return;
        const glm::vec4 off = sums.offset(n);
        variance += static_cast<double>(glm::dot(off, off)) * sums.samples(n);
        ++count;
    });
    return count > 0 ? variance / count : 0;
}

/// Of the mean of a pixel with two sets, all components together. They can be alike by chance where its
/// neighbours' differ: so those count too, as if they had as many samples.
double varianceOfSets(const PixelSums& sums, const glm::ivec2& at) {
    constexpr double kNeighbours = 0.5; // their part beside the pixel's own
    const std::size_t i = indexOf(at, sums.size());
    const glm::vec4 off = sums.offset(i);
    const double around = varianceOfNeighbours(sums, at) / sums.samples(i);
    return (static_cast<double>(glm::dot(off, off)) + kNeighbours * around) / (1 + kNeighbours);
}

/// How fast L* rises with light, a component of linear light.
double lightnessSlope(double light) {
    constexpr double linearBelow = 0.008856451679035631; // CIE 1976
    return light > linearBelow ? 116.0 / 3 / std::cbrt(light * light) : 903.2962962962963;
}

/// Of a ray through a pixel's middle, all components together: of it and its eight neighbours around a plane
/// through them. Pixels at the picture's edge take the nearest nine; a picture of fewer than three rows or
/// columns repeats its last.
double varianceAround(const PixelSums& sums, const glm::ivec2& at) {
    const glm::ivec2 middle = glm::clamp(at, glm::ivec2(1), glm::max(glm::ivec2(1), sums.size() - 2));
    glm::dvec4 mean(0), right(0), down(0); // of the nine; rises from pixel to pixel
    double squares = 0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
            const glm::ivec2 near = glm::min(middle + glm::ivec2(x, y), sums.size() - 1);
            const glm::dvec4 c(sums.mean(indexOf(near, sums.size())));
            mean += c / 9.0;
            right += c * (x / 6.0);
            down += c * (y / 6.0);
            squares += glm::dot(c, c);
        }
    const double scatter =
        squares - 9 * glm::dot(mean, mean) - 6 * glm::dot(right, right) - 6 * glm::dot(down, down);
    return std::max(0.0, scatter) / (9 - 3);
}

} // namespace

std::vector<float> sampleNeeds(const PixelSums& sums, const PixelTarget& target) {
    const glm::ivec2 size = sums.size();
    std::vector<float> needs(sums.count());
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const std::size_t i = indexOf({x, y}, size);
            const double variance = sums.hasBothSets(i) ? varianceOfSets(sums, {x, y})
                                                        : std::max(varianceAround(sums, {x, y}),
                                                                   varianceOfNeighbours(sums, {x, y}));
            const double off = std::sqrt(variance / 4); // a component's
            const glm::vec4 mean = sums.mean(i);
            const double light =
                std::clamp(0.2126 * static_cast<double>(mean.r) + 0.7152 * static_cast<double>(mean.g) +
                               0.0722 * static_cast<double>(mean.b),
                           0.0, 1.0);
            needs[i] = static_cast<float>(
                std::max(off / target.linear, off * lightnessSlope(light + off) / target.lightness));
        }
    return needs;
}

} // namespace tessera
