// Light from all around: directions drawn by a picture of it, and paths lit by it against closed forms, other
// lights and paths that draw none.
#include "render/transport/environment_map.h"
#include "tests/support/path_light.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace tessera {
namespace {

/// Black, dim and bright texels, and rows without light.
std::vector<float> unevenWeights(const glm::ivec2& size) {
    std::vector<float> weights;
    std::mt19937 random(5);
    for (int row = 0; row < size.y; ++row)
        for (int column = 0; column < size.x; ++column) {
            const auto u = static_cast<float>(random() % 1000) / 1000;
            weights.push_back(row % 5 == 3 || u < 0.3f ? 0 : u < 0.35f ? 60 * u : u);
        }
    return weights;
}

double areaOf(const glm::ivec2& size, std::size_t texel) {
    const auto row = static_cast<double>(texel / static_cast<std::size_t>(size.x));
    return 2 * M_PI / size.x * (std::cos(M_PI * row / size.y) - std::cos(M_PI * (row + 1) / size.y));
}

std::shared_ptr<const EnvironmentMap> mapOf(const glm::ivec2& size, const std::vector<glm::vec3>& radiance) {
    return std::make_shared<const EnvironmentMap>(size, radiance);
}
Environment environmentOf(std::shared_ptr<const EnvironmentMap> map) {
    Environment environment;
    environment.file = {"sky.exr", std::move(map)};
    return environment;
}
/// Dim, with one texel that is bright.
constexpr glm::ivec2 kSunSize{512, 256};
std::shared_ptr<const EnvironmentMap> sunMap(const glm::ivec2& at, float radiance, float rest) {
    std::vector<glm::vec3> texels(static_cast<std::size_t>(kSunSize.x * kSunSize.y), glm::vec3(rest));
    texels[static_cast<std::size_t>(at.y * kSunSize.x + at.x)] = glm::vec3(radiance);
    return mapOf(kSunSize, texels);
}
/// Patient space, of an environment as it comes: the front is anterior.
glm::dvec3 middleOf(const glm::ivec2& size, const glm::ivec2& texel) {
    const double turn = 2 * M_PI * ((texel.x + 0.5) / size.x - 0.5), down = M_PI * (texel.y + 0.5) / size.y;
    return {-std::sin(down) * std::sin(turn), -std::sin(down) * std::cos(turn), std::cos(down)};
}

TEST(DirectionTables, DrawWhatTheirDensitySays) {
    constexpr int kMany = 1000000;
    for (const glm::ivec2 size : {glm::ivec2(2, 1), glm::ivec2(30, 15)}) {
        const std::vector<float> weights = unevenWeights(size);
        const DirectionTable table(size, weights);
        double whole = 0, scale = 0;
        for (std::size_t n = 0; n < weights.size(); ++n)
            scale += static_cast<double>(weights[n]) * areaOf(size, n);
        for (std::size_t n = 0; n < weights.size(); ++n) {
            const double expected = static_cast<double>(weights[n]) / scale,
                         found = static_cast<double>(table.densityAt(n));
            EXPECT_NEAR(found, expected, 1e-4 * expected + 1e-6);
            EXPECT_EQ(found > 0, weights[n] > 0);
            whole += found * areaOf(size, n);
        }
        EXPECT_NEAR(whole, 1, 1e-6);
        std::vector<int> met(weights.size());
        glm::dvec3 mean(0), expectedMean(0);
        std::mt19937 random(3);
        int elsewhere = 0;
        for (int n = 0; n < kMany; ++n) {
            const auto u = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
            const float a = u(), b = u();
            const DirectionTable::Drawn drawn = table.draw({a, b});
            ++met[drawn.texel];
            elsewhere += table.texelOf(drawn.direction) != drawn.texel; // next to a border, by rounding
            ASSERT_NEAR(glm::length(drawn.direction), 1, 1e-6f);
            mean += glm::dvec3(drawn.direction) / double{kMany};
        }
        EXPECT_LT(elsewhere, 40);
        double chi = 0;
        int bins = 0;
        for (std::size_t n = 0; n < weights.size(); ++n) {
            const double expected = kMany * static_cast<double>(table.densityAt(n)) * areaOf(size, n);
            if (!(expected > 0)) {
                EXPECT_EQ(met[n], 0);
                continue;
            }
            chi += std::pow(met[n] - expected, 2) / expected, ++bins;
        }
        EXPECT_LT(chi, bins - 1 + 5 * std::sqrt(2.0 * bins));
        // Within texels they are even over the sphere: their mean is that of the density, by fine quadrature.
        constexpr int kFine = 20;
        for (std::size_t n = 0; n < weights.size(); ++n)
            for (int part = 0; part < kFine * kFine; ++part) {
                const double column = static_cast<double>(n % static_cast<std::size_t>(size.x)),
                             row = static_cast<double>(n / static_cast<std::size_t>(size.x));
                const double down = M_PI * (row + (part / kFine + 0.5) / kFine) / size.y,
                             turn = 2 * M_PI * ((column + (part % kFine + 0.5) / kFine) / size.x - 0.5);
                expectedMean += static_cast<double>(table.densityAt(n)) * std::sin(down) * 2 * M_PI * M_PI /
                                (size.x * size.y * kFine * kFine) *
                                glm::dvec3(std::sin(down) * std::cos(turn), std::sin(down) * std::sin(turn),
                                           std::cos(down));
            }
        EXPECT_LT(glm::length(mean - expectedMean), 4 * std::sqrt(3.0 / kMany) + 2e-3);
    }
}

TEST(DirectionTables, FindTexelsAsTheirRowsAndColumnsSay) {
    const glm::ivec2 size(36, 18);
    const DirectionTable table(size, std::vector<float>(36 * 18, 1.0f));
    for (int row = 0; row < size.y; ++row)
        for (int column = 0; column < size.x; ++column) {
            const double down = M_PI * (row + 0.3) / size.y,
                         turn = 2 * M_PI * ((column + 0.7) / size.x - 0.5);
            EXPECT_EQ(table.texelOf(
                          {std::sin(down) * std::cos(turn), std::sin(down) * std::sin(turn), std::cos(down)}),
                      static_cast<std::size_t>(row * size.x + column));
        }
    for (const float z : {1.0f, -1.0f}) // the poles
        EXPECT_LT(table.texelOf({0, 0, z}), 36u * 18u);
    for (int n = 0; n < 10000; ++n) {
        const float x = std::cos(0.00123f * static_cast<float>(n * n)),
                    y = std::sin(0.7f * static_cast<float>(n));
        const double expected = std::atan2(static_cast<double>(y), static_cast<double>(x)) / (2 * M_PI);
        EXPECT_NEAR(turnOf(x, y), expected < 0 ? expected + 1 : expected, 2e-7);
    }
}

TEST(DirectionTables, OfNoLightDrawNothing) {
    EXPECT_FALSE(DirectionTable({4, 2}, std::vector<float>(8, 0.0f)).any());
    const PathVolume volume(
        {8, 8, 8}, [](const glm::ivec3&) { return 0.1f; }, 0.1);
    const Environment dark = environmentOf(mapOf({4, 2}, std::vector<glm::vec3>(8, glm::vec3(0))));
    EXPECT_EQ(volume.scene(transportOf(4), {}, dark).skyTable, nullptr);
    EXPECT_EQ(lightAgainst(volume, volume.scene(transportOf(4), {}, dark), {4, 0, 4}, {0, 1, 0}, 50).mean, 0);
}

/// Skies that are nearly even have no table: their pictures draw what they drew before there were any.
TEST(DirectionTables, AreOfFilesAndSoftboxesAlone) {
    const PathVolume volume(
        {8, 8, 8}, [](const glm::ivec3&) { return 0.1f; }, 0.1);
    for (const Sky sky : {Sky::uniform, Sky::overcast, Sky::twoTone})
        EXPECT_EQ(volume.scene(transportOf(4), {}, Environment{sky}).skyTable, nullptr);
    EXPECT_NE(volume.scene(transportOf(4), {}, Environment{Sky::softboxes}).skyTable, nullptr);
}

/// By even directions: the share of the sphere of a square pyramid, 4 asin(1/5), and where its middles are.
TEST(Environments, SoftboxesAreTwoSquaresAboveTheFront) {
    const PathVolume volume(
        {8, 8, 8}, [](const glm::ivec3&) { return 0.1f; }, 0.1);
    Environment boxes{Sky::softboxes, 2, glm::dvec3(1, 0.5, 0), glm::dvec3(0, 0.25, 1)};
    const PathScene scene = volume.scene(transportOf(4), {}, boxes);
    constexpr int kMany = 200000;
    glm::dvec3 sum(0), to[2] = {};
    for (int n = 0; n < kMany; ++n) {
        PathNumbers numbers({static_cast<float>(n % 512), static_cast<float>(n / 512)}, 1);
        const float a = numbers.next(), b = numbers.next();
        const glm::vec3 d = directionAround({0, 0, 1}, 1 - 2 * a, b), sky = skyFrom(scene, d);
        sum += glm::dvec3(sky);
        if (sky != glm::vec3(0))
            to[sky.r > 0 ? 0 : 1] += glm::dvec3(d);
    }
    const double share = std::asin(0.2) / M_PI, error = 4 * std::sqrt(share / kMany);
    EXPECT_NEAR(sum.r / kMany, 2 * share, 2 * error);
    EXPECT_NEAR(sum.b / kMany, 2 * share, 2 * error);
    EXPECT_NEAR(sum.g / kMany, 2 * share * 0.75, 2 * error);
    const double across = std::cos(M_PI / 6) * std::sqrt(0.5);
    EXPECT_LT(glm::length(glm::normalize(to[0]) - glm::dvec3(-across, -across, 0.5)),
              0.01); // patient's right
    EXPECT_LT(glm::length(glm::normalize(to[1]) - glm::dvec3(across, -across, 0.5)), 0.01);
}

TEST(Environments, TurnAboutUpAndStandInTheirFrame) {
    const glm::ivec2 size(8, 4);
    std::vector<glm::vec3> radiance;
    for (int n = 0; n < 32; ++n)
        radiance.emplace_back(static_cast<float>(n), 0, 0);
    const PathVolume volume(
        {8, 8, 8}, [](const glm::ivec3&) { return 0.1f; }, 0.1);
    Camera camera;
    camera.position = {100, 0, 0}, camera.focalPoint = {0, 0, 0}, camera.viewUp = {0, 0, 1};
    Environment environment = environmentOf(mapOf(size, radiance));
    environment.intensity = 2;
    const auto seen = [&](const glm::vec3& d) {
        return skyFrom(volume.scene(transportOf(4), {}, environment, camera), glm::normalize(d)).r / 2;
    };
    // Row 1 is above the horizon; column 4 begins in the middle and goes to the right, the patient's own.
    EXPECT_EQ(seen({-0.1f, -1, 0.1f}), 12);
    EXPECT_EQ(seen({0.1f, -1, 0.1f}), 11);
    EXPECT_EQ(seen({-1, 0.1f, -0.1f}), 22);
    environment.rotation = 90; // the front is the patient's left
    EXPECT_EQ(seen({1, -0.1f, 0.1f}), 12);
    EXPECT_EQ(seen({-0.1f, -1, 0.1f}), 14); // which is to the right of it
    environment.frame = LightFrame::camera; // towards the viewer, who is on the patient's left
    environment.rotation = 0;
    environment.up = {0, 1, 0};
    EXPECT_EQ(seen({1, -0.1f, 0.1f}), 12);
    EXPECT_EQ(seen({1, 0.1f, 0.1f}), 11);
}

/// A medium that takes no light cannot be told from a sky that is the same everywhere, in a file either.
TEST(Environments, AFileOfOneColourIsTheUniformSky) {
    const auto lumps = [](const glm::ivec3& i) {
        return (i.x / 5 + i.y / 7 + i.z / 3) % 3 == 0 ? 2.0f : 0.05f;
    };
    for (const double albedo : {1.0, 0.7}) {
        const PathVolume volume({24, 24, 24}, lumps, 2, glm::dvec3(albedo));
        for (const Phase& phase : {Phase{}, Phase{PhaseKind::henyeyGreenstein, 0.8}}) {
            const auto of = [&](const Environment& environment) {
                return lightAgainst(volume, volume.scene(transportOf(256, phase), {}, environment),
                                    {3.3f, 0, 5.5f}, {0, 1, 0}, 10000);
            };
            const Mean file = of(environmentOf(mapOf({6, 3}, std::vector<glm::vec3>(18, glm::vec3(1)))));
            const Mean even = of(Environment{});
            EXPECT_NEAR(file.mean, even.mean, 4 * std::hypot(file.error, even.error) + 1e-3);
            if (albedo == 1.0) {
                EXPECT_NEAR(file.mean, 1, 4 * file.error + 1e-3);
            }
        }
    }
}

/// One texel is a light from its direction: the closed form of a slab (path_test.cpp), and any scatterings.
TEST(Environments, ABrightTexelIsADirectionalLight) {
    constexpr double kDensity = 0.1, kAlbedo = 0.7;
    const PathVolume slab(
        {160, 160, 16}, [](const glm::ivec3&) { return static_cast<float>(kDensity); }, kDensity,
        glm::dvec3(kAlbedo));
    const glm::ivec2 texel(300, 200);
    const glm::dvec3 towards = middleOf(kSunSize, texel), travel = glm::normalize(glm::dvec3(-0.4, 0.2, 1));
    const double area =
        areaOf(kSunSize, static_cast<std::size_t>(texel.y) * static_cast<std::size_t>(kSunSize.x));
    const Environment sun = environmentOf(sunMap(texel, static_cast<float>(1 / area), 0)); // irradiance 1
    for (const double g : {0.0, 0.6}) {
        const Phase phase{PhaseKind::henyeyGreenstein, g};
        const glm::vec3 from(80, 80, 0);
        const Mean once =
            lightAgainst(slab, slab.scene(transportOf(1, phase), {}, sun), from, glm::vec3(travel), 60000);
        const double mu = travel.z, mu0 = -towards.z, cosine = glm::dot(travel, towards);
        const double p = (1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * cosine, 1.5));
        const double expected =
            kAlbedo * p * mu0 / (mu + mu0) * (1 - std::exp(-16 * kDensity * (1 / mu + 1 / mu0)));
        EXPECT_NEAR(once.mean, expected, 4 * once.error + 2e-3 * expected);
        EXPECT_LT(once.error, 0.02 * expected);
        const Mean often = lightAgainst(slab, slab.scene(transportOf(16, phase), {}, sun), from,
                                        glm::vec3(travel), 60000),
                   light =
                       lightAgainst(slab, slab.scene(transportOf(16, phase), {lightFrom(towards, 1 / M_PI)}),
                                    from, glm::vec3(travel), 60000);
        EXPECT_NEAR(often.mean, light.mean, 4 * std::hypot(often.error, light.error) + 1e-3 * light.mean);
        EXPECT_GT(often.mean, 1.1 * once.mean) << "nothing is tested";
    }
}

