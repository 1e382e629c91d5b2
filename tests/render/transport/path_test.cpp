// Paths of light against closed forms: a furnace, single scattering in a slab, a half space with every
// scattering.
#include "render/transport/path.h"

#include "tests/support/path_volume.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

struct Mean {
    double mean = 0, error = 0; // and its standard error
};

/// Light that comes out of a volume against a way, in the mean over many paths, red.
template <typename Volume>
Mean lightAgainst(const Volume& volume, const PathScene& scene, const glm::vec3& from,
                  const glm::vec3& travel, int paths) {
    double sum = 0, squares = 0;
    PathWork work;
    for (int number = 0; number < paths; ++number) {
        TracedPath path(scene,
                        {static_cast<float>(number % 4096) + 0.5f, static_cast<float>(number / 4096) + 0.5f});
        PathTracer tracer(scene, volume, work);
        const glm::vec3 perMm = scene.voxelFromPatient * travel;
        const Way way{from, perMm, mmToLeave(from, perMm, scene.extent)};
        const float mm = freePath(
            *scene.bounds, scene.occupancy, way, [&](const glm::vec3& p) { return tracer.extinctionAt(p); },
            path.numbers, work);
        double light = 0;
        if (mm >= 0) {
            path.p = from + mm * perMm;
            path.travel = travel;
            path.tissue = tracer.tissueAt(path.p, volume.value(path.p));
            light = static_cast<double>(tracer.lightFrom(path).r);
        } else {
            light = static_cast<double>(skyFrom(scene, travel).r);
        }
        sum += light, squares += light * light;
    }
    const double mean = sum / paths;
    EXPECT_EQ(work.exceeded, 0u);
    return {mean, std::sqrt(std::max(squares / paths - mean * mean, 0.0) / paths)};
}

Light lightFrom(const glm::dvec3& towards, double intensity = 1) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = towards;
    light.intensity = intensity;
    return light;
}

Transport transportOf(int bounces, const Phase& phase = {}) {
    Transport transport;
    transport.bounces = bounces;
    transport.phase = phase;
    return transport;
}

/// A medium that takes no light, under a sky that is the same everywhere, cannot be told from the sky.
TEST(Paths, SeeNothingInAWhiteFurnace) {
    const auto lumps = [](const glm::ivec3& i) {
        return (i.x / 5 + i.y / 7 + i.z / 3) % 3 == 0 ? 2.0f : 0.05f;
    };
    const PathVolume volume({24, 24, 24}, lumps, 2);
    for (const Phase& phase :
         {Phase{}, Phase{PhaseKind::henyeyGreenstein, 0.8}, Phase{PhaseKind::rayleigh}}) {
        const Mean light = lightAgainst(volume, volume.scene(transportOf(256, phase), {}, Environment{}),
                                        {3.3f, 0, 5.5f}, {0, 1, 0}, 4000);
        EXPECT_NEAR(light.mean, 1, 4 * light.error + 1e-3); // roulette makes noise; a few need more bounces
    }
    // With an albedo below 1 it is darker.
    const PathVolume grey({24, 24, 24}, lumps, 2, glm::dvec3(0.8));
    const Mean light =
        lightAgainst(grey, grey.scene(transportOf(256), {}, Environment{}), {3.3f, 0, 5.5f}, {0, 1, 0}, 4000);
    EXPECT_LT(light.mean, 0.9);
    EXPECT_GT(light.mean, 0.2);
}

/// One scattering in a slab of depth H, seen at cosine mu, lit at mu0: a p F mu0/(mu + mu0) (1 - e^(-H(1/mu +
/// 1/mu0))).
TEST(Paths, ScatterOnceInASlabAsTheClosedForm) {
    constexpr double kDensity = 0.1, kAlbedo = 0.7, kIntensity = 2;
    const PathVolume slab(
        {160, 160, 16}, [](const glm::ivec3&) { return static_cast<float>(kDensity); }, kDensity,
        glm::dvec3(kAlbedo));
    for (const double g : {0.0, 0.6}) {
        const Phase phase{PhaseKind::henyeyGreenstein, g};
        const glm::dvec3 towards = glm::normalize(glm::dvec3(0.5, 0.3, -1)),
                         travel = glm::normalize(glm::dvec3(-0.4, 0.2, 1));
        const PathScene scene = slab.scene(transportOf(1, phase), {lightFrom(towards, kIntensity)});
        const Mean light = lightAgainst(slab, scene, {80, 80, 0}, glm::vec3(travel), 60000);
        const double mu0 = -towards.z, mu = travel.z, depth = 16 * kDensity;
        const double p = static_cast<double>(phaseOf(phase, static_cast<float>(glm::dot(towards, travel))));
        const double expected =
            kAlbedo * p * M_PI * kIntensity * mu0 / (mu + mu0) * -std::expm1(-depth * (1 / mu + 1 / mu0));
        EXPECT_NEAR(light.mean, expected, 4 * light.error + 1e-3 * expected) << g;
    }
}

/// A half space that scatters evenly, lit and seen at right angles: L/F = a/(8 pi) H(1)^2, Chandrasekhar's H
/// (H(1) computed by its integral equation).
TEST(Paths, ScatterInAHalfSpaceAsChandrasekharHasIt) {
    for (const auto& [albedo, h] : {std::pair{0.5, 1.25126}, {0.8, 1.59822}, {0.9, 1.85010}}) {
        const PathVolume space(
            {400, 400, 40}, [](const glm::ivec3&) { return 1.5f; }, 1.5, glm::dvec3(albedo));
        const PathScene scene = space.scene(transportOf(256), {lightFrom({0, 0, -1})});
        const Mean light = lightAgainst(space, scene, {200, 200, 0}, {0, 0, 1}, 40000);
        const double expected = M_PI * albedo / (8 * M_PI) * h * h;
        EXPECT_NEAR(light.mean, expected, 4 * light.error) << albedo;
        EXPECT_LT(light.error, 0.02 * expected);
    }
}

