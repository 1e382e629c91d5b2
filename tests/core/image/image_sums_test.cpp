// tests/core/image/image_sums_test.cpp: errors of random pictures against sums that are written out anew,
// pixel by pixel.
#include "core/image/colour.h"
#include "core/image/image_metrics.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

/// A third of the pixels are empty, and a few barely visible; some components are outside [0,1].
Image noisy(std::uint32_t seed, const glm::ivec2& size) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    Image image(size);
    for (glm::vec4& p : image.pixels) {
        p = glm::vec4(unit(random) * 1.2f - 0.1f, unit(random), unit(random), unit(random));
        if (unit(random) < 0.33f)
            p.a = unit(random) < 0.5f ? 0 : 0.5f / 255;
    }
    return image;
}

/// A picture near another: most components differ by less than a step of 8 bits.
Image near(const Image& truth, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(0.001f, 0.006f);
    Image image = truth;
    for (glm::vec4& p : image.pixels)
        for (int c = 0; c < 4; ++c)
            p[c] += normal(random);
    return image;
}

glm::dvec3 clamped(const glm::vec4& p) {
    return glm::clamp(glm::dvec3(p), glm::dvec3(0), glm::dvec3(1));
}

double luma(const glm::vec4& p) {
    const glm::dvec3 c = clamped(p);
    return 0.2126 * srgbFromLinear(c.r) + 0.7152 * srgbFromLinear(c.g) + 0.0722 * srgbFromLinear(c.b);
}

double lowest(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Structural similarity around a pixel by the definition: weighted moments of the part of the window that
/// is inside.
double similarityAt(const Image& a, const Image& b, int x, int y) {
    double weights = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
    for (int dy = -5; dy <= 5; ++dy)
        for (int dx = -5; dx <= 5; ++dx) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= a.size.x || y + dy >= a.size.y)
                continue;
            const double w = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
            const double u = luma(a.at(x + dx, y + dy)), v = luma(b.at(x + dx, y + dy));
            weights += w, ma += w * u, mb += w * v, aa += w * u * u, bb += w * v * v, ab += w * u * v;
        }
    ma /= weights, mb /= weights, aa = aa / weights - ma * ma, bb = bb / weights - mb * mb;
    ab = ab / weights - ma * mb;
    return (2 * ma * mb + 1e-4) * (2 * ab + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (aa + bb + 9e-4));
}

TEST(ImageSums, ErrorsAreThoseOfTheDefinition) {
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
        const Image truth = noisy(seed, {23, 17}), image = near(truth, 10 + seed);
        double squares = 0, sum = 0, shown = 0, ssim = 0, luvSum = 0, most = 0;
        std::vector<double> differences, luv;
        for (int y = 0; y < truth.size.y; ++y)
            for (int x = 0; x < truth.size.x; ++x) {
                const glm::vec4 a = image.at(x, y), b = truth.at(x, y);
                for (int c = 0; c < 4; ++c)
                    most = std::max(most, std::abs(double{a[c]} - double{b[c]}));
                if (!(b.a > 0))
                    continue;
                for (int c = 0; c < 4; ++c) {
                    const double d = double{a[c]} - double{b[c]};
                    squares += d * d, sum += d;
                    differences.push_back(std::abs(d));
                }
                const glm::dvec3 p = clamped(a), q = clamped(b);
                for (int c = 0; c < 3; ++c)
                    shown += std::pow(srgbFromLinear(p[c]) - srgbFromLinear(q[c]), 2);
                luv.push_back(glm::length(luvFromLinear(p) - luvFromLinear(q)));
                luvSum += luv.back();
                ssim += similarityAt(image, truth, x, y);
            }
        const auto pixels = static_cast<double>(luv.size());
        const ImageError e = measureError(image, truth);
        EXPECT_EQ(e.maskedPixels, luv.size());
        EXPECT_EQ(e.nanCount, 0u);
        EXPECT_NEAR(e.rmse, std::sqrt(squares / (4 * pixels)), 1e-12);
        EXPECT_NEAR(e.bias, sum / (4 * pixels), 1e-12);
        EXPECT_EQ(e.maxAbs, most);
        EXPECT_EQ(e.p999, lowest(differences, 0.999));
        EXPECT_EQ(e.fracAbove1Of255,
                  static_cast<double>(std::count_if(differences.begin(), differences.end(),
                                                    [](double d) { return d > 1.0 / 255; })) /
                      (4 * pixels));
        EXPECT_NEAR(e.psnr, -10 * std::log10(shown / (3 * pixels)), 1e-9);
        EXPECT_NEAR(e.luvMean, luvSum / pixels, 1e-9);
        EXPECT_NEAR(e.luvP99, lowest(luv, 0.99), 1e-9);
        EXPECT_NEAR(e.ssim, ssim / pixels, 1e-9);
    }
}