/// Drawn directions change the noise, and not the mean: of a dim sky with a sun, and of softboxes.
TEST(Environments, DrawnDirectionsChangeNoMean) {
    const auto lumps = [](const glm::ivec3& i) {
        return (i.x / 5 + i.y / 7 + i.z / 3) % 3 == 0 ? 1.0f : 0.02f;
    };
    const PathVolume volume({24, 24, 24}, lumps, 1, glm::dvec3(0.9));
    Environment boxes{Sky::softboxes};
    for (const Environment& environment : {environmentOf(sunMap({100, 60}, 300, 0.4f)), boxes})
        for (const Phase& phase :
             {Phase{}, Phase{PhaseKind::schlick, 0.9}, Phase{PhaseKind::henyeyGreenstein, 0.8, -0.5, 0.3},
              Phase{PhaseKind::rayleigh}}) {
            PathScene scene = volume.scene(transportOf(6, phase), {}, environment);
            const auto light = [&] { // towards the front
                return lightAgainst(volume, scene, {3.3f, 24, 5.5f}, {0, -1, 0}, 30000);
            };
            const Mean drawn = light();
            ASSERT_TRUE(scene.skyTable);
            scene.skyTable = nullptr;
            const Mean met = light();
            EXPECT_NEAR(drawn.mean, met.mean, 4 * std::hypot(drawn.error, met.error));
            EXPECT_GT(drawn.mean, 10 * drawn.error);
            EXPECT_LT(drawn.error, met.error);
        }
}

