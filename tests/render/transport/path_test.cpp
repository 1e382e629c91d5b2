// Paths of light against closed forms: a furnace, single scattering in a slab, a half space with every
// scattering.
#include "tests/support/path_light.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

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

/// Tissue of a range of values has a phase function and a finish of its own.
TEST(Paths, ScatterAsTheirTissue) {
    PathVolume slab(
        {40, 40, 16}, [](const glm::ivec3&) { return 0.1f; }, 0.2, glm::dvec3(0.7));
    const Phase forward{PhaseKind::henyeyGreenstein, 0.6};
    const SurfaceFinish rough{0.1, 0.8};
    const auto responseAt = [&](const std::vector<Tissue>& tissues) {
        const PathScene scene = slab.scene(transportOf(1), {lightFrom({0, 0, -1})}, {}, {}, tissues);
        PathWork work;
        PathTracer<PathVolume> tracer(scene, slab, work);
        TracedPath path(scene, {3, 4});
        path.tissue = tracer.tissueAt({20, 20, 8}, slab.value({20, 20, 8}));
        return responseOf(scene, path);
    };
    const TissueResponse own = responseAt({{0.3, 0.5, {}, {}}, {0.05, 0.15, forward, rough}});
    EXPECT_EQ(own.phase, forward);
    EXPECT_FLOAT_EQ(own.meanCosine, 0.6f);
    EXPECT_FLOAT_EQ(own.surface.first.width, 0.64f);
    for (const Tissue& other : {Tissue{0.11, 0.2, forward, rough}, Tissue{0.05, 0.099, forward, rough}}) {
        const TissueResponse common = responseAt({other});
        EXPECT_EQ(common.phase, Phase{});
        EXPECT_FLOAT_EQ(common.surface.first.width, 0.1225f);
    }
    // Light sees it: the closed form of one scattering, by the tissue's phase function.
    const glm::dvec3 towards = glm::normalize(glm::dvec3(0.5, 0.3, -1)), travel(0, 0, 1);
    const PathVolume wide(
        {160, 160, 16}, [](const glm::ivec3&) { return 0.1f; }, 0.2, glm::dvec3(0.7));
    const Mean light = lightAgainst(
        wide, wide.scene(transportOf(1), {lightFrom(towards, 2)}, {}, {}, {{0.05, 0.15, forward, {}}}),
        {80, 80, 0}, glm::vec3(travel), 60000);
    const double mu0 = -towards.z, p = phaseOf(forward, static_cast<float>(glm::dot(towards, travel)));
    const double expected = 0.7 * p * M_PI * 2 * mu0 / (1 + mu0) * -std::expm1(-1.6 * (1 + 1 / mu0));
    EXPECT_NEAR(light.mean, expected, 4 * light.error + 1e-3 * expected);
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

/// A thick layer of a medium shows its colour under a white sky, whatever its phase function.
TEST(Paths, ShowAColourThatIsAReflectance) {
    struct Case {
        Phase phase;
        double within;
    };
    for (const auto& [phase, within] :
         {Case{{}, 0.01}, Case{{PhaseKind::henyeyGreenstein, 0.5}, 0.03},
          Case{{PhaseKind::henyeyGreenstein, 0.4, -0.2, 0.5}, 0.01}, Case{{PhaseKind::schlick, -0.3}, 0.02},
          Case{{PhaseKind::schlick, 0.7}, 0.04}})
        for (const double colour : {0.1, 0.4, 0.75}) {
            const PathVolume space(
                {400, 400, 40}, [](const glm::ivec3&) { return 1.5f; }, 1.5, glm::dvec3(colour));
            Transport transport = transportOf(256, phase);
            transport.colours = TransportColours::reflectance;
            const Mean light = lightAgainst(space, space.scene(transport, {}, Environment{}), {200, 200, 0},
                                            {0, 0, 1}, 20000);
            EXPECT_NEAR(light.mean, colour, within + 4 * light.error) << phase.g;
            EXPECT_LT(light.error, 0.004);
        }
}

/// A point light fades as the scene says, and its place is where it is.
TEST(Paths, ScatterThePointLightOnce) {
    const PathVolume thin(
        {40, 40, 40}, [](const glm::ivec3&) { return 1e-4f; }, 1e-4, glm::dvec3(1), glm::dmat3(2.0));
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

/// Independent of its text: Trowbridge and Reitz's facets, Smith's shadowing of both ways together, Schlick.
TEST(SurfaceResponse, IsTheOneThatTheContractNames) {
    const double f0 = 0.2, a = 0.5 * 0.5;
    const SurfaceResponse response{static_cast<float>(f0), static_cast<float>(a)};
    const glm::dvec3 n(0, 0, 1);
    for (const glm::dvec3& to : {glm::dvec3(0.1, 0, 1), {-1, 0.3, 0.5}, {0.8, -0.8, 0.2}, {-0.9, 0, 0.4}}) {
        const glm::dvec3 v = glm::normalize(glm::dvec3(0.9, 0.1, 0.4)), l = glm::normalize(to),
                         h = glm::normalize(v + l);
        const double nh2 = h.z * h.z, facets = a * a / (M_PI * std::pow(nh2 * (a * a - 1) + 1, 2));
        const auto lambda = [&](double c) { return (std::sqrt(1 + a * a * (1 / (c * c) - 1)) - 1) / 2; };
        const auto schlick = [&](double c) { return f0 + (1 - f0) * std::pow(1 - c, 5); };
        const double coat =
            facets / (1 + lambda(v.z) + lambda(l.z)) * schlick(glm::dot(v, h)) / (4 * v.z * l.z);
        const double expected = 0.6 / M_PI * (1 - schlick(v.z)) * (1 - schlick(l.z)) + coat;
        const glm::vec3 found = response.of(glm::vec3(0.6f), glm::vec3(n), glm::vec3(v), glm::vec3(l));
        EXPECT_NEAR(found.r, expected, 1e-4 * expected);
    }
}

/// Numbers of a scene: in patient space or voxels, of physical units.
TEST(PathScenes, HaveTheScenesNumbersInTheirFrames) {
    VolumeInfo info;
    info.extentVoxels = {10, 10, 10};
    info.rescaleSlope = -2;
    info.patientFromVoxel = glm::dmat4(1.5, 0.2, 0, 0, 0, 0.8, 0.3, 0, 0.1, 0, 2, 0, 7, 8, 9, 1);
    Lighting lighting;
    Light sun, inCamera, lamp;
    sun.kind = LightKind::directional, sun.frame = LightFrame::camera, sun.softness = 20;
    sun.direction = {0, 0, 2};
    inCamera.kind = LightKind::point, inCamera.frame = LightFrame::camera, inCamera.position = {1, 2, 3};
    lamp.kind = LightKind::point, lamp.frame = LightFrame::patient, lamp.position = {1, 2, 3};
    lighting.lights = {sun, inCamera, lamp};
    lighting.environment = Environment{};
    lighting.environment->up = {0, 3, 3};
    lighting.transport = transportOf(2);
    lighting.transport->surface = SurfaceScattering{{40, 160}, 0.1, 0.5};
    Camera camera;
    camera.position = {5, 6, 7}, camera.focalPoint = {5, 106, 7}, camera.viewUp = {0, 0, 1};
    const Optics optics;
    const ExtinctionBounds bounds;
    Optics ofValues; // its table follows physical values, which fall as stored ones rise
    ofValues.scale = -0.5, ofValues.offset = 500;
    info.rescaleIntercept = 100;
    const PathScene tissues = pathScene(lighting, camera, info, ofValues, bounds, nullptr, 1,
                                        {{100, 300, Phase{PhaseKind::rayleigh}, {}}}); // stored: 0 to -100
    EXPECT_EQ(tissueNumber(tissues, -50), 1u);
    EXPECT_EQ(tissueNumber(tissues, 20), 0u);
    EXPECT_EQ(tissueNumber(tissues, -120), 0u);
    info.rescaleIntercept = 0;
    const PathScene scene = pathScene(lighting, camera, info, optics, bounds, nullptr, 1);
    const auto near = [](const glm::vec3& found, const glm::dvec3& expected) {
        EXPECT_LT(glm::length(glm::dvec3(found) - expected), 1e-5 * (1 + glm::length(expected)));
    };
    const glm::dmat4 voxels = glm::inverse(info.patientFromVoxel);
    ASSERT_EQ(scene.lights.size(), 3u);
    near(scene.lights[0].towards, {0, -1, 0}); // towards the viewer
    EXPECT_NEAR(scene.lights[0].cosine, std::cos(10 * M_PI / 180), 1e-6);
    near(scene.lights[1].towards, glm::dvec3(voxels * glm::dvec4(5 + 1, 6 - 3, 7 + 2, 1)));
    near(scene.lights[2].towards, glm::dvec3(voxels * glm::dvec4(1, 2, 3, 1)));
    near(scene.up, glm::normalize(glm::dvec3(0, 1, 1)));
    EXPECT_FLOAT_EQ(scene.steepFrom, 20);
    EXPECT_FLOAT_EQ(scene.perSteep, 1.0f / 60);
    EXPECT_FLOAT_EQ(scene.tissues[0].surface.first.width, 0.25f);
    EXPECT_FLOAT_EQ(scene.tissues[0].surface.later.width, 0.36f);
    EXPECT_FLOAT_EQ(scene.tissues[0].surface.later.mirrored, 0.1f);
    EXPECT_NEAR(scene.leavesFromMm, 2 * std::cbrt(1.5 * 0.8 * 2 + 0.2 * 0.3 * 0.1), 1e-5);
    EXPECT_FLOAT_EQ(mostExtinctionPerMm(info),
                    static_cast<float>(256 / std::sqrt(0.8 * 0.8 + 0.3 * 0.3))); // by the shortest edge
}

/// Scatterings one by one, in sheared voxels.
class Scattering : public testing::Test {
  protected:
    Scattering()
        : volume(
              {40, 40, 40}, [](const glm::ivec3&) { return 0.1f; }, 0.1, glm::dvec3(1), kAxes) {}
    PathScene scene(const std::vector<Light>& lights, bool surfaces) const {
        Transport transport = transportOf(4);
        if (surfaces)
            transport.surface = SurfaceScattering{{40, 160}, 0.03, 0.4};
        return volume.scene(transport, lights, Environment{Sky::twoTone, 1, glm::dvec3(1), glm::dvec3(0)});
    }
    static TracedPath pathAt(const PathScene& scene, int number, const glm::vec3& travel) {
        TracedPath path(scene, {static_cast<float>(number % 256), static_cast<float>(number / 256)});
        path.p = {20, 21, 19};
        path.travel = travel;
        path.tissue.albedo = glm::vec3(1);
        return path;
    }
    /// Of values that rise by so much a mm along n.
    static glm::vec3 gradientAlong(const glm::dvec3& n, double perMm) {
        return glm::vec3(perMm * (glm::transpose(kAxes) * n));
    }

    static inline const glm::dmat3 kAxes{1.5, 0.2, 0, 0, 0.8, 0.3, 0.1, 0, 2};
    PathVolume volume;
    PathWork work;
};

TEST_F(Scattering, SurfacesFaceTheViewerAcrossTheGradientInPatientSpace) {
    const PathScene s = scene({lightFrom({0.2, 0.1, -1})}, true);
    const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.5, 0.9));
    for (const double side : {1.0, -1.0}) {
        TracedPath path = pathAt(s, 1, {0, 0, 1});
        PathTracer tracer(s, volume, work);
        Way way;
        tracer.aim(path, gradientAlong(side * n, 500), way);
        ASSERT_TRUE(path.isSurface);
        EXPECT_LT(glm::length(glm::dvec3(path.normal) + n), 1e-5); // against the ray
    }
}

