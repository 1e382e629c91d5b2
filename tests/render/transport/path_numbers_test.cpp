// Random numbers of paths, and what is made of them: distances, directions, phase functions.
#include "render/transport/path_numbers.h"
#include "render/transport/phase.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace tessera {
namespace {

constexpr int kMany = 1000000;

PathNumbers numbersOf(int path, std::uint32_t seed = 7) {
    return {glm::vec2(static_cast<float>(path % 1000) + 0.5f, static_cast<float>(path / 1000) + 0.25f), seed};
}

/// The n-th draws of a million paths.
std::vector<float> draws(int n, std::uint32_t seed = 7) {
    std::vector<float> out;
    for (int path = 0; path < kMany; ++path) {
        PathNumbers numbers = numbersOf(path, seed);
        for (int k = 0; k < n; ++k)
            numbers.next();
        out.push_back(numbers.next());
    }
    return out;
}

double correlation(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n)
        sum += (static_cast<double>(a[n]) - 0.5) * (static_cast<double>(b[n]) - 0.5);
    return 12 * sum / static_cast<double>(a.size());
}

TEST(PathNumbers, AreUniformInEveryDraw) {
    for (const int n : {0, 1, 2, 17, 200}) {
        std::array<int, 64> bins{};
        double sum = 0;
        for (const float u : draws(n)) {
            ASSERT_TRUE(u >= 0 && u < 1);
            ++bins[static_cast<std::size_t>(64 * u)];
            sum += static_cast<double>(u);
        }
        EXPECT_NEAR(sum / kMany, 0.5, 4 * std::sqrt(1.0 / 12 / kMany)) << n;
        double chi = 0;
        for (const int bin : bins)
            chi += std::pow(bin - kMany / 64.0, 2) / (kMany / 64.0);
        EXPECT_LT(chi, 63 + 4 * std::sqrt(2 * 63.0)) << n;
    }
}

TEST(PathNumbers, DrawsAndNeighboursAndSeedsAreUnrelated) {
    const std::vector<float> first = draws(0);
    for (const int n : {1, 2, 3, 17})
        EXPECT_LT(std::abs(correlation(first, draws(n))), 0.004) << n;
    EXPECT_LT(std::abs(correlation(first, draws(0, 8))), 0.004);
    std::vector<float> next(first.begin() + 1, first.end()), under(first.begin() + 1000, first.end());
    next.push_back(first.front());
    under.insert(under.end(), first.begin(), first.begin() + 1000);
    EXPECT_LT(std::abs(correlation(first, next)), 0.004);
    EXPECT_LT(std::abs(correlation(first, under)), 0.004);
}

TEST(PathNumbers, FollowFromPlaceSeedAndDrawAlone) {
    PathNumbers a = numbersOf(12345), b = numbersOf(12345), other({1.5f, 0.5f}, 7), turned({0.5f, 1.5f}, 7);
    for (int n = 0; n < 8; ++n)
        EXPECT_EQ(a.next(), b.next());
    EXPECT_NE(other.next(), turned.next());
    EXPECT_EQ(a.draws(), 8u);
}

std::vector<std::array<glm::vec2, 4>> pairsOf(const glm::ivec2& pixel, std::uint32_t set, std::uint32_t first,
                                              int count, std::uint32_t seed = 9) {
    std::vector<std::array<glm::vec2, 4>> all;
    for (int n = 0; n < count; ++n) {
        PathNumbers numbers(glm::vec2(pixel) + glm::vec2(0.3f, 0.001f * static_cast<float>(n)), seed);
        numbers.setSample(2 * (first + static_cast<std::uint32_t>(n)) + set);
        std::array<glm::vec2, 4> pairs;
        for (std::uint32_t k = 0; k < 4; ++k)
            pairs[k] = numbers.pair(k);
        all.push_back(pairs);
    }
    return all;
}

/// The first 64 samples of a set, and of its further nets, give every pair as strata: in all boxes of 1/64 is
/// one.
TEST(PathNumbers, PairsOfASetAreStrata) {
    for (const glm::ivec2 pixel : {glm::ivec2(0, 0), {17, 3}, {511, 700}})
        for (const std::uint32_t first : {0u, 64u, 128u, 256u}) {
            const auto all = pairsOf(pixel, 1, first, 64);
            for (std::size_t number = 0; number < 4; ++number)
                for (int across = 0; across <= 6; ++across) {
                    std::vector<int> boxes(64);
                    for (const auto& pairs : all)
                        ++boxes[static_cast<std::size_t>(pairs[number].x * static_cast<float>(1 << across)) *
                                    (std::size_t{1} << (6 - across)) +
                                static_cast<std::size_t>(pairs[number].y *
                                                         static_cast<float>(1 << (6 - across)))];
                    EXPECT_EQ(std::count(boxes.begin(), boxes.end(), 1), 64) << number << " " << across;
                }
        }
}