/// The light of one scattering by a surface, of drawn and of met directions together: fine quadrature.
TEST(Environments, SurfacesTakeTheirLightOnce) {
    const PathVolume volume(
        {40, 40, 40}, [](const glm::ivec3&) { return 0.1f; }, 0.1);
    const glm::ivec2 size(24, 12);
    std::vector<glm::vec3> texels(24 * 12, glm::vec3(0.3f));
    texels[4 * 24 + 14] = glm::vec3(20);
    Transport transport = transportOf(4);
    transport.surface = SurfaceScattering{{40, 160}, 0.2, 0.4};
    for (const double translucent : {0.0, 0.6})
        for (const Environment& environment :
             {environmentOf(mapOf(size, texels)), Environment{Sky::softboxes}}) {
            transport.surface->finish.translucent = translucent;
            const PathScene scene = volume.scene(transport, {}, environment);
            PathWork work;
            PathTracer tracer(scene, volume, work);
            double sum = 0, squares = 0, expected = 0;
            constexpr int kMany = 200000, kFine = 600;
            TracedPath last(scene, {0, 0});
            for (int number = 0; number < kMany; ++number) {
                TracedPath path(scene, {static_cast<float>(number % 512), static_cast<float>(number / 512)});
                path.p = {20, 20, 20};
                path.travel = glm::normalize(glm::vec3(0.3f, 1, -0.2f));
                path.tissue.albedo = glm::vec3(0.6f);
                Way way;
                float light = 0;
                if (tracer.aim(path, {100, 480, -150}, way))
                    light += path.shine.r;
                last = path;
                if (tracer.turn(path, way))
                    light += (path.throughput * skyBeyond(scene, path)).r;
                ASSERT_TRUE(path.isSurface);
                sum += static_cast<double>(light), squares += std::pow(static_cast<double>(light), 2);
            }
            for (int part = 0; part < kFine * kFine; ++part) {
                const float z = 1 - 2 * (static_cast<float>(part / kFine) + 0.5f) / kFine;
                const glm::vec3 d =
                    directionAround({0, 0, 1}, z, (static_cast<float>(part % kFine) + 0.5f) / kFine);
                expected += 4 * M_PI / (kFine * kFine) *
                            static_cast<double>((scatteredFrom(scene, last, d) * skyFrom(scene, d)).r);
            }
            const double mean = sum / kMany, error = std::sqrt((squares / kMany - mean * mean) / kMany);
            EXPECT_NEAR(mean, expected, 4 * error + 2e-3 * expected);
            EXPECT_LT(error, 0.01 * expected);
        }
}