TEST_F(Scattering, PlacesAreSurfacesWithTheChanceOfTheirGradient) {
    const PathScene s = scene({lightFrom({0, 0, -1})}, true);
    for (const auto& [length, chance] :
         {std::pair{39.0, 0.0}, {70.0, 0.15625}, {130.0, 0.84375}, {161.0, 1.0}}) {
        int surfaces = 0;
        constexpr int kMany = 20000;
        for (int number = 0; number < kMany; ++number) {
            TracedPath path = pathAt(s, number, {0, 0, 1});
            PathTracer tracer(s, volume, work);
            Way way;
            tracer.aim(path, gradientAlong({0, 1, 0}, length), way);
            surfaces += path.isSurface;
        }
        EXPECT_NEAR(surfaces / double{kMany}, chance,
                    4 * std::sqrt(0.25 / kMany) * (chance > 0 && chance < 1))
            << length;
    }
}

TEST_F(Scattering, SoftLightIsEvenOverItsDisk) {
    Light light = lightFrom({0.3, 0.4, -1});
    light.softness = 60;
    const PathScene s = scene({light}, false);
    const glm::dvec3 axis = glm::normalize(light.direction);
    double sum = 0, farthest = 1;
    constexpr int kMany = 20000;
    for (int number = 0; number < kMany; ++number) {
        TracedPath path = pathAt(s, number, {0, 0, 1});
        PathTracer tracer(s, volume, work);
        Way way;
        ASSERT_TRUE(tracer.aim(path, glm::vec3(0), way));
        const double cosine = glm::dot(glm::normalize(kAxes * glm::dvec3(way.perMm)), axis);
        sum += cosine, farthest = std::min(farthest, cosine);
    }
    const double edge = std::cos(30 * M_PI / 180);
    EXPECT_NEAR(sum / kMany, (1 + edge) / 2, 4 * (1 - edge) / std::sqrt(12.0 * kMany));
    EXPECT_NEAR(farthest, edge, 1e-3);
}