/// In one pixel, and over pixels, every pair is uniform and unrelated to the others: all quadrants of any two
/// numbers are met alike.
TEST(PathNumbers, PairsAreUnrelated) {
    const auto numberOf = [](const std::array<glm::vec2, 4>& pairs, std::size_t n) {
        return n % 2 == 0 ? pairs[n / 2].x : pairs[n / 2].y;
    };
    const auto check = [&](const std::vector<std::array<glm::vec2, 4>>& all, double most) {
        for (std::size_t a = 0; a < 8; ++a)
            for (std::size_t b = 0; b < a; ++b) {
                std::array<int, 16> boxes{};
                for (const auto& pairs : all)
                    ++boxes[static_cast<std::size_t>(4 * numberOf(pairs, a)) +
                            4 * static_cast<std::size_t>(4 * numberOf(pairs, b))];
                for (const int box : boxes)
                    EXPECT_NEAR(static_cast<double>(box) * 16 / static_cast<double>(all.size()), 1, most)
                        << a << " " << b;
            }
    };
    check(pairsOf({7, 5}, 0, 0, 1 << 15), 0.12);
    std::vector<std::array<glm::vec2, 4>> over;
    for (int pixel = 0; pixel < 100000; ++pixel)
        over.push_back(pairsOf({pixel % 317, pixel / 317}, static_cast<std::uint32_t>(pixel) % 2, 5, 1)[0]);
    check(over, 0.06);
}

/// The two sets of a pixel have nothing in common: means over one tell nothing of those over the other.
TEST(PathNumbers, SetsAreIndependent) {
    double sum = 0, squares = 0;
    constexpr int kPixels = 4000;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
        double means[2] = {};
        for (std::uint32_t set = 0; set < 2; ++set)
            for (const auto& pairs : pairsOf({pixel, 3}, set, 0, 16))
                means[set] +=
                    (static_cast<double>(pairs[0].x) - 0.5) * (static_cast<double>(pairs[2].x) - 0.5) / 16;
        sum += means[0] * means[1];
        squares += 0.5 * (means[0] * means[0] + means[1] * means[1]);
    }
    EXPECT_LT(std::abs(sum / squares), 4 / std::sqrt(kPixels));
}

TEST(PathNumbers, DistancesAreExponential) {
    EXPECT_EQ(exponentialOf(0), 0);
    for (int n = 1; n < 1 << 24; n += 97) {
        const double u = n * 0x1p-24, expected = -std::log1p(-u);
        ASSERT_NEAR(static_cast<double>(exponentialOf(static_cast<float>(u))), expected,
                    1e-6 * expected + 1e-9)
            << n;
    }
    EXPECT_NEAR(exponentialOf(1 - 0x1p-24f), 24 * std::log(2.0f), 1e-5f);
}

TEST(PathNumbers, TurnsAreCosinesAndSines) {
    for (int n = 0; n <= 100000; ++n) {
        const float u = static_cast<float>(n) * 1e-5f;
        const double angle = 2 * M_PI * static_cast<double>(u);
        const glm::vec2 turn = turnedBy(u);
        ASSERT_NEAR(static_cast<double>(turn.x), std::cos(angle), 4e-7) << u;
        ASSERT_NEAR(static_cast<double>(turn.y), std::sin(angle), 4e-7) << u;
    }
}

TEST(PathNumbers, DirectionsLieAroundTheirAxis) {
    for (int path = 0; path < 2000; ++path) {
        PathNumbers numbers = numbersOf(path);
        const float z = 2 * numbers.next() - 1;
        const glm::vec2 turn = turnedBy(numbers.next());
        glm::vec3 axis(std::sqrt(std::max(0.0f, 1 - z * z)) * turn, z);
        if (path < 6) { // along the axes
            axis = glm::vec3(0);
            axis[path % 3] = path < 3 ? 1.0f : -1.0f;
        }
        const float cosine = 2 * numbers.next() - 1, u = numbers.next();
        const glm::vec3 d = directionAround(axis, cosine, u);
        EXPECT_NEAR(glm::length(d), 1, 1e-6f);
        EXPECT_NEAR(glm::dot(d, axis), cosine, 2e-6f);
        // Half a turn further it lies on the other side.
        const glm::vec3 across = directionAround(axis, cosine, u < 0.5f ? u + 0.5f : u - 0.5f);
        EXPECT_NEAR(glm::length(d + across - 2 * cosine * axis), 0, 4e-6f);
    }
}

