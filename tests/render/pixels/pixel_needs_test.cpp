// tests/render/pixels/pixel_needs_test.cpp: errors and needs of pixels, and the filter of noise, each written
// out once more in double from what their headers say, on pictures of unlike widths and heights.
#include "core/image/colour.h"
#include "render/pixels/noise_filter.h"
#include "render/pixels/pixel_places.h"
#include "render/pixels/pixel_sums.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <vector>

namespace tessera {
namespace {

/// A picture of which some pixels have two sets, some unlike ones, some one, some a middle alone.
struct Sampled {
    struct Pixel {
        glm::dvec4 sum[2] = {glm::dvec4(0), glm::dvec4(0)}, middle{0};
        int samples[2] = {0, 0};
        int all() const { return samples[0] + samples[1]; }
        bool both() const { return samples[0] > 0 && samples[1] > 0; }
        glm::dvec4 mean() const { return all() > 0 ? (sum[0] + sum[1]) / double(all()) : middle; }
        /// Half the difference of both sets, scaled so that its square has the mean's variance.
        glm::dvec4 offset() const {
            const double a = samples[0], b = samples[1];
            return (sum[0] / a - sum[1] / b) * std::sqrt(1 / (1 / a + 1 / b) / (a + b));
        }
    };
    Sampled(const glm::ivec2& extent, bool allSampled) : size(extent), sums(extent, 64) {
        std::mt19937 random(static_cast<unsigned>(extent.x));
        std::uniform_real_distribution<double> unit(0, 1);
        for (int i = 0; i < size.x * size.y; ++i) {
            Pixel& p = pixels.emplace_back();
            const double light = i % 11 == 0 ? 0.001 : 0.1 + 0.8 * (i % size.x) / size.x;
            const auto colour = [&](double noise) {
                return glm::dvec4(
                    light + noise * (unit(random) - 0.5), 0.7 * light + noise * (unit(random) - 0.5),
                    0.2 + noise * (unit(random) - 0.5), i % 13 == 5 ? 0.002 : 0.6 + 0.3 * unit(random));
            };
            p.middle = colour(0.05);
            sums.setMiddle(static_cast<std::size_t>(i), glm::vec4(p.middle));
            for (int set = 0; set < 2; ++set) {
                const int count = allSampled || i % 3 == 0 ? 4 : i % 3 == 1 ? 5 * (1 - set) + 3 * set : 0;
                if (count == 0 || (!allSampled && i % 17 == 1 && set == 1))
                    continue;
                p.samples[set] = count;
                p.sum[set] = double(count) * colour(0.2);
                sums.add(static_cast<std::size_t>(i), set, p.sum[set], count);
            }
        }
    }
    const Pixel& at(int x, int y) const {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                      static_cast<std::size_t>(x)];
    }
    glm::ivec2 size;
    std::vector<Pixel> pixels;
    PixelSums sums;
};

double square(const glm::dvec4& v) {
    return glm::dot(v, v);
}

TEST(PixelErrors, AreThoseOfTheirSets) {
    for (const bool all : {true, false}) {
        const Sampled s({23, 17}, all);
        const Image errors = s.sums.errors(), image = s.sums.image();
        double squares = 0;
        std::vector<double> luv;
        for (std::size_t i = 0; i < s.pixels.size(); ++i) {
            const Sampled::Pixel& p = s.pixels[i];
            const glm::dvec4 off = p.both() ? p.offset() : glm::dvec4(0);
            for (int c = 0; c < 4; ++c) {
                ASSERT_NEAR(errors.pixels[i][c], std::abs(off[c]), 1e-6);
                ASSERT_NEAR(image.pixels[i][c], p.mean()[c], 1e-6);
            }
            if (!(p.mean().a > 1.0 / 255))
                continue;
            squares += square(off) / 4;
            const auto seen = [](const glm::dvec4& v) {
                return luvFromLinear(glm::clamp(glm::dvec3(v), 0.0, 1.0));
            };
            luv.push_back(glm::length(seen(p.mean() + off) - seen(p.mean())));
        }
        ASSERT_LT(luv.size(), s.pixels.size()) << "some show nothing";
        std::sort(luv.begin(), luv.end());
        double mean = 0;
        for (const double e : luv)
            mean += e / static_cast<double>(luv.size());
        const StandardError e = standardError(s.sums);
        EXPECT_NEAR(e.rms, std::sqrt(squares / static_cast<double>(luv.size())), 1e-6);
        EXPECT_NEAR(rmsError(s.sums), e.rms, 1e-12);
        EXPECT_NEAR(e.luvMean, mean, 1e-3);
        EXPECT_NEAR(e.luvP99, luv[static_cast<std::size_t>(0.99 * static_cast<double>(luv.size() - 1))],
                    1e-2);
    }
}

// Needs that are brought up to date are those that are estimated anew: corners, edges and small pictures,
// too.
/// Of large pictures no value is kept, and the 99th percentile is found by its bits.
TEST(PixelErrors, AreThoseOfPixelsOneByOne) {
    for (const glm::ivec2 size : {glm::ivec2(3, 2), {37, 29}}) {
        const Sampled picture(size, false);
        const StandardError expected = standardError(picture.sums);
        ASSERT_GT(expected.luvP99, 0);
        const Image means = picture.sums.image(), offsets = picture.sums.offsets();
        for (const std::size_t kept : {0, 5, 100000}) {
            const StandardError e = standardError(
                [&](const auto& visit) {
                    for (std::size_t i = 0; i < means.pixels.size(); ++i)
                        visit(means.pixels[i], offsets.pixels[i]);
                },
                kept);
            EXPECT_EQ(e.rms, expected.rms);
            EXPECT_EQ(e.luvMean, expected.luvMean);
            EXPECT_EQ(e.luvP99, expected.luvP99) << kept;
        }
    }
}

TEST(PixelNeeds, FollowNewSamples) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> light(0, 1);
    const PixelTarget target;
    for (const glm::ivec2& size :
         {glm::ivec2(23, 17), glm::ivec2(2, 9), glm::ivec2(8, 1), glm::ivec2(5, 5)}) {
        Sampled s(size, false);
        std::vector<float> needs = sampleNeeds(s.sums, target);
        const std::vector<float> before = needs;
        for (int turn = 0; turn < 4; ++turn) {
            std::vector<std::uint32_t> sampled = {0, static_cast<std::uint32_t>(s.sums.count() - 1)};
            for (int n = 0; n < turn; ++n)
                sampled.push_back(static_cast<std::uint32_t>(random() % s.sums.count()));
            for (const std::uint32_t pixel : sampled)
                for (int set = 0; set < 2; ++set)
                    s.sums.add(pixel, set, {light(random), light(random), light(random), light(random)}, 1);
            updateNeeds(s.sums, target, sampled, 2, needs);
            EXPECT_EQ(needs, sampleNeeds(s.sums, target)) << size.x << "x" << size.y << " " << turn;
        }
        EXPECT_NE(needs, before);
    }
}

