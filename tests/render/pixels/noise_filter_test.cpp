// tests/render/pixels/noise_filter_test.cpp: a filter that takes noise out of pictures by paths of light.
#include "render/pixels/noise_filter.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using Colour = std::function<glm::vec3(int x, int y)>;

/// Sums of two sets of samples each, of a picture and normal noise.
struct Noisy {
    Noisy(const glm::ivec2& size, const Colour& colour, double deviation, unsigned seed = 1)
        : sums(size, 8), truth(size) {
        std::mt19937 random(seed);
        std::normal_distribution<float> noise(0, static_cast<float>(deviation));
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                                   static_cast<std::size_t>(x);
                truth.pixels[pixel] = glm::vec4(colour(x, y), 1);
                for (int set = 0; set < 2; ++set) {
                    const glm::vec3 off(noise(random), noise(random), noise(random));
                    sums.add(pixel, set, glm::vec4(4.0f * (colour(x, y) + off), 4), 4);
                }
            }
    }
    double errorOf(const Image& image) const {
        double squares = 0;
        for (std::size_t n = 0; n < truth.pixels.size(); ++n)
            for (int c = 0; c < 3; ++c)
                squares += std::pow(static_cast<double>(image.pixels[n][c] - truth.pixels[n][c]), 2);
        return std::sqrt(squares / static_cast<double>(3 * truth.pixels.size()));
    }
    PixelSums sums;
    Image truth;
};

glm::vec3 even(int, int) {
    return {0.5f, 0.4f, 0.3f};
}

/// In an even picture a window's means have little of the noise, and no bias.
TEST(NoiseFilter, LeavesLittleOfEvenNoise) {
    const Noisy noisy({70, 50}, even, 0.1);
    const Image image = withoutNoise(noisy.sums);
    EXPECT_LT(noisy.errorOf(image), 0.2 * noisy.errorOf(noisy.sums.image()));
    glm::dvec4 mean(0);
    for (const glm::vec4& p : image.pixels)
        mean += glm::dvec4(p) / static_cast<double>(image.pixels.size());
    EXPECT_NEAR(mean.r, 0.5, 0.003);
    EXPECT_NEAR(mean.b, 0.3, 0.003);
    EXPECT_NEAR(mean.a, 1, 1e-12);
}

/// What is there in both sets stays: an edge, thin lines, a ramp.
TEST(NoiseFilter, KeepsWhatIsNoNoise) {
    const auto drawn = [](int x, int y) {
        return glm::vec3(x < 30 ? 0.1f : 0.8f, x % 8 == 0 ? 0.9f : 0.2f, 0.01f * static_cast<float>(y));
    };
    const Noisy quiet({64, 48}, drawn, 1e-4);
    EXPECT_LT(quiet.errorOf(withoutNoise(quiet.sums)), 1e-3);
    const Noisy noisy({64, 48}, drawn, 0.05);
    EXPECT_LT(noisy.errorOf(withoutNoise(noisy.sums)), 0.75 * noisy.errorOf(noisy.sums.image()));
}

/// A bright speck of one set is no reason for its neighbours to take it.
TEST(NoiseFilter, WeightsComeFromTheOtherHalf) {
    Noisy noisy({40, 40}, even, 0.02);
    const std::size_t speck = 20 * 40 + 20;
    noisy.sums.add(speck, 0, glm::vec4(400, 400, 400, 4), 4);
    const Image image = withoutNoise(noisy.sums);
    EXPECT_LT(image.pixels[speck].r, noisy.sums.mean(speck).r);
    for (const std::size_t beyond : {speck - 10, speck + 10, speck - 400, speck + 400})
        EXPECT_NEAR(image.pixels[beyond].r, 0.5f, 0.03f);
}

TEST(NoiseFilter, IsTheSameByAnyThreadsAndMirrors) {
    const auto drawn = [](int x, int y) {
        return glm::vec3(0.1f * static_cast<float>(x % 7), y < 20 ? 0 : 1, 0.3f);
    };
    const Noisy noisy({45, 37}, drawn, 0.1);
    const Image one = withoutNoise(noisy.sums, 1);
    EXPECT_EQ(one.pixels, withoutNoise(noisy.sums, 3).pixels);
    PixelSums mirrored({45, 37}, 8);
    for (int y = 0; y < 37; ++y)
        for (int x = 0; x < 45; ++x) {
            const auto from = static_cast<std::size_t>(y * 45 + x),
                       to = static_cast<std::size_t>(y * 45 + 44 - x);
            const glm::vec4 mean = noisy.sums.mean(from), offset = noisy.sums.offset(from);
            mirrored.add(to, 0, 4.0f * (mean + offset), 4);
            mirrored.add(to, 1, 4.0f * (mean - offset), 4);
        }
    const Image other = withoutNoise(mirrored);
    for (int y = 0; y < 37; ++y)
        for (int x = 0; x < 45; ++x)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(one.at(x, y)[c], other.at(44 - x, y)[c], 1e-4f) << x << " " << y;
}

TEST(NoiseFilter, LeavesPixelsWithoutBothSets) {
    PixelSums sums({20, 20}, 2);
    for (std::size_t n = 0; n < 400; ++n)
        sums.add(n, 0, glm::vec4(static_cast<float>(n)), 1);
    EXPECT_EQ(withoutNoise(sums).pixels, sums.image().pixels);
}

} // namespace
} // namespace tessera