std::vector<Phase> phases() {
    std::vector<Phase> all;
    for (const double g : {-0.99, -0.5, 0.0, 5e-4, 0.3, 0.8, 0.99})
        all.push_back({PhaseKind::henyeyGreenstein, g});
    for (const double g : {-0.9, 0.0, 0.6, 0.95})
        all.push_back({PhaseKind::schlick, g});
    all.push_back({PhaseKind::rayleigh});
    all.push_back({PhaseKind::henyeyGreenstein, 0.8, -0.4, 0.25});
    return all;
}

/// Integral over the sphere of f(cosine), by the midpoint rule on a grid that is finer towards both ends.
template <typename F> double overSphere(const F& f) {
    double sum = 0;
    constexpr int kSteps = 400000;
    for (int n = 0; n < kSteps; ++n) {
        const double a = M_PI * (n + 0.5) / kSteps;
        sum += 2 * M_PI * std::sin(a) * (M_PI / kSteps) * f(std::cos(a));
    }
    return sum;
}

TEST(Phase, IntegratesToOneWithItsMeanCosine) {
    for (const Phase& phase : phases()) {
        const auto p = [&](double c) { return static_cast<double>(phaseOf(phase, static_cast<float>(c))); };
        EXPECT_NEAR(overSphere(p), 1, std::abs(phase.g) > 0.9 ? 1e-3 : 2e-6) << phase.g;
        if (phase.kind == PhaseKind::schlick)
            continue;
        // lobeOf: a lobe of less than a thousandth is even.
        const bool isEven = phase.kind == PhaseKind::rayleigh || std::abs(phase.g) < 1e-3F;
        const double mean = isEven ? 0 : (1 - phase.backShare) * phase.g + phase.backShare * phase.backG;
        EXPECT_NEAR(overSphere([&](double c) { return c * p(c); }), mean,
                    std::abs(phase.g) > 0.9 ? 1e-3 : 2e-6)
            << phase.g;
    }
}

TEST(Phase, IsSampledByItsDensity) {
    for (const Phase& phase : phases()) {
        // Narrow lobes are a few cosines wide in float.
        const int kBins = std::abs(phase.g) > 0.9 ? 8 : 40;
        std::vector<double> expected(static_cast<std::size_t>(kBins));
        std::vector<int> found(static_cast<std::size_t>(kBins));
        // Bins of equal chance by the numerical distribution of the cosine.
        std::vector<double> upTo;
        constexpr int kSteps = 200000;
        double sum = 0;
        for (int n = 0; n < kSteps; ++n) {
            const double a = M_PI * (1 - (n + 0.5) / kSteps);
            sum += 2 * M_PI * std::sin(a) * (M_PI / kSteps) *
                   static_cast<double>(phaseOf(phase, static_cast<float>(std::cos(a))));
            upTo.push_back(sum);
        }
        const auto bin = [&](double cosine) {
            const double a = std::acos(std::clamp(cosine, -1.0, 1.0));
            const double place = (1 - a / M_PI) * kSteps;
            const auto at = static_cast<std::size_t>(std::clamp(place, 0.0, kSteps - 1.0));
            return std::clamp(static_cast<int>(kBins * upTo[at] / sum), 0, kBins - 1);
        };
        for (int n = 0; n < kSteps; ++n) {
            const double mass =
                upTo[static_cast<std::size_t>(n)] - (n > 0 ? upTo[static_cast<std::size_t>(n) - 1] : 0);
            const double a = M_PI * (1 - (n + 0.5) / kSteps);
            expected[static_cast<std::size_t>(bin(std::cos(a)))] += mass / sum;
        }
        for (int path = 0; path < kMany; ++path) {
            PathNumbers numbers = numbersOf(path, 3);
            ++found[static_cast<std::size_t>(bin(
                static_cast<double>(phaseCosine(phase, numbers.next(), [&] { return numbers.next(); }))))];
        }
        double chi = 0;
        for (std::size_t n = 0; n < found.size(); ++n)
            chi += std::pow(found[n] - kMany * expected[n], 2) / (kMany * expected[n]);
        EXPECT_LT(chi, kBins - 1 + 5 * std::sqrt(2.0 * kBins))
            << static_cast<int>(phase.kind) << " " << phase.g;
    }
}

} // namespace
} // namespace tessera
