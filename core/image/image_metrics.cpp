// core/image/image_metrics.cpp: see image_metrics.h.
#include "core/image/image_metrics.h"

#include "core/base/error.h"
#include "core/image/colour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera {
namespace {

glm::dvec3 clampedColour(const glm::vec4& pixel) {
    const auto inside = [](float c) { return std::isfinite(c) ? std::clamp(double{c}, 0.0, 1.0) : 0.0; };
    return {inside(pixel.r), inside(pixel.g), inside(pixel.b)};
}

/// The value that a share of all values do not exceed. Reorders them.
double percentile(std::vector<double>& values, double share) {
    const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
}

/// Blur by the window of the structural similarity, both axes.
std::vector<double> windowMeans(const std::vector<double>& values, const glm::ivec2& size) {
    constexpr int kReach = kSsimWindow / 2;
    std::array<double, kSsimWindow> weight{};
    for (int i = -kReach; i <= kReach; ++i)
        weight[static_cast<std::size_t>(i + kReach)] = std::exp(-i * i / (2 * kSsimSigma * kSsimSigma));
    const auto alongAxis = [&](const std::vector<double>& in, int axis) {
        std::vector<double> out(in.size());
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                double sum = 0, weights = 0;
                for (int i = -kReach; i <= kReach; ++i) {
                    const glm::ivec2 at(x + (axis == 0 ? i : 0), y + (axis == 1 ? i : 0));
                    if (at.x < 0 || at.y < 0 || at.x >= size.x || at.y >= size.y)
                        continue;
                    const double w = weight[static_cast<std::size_t>(i + kReach)];
                    sum += w * in[static_cast<std::size_t>(at.y * size.x + at.x)];
                    weights += w;
                }
                out[static_cast<std::size_t>(y * size.x + x)] = sum / weights;
            }
        return out;
    };
    return alongAxis(alongAxis(values, 0), 1);
}

/// Structural similarity of the windows around each pixel.
std::vector<double> similarity(const std::vector<double>& a, const std::vector<double>& b,
                               const glm::ivec2& size) {
    const auto product = [](const std::vector<double>& x, const std::vector<double>& y) {
        std::vector<double> out(x.size());
        std::transform(x.begin(), x.end(), y.begin(), out.begin(), std::multiplies<>());
        return out;
    };
    const std::vector<double> meanA = windowMeans(a, size), meanB = windowMeans(b, size),
                              squareA = windowMeans(product(a, a), size),
                              squareB = windowMeans(product(b, b), size),
                              both = windowMeans(product(a, b), size);
    constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03; // of a range of 1
    std::vector<double> out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double mean = meanA[i] * meanB[i], squares = meanA[i] * meanA[i] + meanB[i] * meanB[i];
        const double covariance = both[i] - mean, variances = squareA[i] + squareB[i] - squares;
        out[i] = (2 * mean + kC1) * (2 * covariance + kC2) / ((squares + kC1) * (variances + kC2));
    }
    return out;
}

} // namespace

ImageError measureError(const Image& image, const Image& truth) {
    TESSERA_CHECK(image.size == truth.size);
    ImageError e;
    std::vector<double> differences, luv, lumaImage, lumaTruth;
    std::vector<bool> mask;
    double squares = 0, sum = 0, shownSquares = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const glm::vec4 a = image.pixels[i], b = truth.pixels[i];
        const bool masked = b.a > 0;
        mask.push_back(masked);
        for (int c = 0; c < 4; ++c) {
            double d = double{a[c]} - double{b[c]};
            if (!std::isfinite(d)) {
                ++e.nanCount;
                d = 1;
            }
            e.maxAbs = std::max(e.maxAbs, std::abs(d));
            if (!masked)
                continue;
            differences.push_back(std::abs(d));
            squares += d * d;
            sum += d;
        }
        const glm::dvec3 linearA = clampedColour(a), linearB = clampedColour(b);
        glm::dvec3 shownA, shownB;
        for (int c = 0; c < 3; ++c) {
            shownA[c] = srgbFromLinear(linearA[c]);
            shownB[c] = srgbFromLinear(linearB[c]);
        }
        const glm::dvec3 lumaWeights(0.2126, 0.7152, 0.0722);
        lumaImage.push_back(glm::dot(lumaWeights, shownA));
        lumaTruth.push_back(glm::dot(lumaWeights, shownB));
        if (!masked)
            continue;
        shownSquares += glm::dot(shownA - shownB, shownA - shownB);
        luv.push_back(glm::length(luvFromLinear(linearA) - luvFromLinear(linearB)));
        e.luvMean += luv.back();
    }
    e.maskedPixels = luv.size();
    e.psnr = std::numeric_limits<double>::infinity();
    if (e.maskedPixels == 0)
        return e;
    const double pixels = static_cast<double>(e.maskedPixels);
    e.rmse = std::sqrt(squares / (4 * pixels));
    e.bias = sum / (4 * pixels);
    e.fracAbove1Of255 = static_cast<double>(std::count_if(differences.begin(), differences.end(),
                                                          [](double d) { return d > 1.0 / 255; })) /
                        (4 * pixels);
    e.p999 = percentile(differences, 0.999);
    if (shownSquares > 0)
        e.psnr = -10 * std::log10(shownSquares / (3 * pixels));
    e.luvMean /= pixels;
    e.luvP99 = percentile(luv, 0.99);
    const std::vector<double> alike = similarity(lumaImage, lumaTruth, image.size);
    e.ssim = 0;
    for (std::size_t i = 0; i < alike.size(); ++i)
        if (mask[i])
            e.ssim += alike[i] / pixels;
    return e;
}

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