/// A point light fades as the scene says, and its place is where it is.
TEST(Paths, ScatterThePointLightOnce) {
    const PathVolume thin(
        {40, 40, 40}, [](const glm::ivec3&) { return 1e-4f; }, 1e-4, glm::dvec3(1), 2.0);
    Light light;
    light.kind = LightKind::point;
    light.frame = LightFrame::patient;
    light.position = {40, 40, 100}; // mm
    light.attenuation = {0, 0, 1};
    const PathScene scene = thin.scene(transportOf(1), {light});
    const Mean seen = lightAgainst(thin, scene, {20, 0, 20}, {0, 1, 0}, 400000);
    double expected = 0; // along the ray: tau / (4 pi) * pi / d^2, with no other attenuation to speak of
    for (int n = 0; n < 800; ++n) {
        const double y = (n + 0.5) / 10 - 40; // mm from the middle
        expected += 0.1 * 1e-4 / 4 / (y * y + 60 * 60);
    }
    EXPECT_NEAR(seen.mean, expected, 4 * seen.error + 0.01 * expected);
    EXPECT_LT(seen.error, 0.1 * expected);
}

/// Share of light that a surface sends back, by its own sampling and by even directions.
TEST(SurfaceResponse, MakesNoLightAndIsSampledByItself) {
    const glm::vec3 n(0, 0, 1), albedo(0.9f, 0.5f, 0.1f);
    PathWork work;
    for (const float mirrored : {0.0f, 0.028f, 0.5f, 1.0f})
        for (const float roughness : {0.05f, 0.35f, 1.0f})
            for (const float cosine : {1.0f, 0.7f, 0.2f, 0.05f}) {
                const SurfaceResponse response{mirrored, roughness * roughness};
                const glm::vec3 v(std::sqrt(1 - cosine * cosine), 0, cosine);
                constexpr int kMany = 40000;
                double own = 0, squares = 0, even = 0, evenSquares = 0, blue = 0;
                for (int path = 0; path < kMany; ++path) {
                    PathNumbers numbers({static_cast<float>(path % 4096), static_cast<float>(path / 4096)},
                                        2);
                    glm::vec3 l, share(0);
                    if (response.sample(albedo, n, v, numbers.next(), numbers.next(), numbers.next(), l,
                                        share)) {
                        EXPECT_GT(l.z, 0);
                        own += static_cast<double>(share.r),
                            squares += std::pow(static_cast<double>(share.r), 2);
                        blue += static_cast<double>(share.b);
                    }
                    const glm::vec3 any = directionAround(n, numbers.next(), numbers.next());
                    const double light =
                        2 * M_PI * static_cast<double>(response.of(albedo, n, v, any).r * any.z);
                    even += light, evenSquares += light * light;
                }
                own /= kMany, even /= kMany, squares /= kMany, evenSquares /= kMany, blue /= kMany;
                const double error = std::sqrt(
                    (std::max(squares - own * own, 0.0) + std::max(evenSquares - even * even, 0.0)) / kMany);
                if (roughness > 0.1f) { // even directions hardly meet a narrower lobe
                    EXPECT_NEAR(own, even, 5 * error + 2e-3) << mirrored << " " << roughness << " " << cosine;
                }
                EXPECT_LE(own, 1 + 5 * error) << mirrored << " " << roughness << " " << cosine;
                EXPECT_LE(blue, own + 1e-6);
                const glm::vec3 l = glm::normalize(glm::vec3(-0.4f, 0.3f, 0.6f));
                EXPECT_NEAR(response.of(albedo, n, v, l).g, response.of(albedo, n, l, v).g,
                            1e-5f * response.of(albedo, n, v, l).g + 1e-7f);
            }
    // Without a coat it is Lambert's.
    const SurfaceResponse bare{0, 0.1f};
    EXPECT_NEAR(bare.of(albedo, n, {0, 0, 1}, {0, 0.6f, 0.8f}).r, 0.9f / static_cast<float>(M_PI), 2e-3f);
    EXPECT_EQ(bare.of(albedo, n, {0, 0, 1}, {0, 0.6f, -0.8f}), glm::vec3(0));
}

TEST(Environments, AreWhatTheySay) {
    PathScene scene;
    scene.environment = {Sky::overcast, 3, glm::dvec3(1, 0.5, 0.25)};
    EXPECT_NEAR(skyFrom(scene, {0, 0, 1}).r, 3, 1e-6f);
    EXPECT_NEAR(skyFrom(scene, {1, 0, 0}).r, 0, 1e-6f);
    EXPECT_NEAR(skyFrom(scene, {0.6f, 0, 0.8f}).g, 3 * 0.5f * 2.6f / 3, 1e-6f);
    EXPECT_EQ(skyFrom(scene, {0, 0, -1}), glm::vec3(0));
    scene.environment = {Sky::twoTone, 1, glm::dvec3(1), glm::dvec3(0, 0.5, 0)};
    EXPECT_NEAR(skyFrom(scene, {0, 0, -1}).g, 0.5f, 1e-6f);
    EXPECT_NEAR(skyFrom(scene, {0, 1, 0}).g, 0.75f, 1e-6f);
    scene.environment.reset();
    EXPECT_EQ(skyFrom(scene, {0, 0, 1}), glm::vec3(0));
}

} // namespace
} // namespace tessera
