// Light that goes through surfaces: the response's integrals, its sampling, where ways through begin.
#include "tests/support/path_light.h"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace tessera {
namespace {

const glm::vec3 kN(0, 0, 1);

glm::vec3 slanted(double cosine) {
    return glm::vec3(std::sqrt(1 - cosine * cosine), 0, cosine);
}
SurfaceResponse responseOf(float mirrored, float translucent, float power) {
    SurfaceResponse response;
    response.mirrored = mirrored, response.translucent = translucent, response.power = power;
    return response;
}

/// Calls visit(direction, solid angle) for a grid of directions around an axis.
template <typename Visit> void overSphere(const glm::dvec3& axis, int fine, const Visit& visit) {
    const glm::dvec3 across =
        glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 up = glm::cross(axis, across);
    for (int row = 0; row < fine; ++row) // denser around the axis
        for (int column = 0; column < fine; ++column) {
            const double angle = M_PI * (row + 0.5) / fine, turn = 2 * M_PI * (column + 0.5) / fine;
            const glm::dvec3 d =
                std::cos(angle) * axis + std::sin(angle) * (std::cos(turn) * across + std::sin(turn) * up);
            visit(d, 2 * M_PI * M_PI / (double{1} * fine * fine) * std::sin(angle));
        }
}

/// Light of a white sky that a white surface sends towards v, by the formulas of docs/sampling.md.
double expectedLight(const SurfaceResponse& r, double cosine) {
    const glm::dvec3 v(slanted(cosine));
    const double f0 = static_cast<double>(r.mirrored), k = static_cast<double>(r.translucent),
                 q = static_cast<double>(r.power);
    const auto coat = [&](double c) { return f0 > 0 ? f0 + (1 - f0) * std::pow(1 - c, 5) : 0; };
    double sum = 0;
    overSphere(-v, 500, [&](const glm::dvec3& l, double angle) {
        const double below = (1 - coat(v.z)) * (1 - coat(std::abs(l.z))), along = -glm::dot(v, l);
        if (l.z > 0)
            sum += angle * l.z * (below * (1 - k) / M_PI);
        else if (q == 0)
            sum += angle * -l.z * below * k / M_PI;
        else if (along > 0)
            sum += angle * -l.z * below * k * (q + 2) / (2 * M_PI) * std::pow(along, q);
    });
    return sum;
}

TEST(TranslucentResponse, LetsThroughItsShareAndMakesNoLight) {
    for (const float mirrored : {0.0f, 0.1f})
        for (const float share : {0.3f, 1.0f})
            for (const float power : {0.0f, 0.5f, 1.0f, 10.0f, 200.0f})
                for (const double cosine : {1.0, 0.6, 0.1}) {
                    SCOPED_TRACE(testing::Message()
                                 << mirrored << " " << share << " " << power << " " << cosine);
                    const SurfaceResponse response = responseOf(mirrored, share, power);
                    double expected = expectedLight(response, cosine);
                    constexpr int kMany = 40000;
                    double sum = 0, squares = 0, green = 0, through = 0;
                    for (int path = 0; path < kMany; ++path) {
                        PathNumbers numbers(
                            {static_cast<float>(path % 4096), static_cast<float>(path / 4096)}, 2);
                        glm::vec3 l, light(0);
                        const float choice = numbers.next(), a = numbers.next(), b = numbers.next();
                        if (!response.sample({1, 0.5f, 0}, kN, slanted(cosine), choice, a, b, l, light))
                            continue;
                        // Blue is what the coat mirrors alone.
                        const double red = static_cast<double>(light.r - light.b);
                        sum += red, squares += red * red;
                        green += static_cast<double>(light.g - light.b);
                        through += l.z < 0 ? red : 0;
                    }
                    const double mean = sum / kMany,
                                 error = std::sqrt(std::max(squares / kMany - mean * mean, 0.0) / kMany);
                    EXPECT_NEAR(mean, expected, 4 * error + 1e-3);
                    EXPECT_NEAR(green, 0.5 * sum, 1e-3 * sum + 1e-6);
                    EXPECT_LE(mean, 1 + 4 * error + 1e-4);
                    if (mirrored == 0 && (power == 0 || cosine == 1.0)) {
                        EXPECT_NEAR(mean, 1, 4 * error + 1e-3);
                        EXPECT_NEAR(through / kMany, static_cast<double>(share), 0.02);
                    }
                }
}

TEST(TranslucentResponse, IsTheSameBothWaysAndNothingWithoutAShare) {
    const glm::vec3 albedo(0.9f, 0.5f, 0.1f), v = slanted(0.7);
    for (const glm::vec3& to : {glm::vec3(-0.3f, 0.1f, -0.9f), {-0.8f, 0.2f, -0.3f}}) {
        const glm::vec3 l = glm::normalize(to);
        for (const float power : {0.0f, 3.0f, 40.0f}) {
            const SurfaceResponse response = responseOf(0.1f, 0.6f, power);
            const float there = response.of(albedo, kN, v, l).g;
            EXPECT_NEAR(there, response.of(albedo, -kN, l, v).g, 1e-5f * there);
            EXPECT_GT(there, 0);
        }
        EXPECT_EQ(responseOf(0.1f, 0, 3).of(albedo, kN, v, l), glm::vec3(0));
        EXPECT_EQ(responseOf(0.1f, 0, 3).density(kN, v, l), 0);
    }
}

/// Chi squared of directions in cells of height and turn, those that are no directions in one of their own.
TEST(TranslucentResponse, DrawsDirectionsByTheDensityThatItTells) {
    constexpr int kMany = 1000000, kHeights = 10, kTurns = 8;
    const auto cellOf = [](const glm::dvec3& d) {
        const int height = std::min(static_cast<int>((d.z + 1) / 2 * kHeights), kHeights - 1);
        const double turn = std::atan2(d.y, d.x) / (2 * M_PI) + 0.5;
        return static_cast<std::size_t>(height * kTurns +
                                        std::min(static_cast<int>(turn * kTurns), kTurns - 1));
    };
    for (const float power : {0.0f, 2.0f, 30.0f})
        for (const double cosine : {1.0, 0.4}) {
            const SurfaceResponse response = responseOf(0.05f, 0.7f, power);
            std::vector<double> met(kHeights * kTurns + 1), expected(met.size());
            for (int n = 0; n < kMany; ++n) {
                PathNumbers numbers({static_cast<float>(n % 4096), static_cast<float>(n / 4096)}, 5);
                glm::vec3 l, share;
                const float choice = numbers.next(), a = numbers.next(), b = numbers.next();
                const bool any =
                    response.sample(glm::vec3(0.5f), kN, slanted(cosine), choice, a, b, l, share);
                ++met[any ? cellOf(glm::dvec3(l)) : met.size() - 1];
            }
            expected.back() = kMany;
            overSphere(-glm::dvec3(slanted(cosine)), 3000, [&](const glm::dvec3& l, double angle) {
                const double here =
                    kMany * angle * static_cast<double>(response.density(kN, slanted(cosine), glm::vec3(l)));
                expected[cellOf(l)] += here, expected.back() -= here;
            });
            double chi = 0;
            int cells = -1;
            for (std::size_t cell = 0; cell < met.size(); ++cell)
                if (expected[cell] > 1000)
                    chi += std::pow(met[cell] - expected[cell], 2) / expected[cell], ++cells;
            EXPECT_LT(chi, cells + 5 * std::sqrt(2.0 * cells)) << power << " " << cosine;
            EXPECT_GT(cells, 30);
        }
}

/// Ways through a surface begin as far below it as others above, and end at a lamp behind it.
TEST(TranslucentWays, BeginBelowTheSurface) {
    const PathVolume volume(
        {40, 40, 40}, [](const glm::ivec3&) { return 0.1f; }, 0.1, glm::dvec3(1));
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    lamp.position = {20, 20, 30};
    Transport transport = transportOf(4);
    transport.surface = SurfaceScattering{{40, 160}, {0, 1, 1, 4}}; // all goes through
    const PathScene scene = volume.scene(transport, {lamp});
    PathWork work;
    PathTracer tracer(scene, volume, work);
    TracedPath path(scene, {1.5f, 2.5f});
    path.p = {20, 20, 20};
    path.travel = {0, 0, 1};
    path.tissue.albedo = glm::vec3(0.5f);
    Way way;
    ASSERT_TRUE(tracer.aim(path, {0, 0, 500}, way));
    ASSERT_TRUE(path.isSurface);
    const float below = scene.leavesFromMm;
    EXPECT_NEAR(way.from.z, 20 + below, 1e-4f);
    EXPECT_NEAR(way.mm, 10 - below, 1e-4f);
    EXPECT_NEAR(path.shine.r, 0.5f * 6 / (2 * M_PI) * M_PI, 1e-4f); // of a lobe's middle
    ASSERT_TRUE(tracer.turn(path, way));
    EXPECT_NEAR(way.from.z, 20 + below, 1e-4f);
    EXPECT_GT(path.travel.z, 0);
}

/// Course notes 8.22, 8.23: the power q + 1 of a lobe's cosines is even.
TEST(PhongLobes, HaveEvenPowersOfTheirCosines) {
    constexpr int kMany = 1000000, kCells = 64;
    for (const double power : {0.5, 1.0, 5.0, 20.0, 100.0, 1000.0}) {
        std::vector<int> met(kCells);
        double worst = 0;
        for (int n = 0; n < kMany; ++n) {
            PathNumbers numbers({static_cast<float>(n % 4096), static_cast<float>(n / 4096)}, 9);
            const float u = numbers.next();
            const double c = static_cast<double>(SurfaceResponse::lobeCosine(static_cast<float>(power), u));
            worst = std::max(worst, std::abs(c - std::pow(1 - static_cast<double>(u), 1 / (power + 1))));
            ++met[static_cast<std::size_t>(
                std::min(static_cast<int>(std::pow(c, power + 1) * kCells), kCells - 1))];
        }
        EXPECT_LT(worst, 3e-7) << power;
        double chi = 0;
        for (const int count : met)
            chi += std::pow(count - double{kMany} / kCells, 2) / (double{kMany} / kCells);
        EXPECT_LT(chi, kCells + 5 * std::sqrt(2.0 * kCells)) << power;
        for (const double x : {1.0, 0.9, 0.3})
            EXPECT_NEAR(static_cast<double>(
                            SurfaceResponse::powerOf(static_cast<float>(x), static_cast<float>(power))),
                        std::pow(x, power), 1e-6)
                << power << " " << x;
    }
}

} // namespace
} // namespace tessera