// The need of a pixel: two thirds of its own variance and one of its neighbours' (half as much), against
// light and lightness; of a pixel with a middle alone the scatter about a plane through the nine around.
TEST(PixelNeeds, AreThoseOfTheirFormula) {
    const PixelTarget target;
    EXPECT_EQ(target.linear, 1.0 / 255);
    EXPECT_EQ(target.lightness, 1.2);
    for (const glm::ivec2& size : {glm::ivec2(23, 17), glm::ivec2(2, 9), glm::ivec2(8, 1)}) {
        const Sampled s(size, false);
        const std::vector<float> needs = sampleNeeds(s.sums, target, 2);
        ASSERT_EQ(needs.size(), s.pixels.size());
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const Sampled::Pixel& p = s.at(x, y);
                double variance = 0;
                if (p.both()) {
                    double around = 0, count = 0;
                    for (int dy = -1; dy <= 1; ++dy)
                        for (int dx = -1; dx <= 1; ++dx) {
                            const glm::ivec2 at(x + dx, y + dy);
                            if ((dx == 0 && dy == 0) || at.x < 0 || at.y < 0 || at.x >= size.x ||
                                at.y >= size.y || !s.at(at.x, at.y).both())
                                continue;
                            around += square(s.at(at.x, at.y).offset()) * s.at(at.x, at.y).all();
                            ++count;
                        }
                    around = count > 0 ? around / count / p.all() : 0;
                    variance = 2.0 / 3 * square(p.offset()) + 1.0 / 3 * around;
                } else {
                    // The nine around, moved inside; least squares of a plane over a 3x3 grid.
                    const glm::ivec2 middle(std::clamp(x, 1, std::max(1, size.x - 2)),
                                            std::clamp(y, 1, std::max(1, size.y - 2)));
                    for (int c = 0; c < 4; ++c) {
                        double v[3][3], mean = 0, right = 0, down = 0;
                        for (int j = 0; j < 3; ++j)
                            for (int i = 0; i < 3; ++i) {
                                v[j][i] = s.at(std::min(middle.x + i - 1, size.x - 1),
                                               std::min(middle.y + j - 1, size.y - 1))
                                              .mean()[c];
                                mean += v[j][i] / 9, right += (i - 1) * v[j][i] / 6,
                                    down += (j - 1) * v[j][i] / 6;
                            }
                        for (int j = 0; j < 3; ++j)
                            for (int i = 0; i < 3; ++i)
                                variance +=
                                    std::pow(v[j][i] - mean - (i - 1) * right - (j - 1) * down, 2) / 6;
                    }
                }
                const double off = std::sqrt(variance / 4);
                const glm::dvec4 mean = p.mean();
                const double light =
                    glm::clamp(0.2126 * mean.r + 0.7152 * mean.g + 0.0722 * mean.b, 0.0, 1.0) + off;
                // L* = 116 t^(1/3) - 16, below 216/24389 a straight line: CIE 1976.
                const double slope =
                    light > 216.0 / 24389 ? 116.0 / 3 * std::pow(light, -2.0 / 3) : 24389.0 / 27;
                const double expected = std::max(off * 255, off * slope / 1.2);
                ASSERT_NEAR(needs[static_cast<std::size_t>(y * size.x + x)], expected, 1e-3 + 1e-3 * expected)
                    << size.x << " by " << size.y << ": " << x << "," << y;
            }
    }
}