/// The density that weighs a surface's directions is that of its sampling.
TEST(Environments, WeighSurfacesByTheDensityOfTheirDirections) {
    const glm::vec3 n(0, 0, 1), v = glm::normalize(glm::vec3(0.5f, 0.2f, 0.6f));
    for (const float mirrored : {0.0f, 0.1f, 0.9f}) {
        const SurfaceResponse response{mirrored, 0.3f};
        constexpr int kMany = 100000, kBands = 8;
        int met[kBands] = {};
        double expected[kBands] = {};
        for (int path = 0; path < kMany; ++path) {
            PathNumbers numbers({static_cast<float>(path % 4096), static_cast<float>(path / 4096)}, 2);
            glm::vec3 l, share;
            const float choice = numbers.next(), a = numbers.next(), b = numbers.next();
            if (response.sample(glm::vec3(0.5f), n, v, choice, a, b, l, share))
                ++met[std::min(static_cast<int>(l.z * kBands), kBands - 1)];
            const float z = numbers.next();
            const glm::vec3 any = directionAround(n, z, numbers.next());
            expected[std::min(static_cast<int>(z * kBands), kBands - 1)] +=
                2 * M_PI * static_cast<double>(response.density(n, v, any));
        }
        for (int band = 0; band < kBands; ++band)
            EXPECT_NEAR(met[band], expected[band], 6 * std::sqrt(expected[band]) + 0.02 * expected[band]);
    }
}

} // namespace
} // namespace tessera