/// Ways end at a lamp, and begin two voxels above a surface that they leave.
TEST_F(Scattering, WaysAreBetweenAPlaceAndTheLamp) {
    Light lamp;
    lamp.kind = LightKind::point;
    lamp.frame = LightFrame::patient;
    const glm::dvec3 place = kAxes * glm::dvec3(20, 21, 19), way(3, -2, -6); // 7 mm
    lamp.position = place + way;
    for (const bool surface : {false, true}) {
        const PathScene s = scene({lamp}, surface);
        TracedPath path = pathAt(s, 1, {0, 0, 1});
        PathTracer tracer(s, volume, work);
        Way found;
        ASSERT_TRUE(tracer.aim(path, gradientAlong({0, 0, 1}, surface ? 500 : 0), found));
        ASSERT_EQ(path.isSurface, surface);
        const double from = surface ? static_cast<double>(s.leavesFromMm) : 0;
        const glm::dvec3 above(0, 0, -from); // on the viewer's side
        EXPECT_NEAR(found.mm, 7 - from * 6 / 7, 1e-4);
        const glm::dvec3 begins = kAxes * glm::dvec3(found.from),
                         ends = begins + kAxes * glm::dvec3(found.perMm) * static_cast<double>(found.mm);
        EXPECT_LT(glm::length(begins - place - above), 1e-4);
        EXPECT_NEAR(glm::dot(ends - place, way / 7.0), 7, 1e-4); // beside the lamp, as far as it is
        EXPECT_LT(glm::length(glm::cross(ends - begins, way / 7.0)), 1e-4);
        ASSERT_TRUE(tracer.turn(path, found));
        EXPECT_NEAR(glm::length(kAxes * glm::dvec3(found.from) - place), from, 1e-4);
    }
}