TEST(ImageSums, DifferencesAreThoseOfTheDefinition) {
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
        const Image truth = noisy(seed, {23, 17}), image = near(truth, 20 + seed);
        double squares = 0, sum = 0, most = 0, luvSum = 0;
        std::vector<double> luv;
        std::size_t above004 = 0, above012 = 0;
        for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
            const bool masked = truth.pixels[i].a > 1.0f / 255;
            for (int c = 0; c < 4; ++c) {
                const double d = double{image.pixels[i][c]} - double{truth.pixels[i][c]};
                most = std::max(most, std::abs(d));
                above004 += std::abs(d) > 0.004 ? 1 : 0;
                above012 += std::abs(d) > 0.012 ? 1 : 0;
                squares += masked ? d * d : 0, sum += masked ? d : 0;
            }
            if (masked)
                luv.push_back(glm::length(luvFromLinear(clamped(image.pixels[i])) -
                                          luvFromLinear(clamped(truth.pixels[i]))));
            luvSum += masked ? luv.back() : 0;
        }
        const auto pixels = static_cast<double>(luv.size());
        ImageDifference d = compare(image, truth);
        EXPECT_EQ(d.maskedPixels, luv.size());
        EXPECT_EQ(d.values, 4 * truth.pixels.size());
        EXPECT_EQ(d.nonFinite, 0u);
        EXPECT_EQ(d.valuesAbove004, above004);
        EXPECT_EQ(d.valuesAbove012, above012);
        EXPECT_GT(above012, 0u);
        EXPECT_GT(above004, above012);
        EXPECT_EQ(d.maxAbs, most);
        EXPECT_NEAR(d.rms, std::sqrt(squares / (4 * pixels)), 1e-12);
        EXPECT_NEAR(d.bias, sum / (4 * pixels), 1e-12);
        EXPECT_NEAR(d.luvMean, luvSum / pixels, 1e-9);
        EXPECT_NEAR(d.luvP99, lowest(luv, 0.99), 1e-9);
        // the other way round the sign turns
        Image opaque = truth;
        for (glm::vec4& p : opaque.pixels)
            p.a = 1;
        Image moved = near(opaque, 30 + seed);
        for (glm::vec4& p : moved.pixels)
            p.a = 1;
        EXPECT_NEAR(compare(moved, opaque).bias, -compare(opaque, moved).bias, 1e-12);
    }
    Image broken = noisy(1, {5, 4});
    const Image truth = broken;
    broken.pixels[3].g = std::numeric_limits<float>::quiet_NaN();
    broken.pixels[7].a = std::numeric_limits<float>::infinity();
    EXPECT_EQ(compare(broken, truth).nonFinite, 2u);
    const ImageDifference none = compare(Image({3, 2}), Image({3, 2}));
    EXPECT_EQ(none.maskedPixels, 0u);
    EXPECT_EQ(none.values, 24u);
    EXPECT_EQ(none.rms + none.bias + none.luvMean + none.luvP99 + none.maxAbs, 0);
}

TEST(ImageSums, OfNothingAreNothing) {
    const ImageError none = measureError(Image({3, 2}), Image({3, 2}));
    EXPECT_EQ(none.maskedPixels, 0u);
    EXPECT_EQ(none.rmse + none.bias + none.maxAbs + none.p999 + none.fracAbove1Of255, 0);
    EXPECT_EQ(none.luvMean + none.luvP99, 0);
    EXPECT_EQ(none.ssim, 1);
}

TEST(ImageSums, BlankIsWhatNoByteShows) {
    Image image({4, 3});
    EXPECT_TRUE(isBlank(image));
    image.at(3, 2).a = 1.0f / 510;
    EXPECT_TRUE(isBlank(image));
    image.at(3, 2).a = 1.001f / 510;
    EXPECT_FALSE(isBlank(image));
}

} // namespace
} // namespace tessera