// Positions of the Gaussian filter have its distribution, of deviation 0.5, cut at 1.5 pixels.
TEST(FilteredOffsets, InvertTheirDistribution) {
    EXPECT_EQ(filteredOffset(0, PixelFilter::box), -0.5);
    EXPECT_EQ(filteredOffset(0.75, PixelFilter::box), 0.25);
    const auto below = [](double x) { return 0.5 * std::erfc(-x / 0.5 / std::sqrt(2.0)); };
    const double cut = below(-1.5), whole = below(1.5) - cut;
    for (double u = 0; u <= 1; u += 1.0 / 512) {
        const double x = filteredOffset(u, PixelFilter::gaussian);
        EXPECT_NEAR((below(x) - cut) / whole, u, 1e-8) << u;
        EXPECT_NEAR(filteredOffset(1 - u, PixelFilter::gaussian), -x, 1e-7);
    }
    for (const double u : {1e-4, 0.003, 0.02, 0.022, 0.0245, 0.026, 0.9755, 0.978, 0.9999})
        EXPECT_NEAR((below(filteredOffset(u, PixelFilter::gaussian)) - cut) / whole, u, 1e-8) << u;
}

// docs/sampling.md: a pixel of one half is the mean of those around it, 13x13, by how alike patches of 7x7
// are in the other half, in units of their noise; the variance of a pixel is the mean over 5x5 of its squared
// offsets, of a half twice that. Beyond the picture stands its border, but no pixel is taken from there.
TEST(NoiseFilter, IsItsFormula) {
    const Sampled s({19, 21}, true);
    const glm::ivec2 size = s.size;
    const auto at = [&](int x, int y) -> const Sampled::Pixel& {
        return s.at(std::clamp(x, 0, size.x - 1), std::clamp(y, 0, size.y - 1));
    };
    const auto half = [&](int h, int x, int y, int c) {
        return at(x, y).mean()[c] + (h == 0 ? 1 : -1) * at(x, y).offset()[c];
    };
    // By pixel of the padded picture.
    constexpr int kPad = 9 + 3;
    const int width = size.x + 2 * kPad;
    std::vector<glm::dvec3> variances;
    for (int y = -kPad; y < size.y + kPad; ++y)
        for (int x = -kPad; x < size.x + kPad; ++x) {
            glm::dvec3 sum(0);
            for (int dy = -2; dy <= 2; ++dy)
                for (int dx = -2; dx <= 2; ++dx) {
                    const glm::dvec3 off(at(x + dx, y + dy).offset());
                    sum += 2.0 * off * off / 25.0;
                }
            variances.push_back(sum);
        }
    const auto variance = [&](int x, int y, int c) {
        return variances[static_cast<std::size_t>((y + kPad) * width + x + kPad)][c];
    };
    const Image found = withoutNoise(s.sums, 1);
    for (const glm::ivec2& pixel :
         {glm::ivec2(0, 0), glm::ivec2(18, 20), glm::ivec2(9, 10), glm::ivec2(3, 16), glm::ivec2(16, 15),
          glm::ivec2(18, 4), glm::ivec2(6, 0)}) {
        glm::dvec3 sum[2] = {glm::dvec3(0), glm::dvec3(0)};
        double weights[2] = {0, 0};
        for (int dy = -6; dy <= 6; ++dy)
            for (int dx = -6; dx <= 6; ++dx) {
                const glm::ivec2 other = pixel + glm::ivec2(dx, dy);
                if (other.x < 0 || other.y < 0 || other.x >= size.x || other.y >= size.y)
                    continue;
                for (int h = 0; h < 2; ++h) {
                    double distance = 0;
                    for (int v = -3; v <= 3; ++v)
                        for (int u = -3; u <= 3; ++u)
                            for (int c = 0; c < 3; ++c) {
                                const double a = variance(pixel.x + u, pixel.y + v, c),
                                             b = variance(other.x + u, other.y + v, c);
                                const double d = half(h, pixel.x + u, pixel.y + v, c) -
                                                 half(h, other.x + u, other.y + v, c);
                                distance +=
                                    (d * d - (a + std::min(a, b))) / (1e-10 + 0.25 * (a + b)) / (3 * 49);
                            }
                    const double weight = std::exp(-std::max(0.0, distance));
                    weights[1 - h] += weight;
                    for (int c = 0; c < 3; ++c)
                        sum[1 - h][c] += weight * half(1 - h, other.x, other.y, c);
                }
            }
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found.at(pixel.x, pixel.y)[c],
                        0.5 * (sum[0][c] / weights[0] + sum[1][c] / weights[1]), 2e-5)
                << pixel.x << "," << pixel.y;
        EXPECT_NEAR(found.at(pixel.x, pixel.y).a, s.at(pixel.x, pixel.y).mean().a, 1e-6);
    }
}

} // namespace
} // namespace tessera