/// A light where the coat mirrors it: a highlight at the place that is seen, a wide one at later places.
TEST_F(Scattering, LaterHighlightsAreWide) {
    const PathScene s = scene({lightFrom({0.6, 0, -0.8})}, true);
    float shine[2];
    for (const int before : {0, 1}) {
        TracedPath path = pathAt(s, 1, glm::vec3(0.6f, 0, 0.8f));
        path.bounce = before;
        path.tissue.albedo = glm::vec3(0);
        PathTracer tracer(s, volume, work);
        Way way;
        ASSERT_TRUE(tracer.aim(path, gradientAlong({0, 0, 1}, 500), way));
        shine[before] = path.shine.r;
    }
    EXPECT_NEAR(shine[1] / shine[0], std::pow(0.16 / 0.36, 2), 0.1); // facets at their middle
}

TEST_F(Scattering, WhatLeavesSeesTheSkyWhereItGoes) {
    const PathScene s = scene({lightFrom({0, 0, -1})}, false);
    PathTracer tracer(s, volume, work);
    TracedPath path = pathAt(s, 1, {0, 0, 1});
    path.throughput = glm::vec3(0.5f);
    EXPECT_FALSE(tracer.reach(path, Way{}, -1));
    EXPECT_NEAR(path.sum.r, 0.5f, 1e-6f); // white above, black below
    path.travel = {0, 0, -1};
    tracer.reach(path, Way{}, -1);
    EXPECT_NEAR(path.sum.r, 0.5f, 1e-6f);
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
