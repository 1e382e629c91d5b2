// tests/render/light_reference_test.cpp: occlusion and shadows as the reference has them, by rays of its own:
// against closed forms, against itself, and what the light of voxels is off by; and that no light makes any
// engine draw nonsense.
#include "core/image_metrics.h"
#include "render/engines/reference/light_rays.h"
#include "render/light/directions.h"
#include "render/light/stored_light.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera::test {
namespace {

/// What was measured, for those who ask: TESSERA_TELL=1.
template <typename... Values> void tell(const char* format, const Values&... values) {
    if (std::getenv("TESSERA_TELL"))
        std::printf(format, values...);
}

ReferenceInput referenceInput(const Prepared& prepared, const Scene& scene) {
    const ScenePlan& p = prepared.p;
    return {p.volume.cache.get(), &p.info(), &p.volume.function, scene.shading, &p.volume.statistics, 1,
            scene.surfaces,       {},        p.view.lighting,    p.view.camera};
}
Image referencePicture(const ReferenceInput& input, const Prepared& prepared) {
    const ScenePlan& p = prepared.p;
    Image image(p.view.imageSize);
    const auto values = renderReference(input, referenceRays(p.view.camera, p.info(), p.view.imageSize), 0);
    std::transform(values.begin(), values.end(), image.pixels.begin(),
                   [](const glm::dvec4& v) { return glm::vec4(v); });
    return image;
}

/// Rays of light through a volume, and what they are made of.
struct RaysOfLight {
    RaysOfLight(const Prepared& prepared, const Scene& scene, int panels = 1)
        : input(referenceInput(prepared, scene)), function(*input.function, input.surfaces, *input.info),
          obstacles(function, *input.info), sources(input), samples(*input.cache, *input.info, 0, nullptr),
          light(*input.info, obstacles, sources, emptyCells, samples, panels) {}
    glm::dvec3 patient(const glm::dvec3& voxel) const {
        return glm::dvec3(input.info->patientFromVoxel * glm::dvec4(voxel, 1));
    }
    glm::dvec3 voxelsPerMm(const glm::dvec3& direction) const {
        return glm::inverse(glm::dmat3(input.info->patientFromVoxel)) * direction;
    }
    ReferenceInput input;
    StoredFunction function;
    Obstacles obstacles;
    LightSources sources;
    std::vector<bool> emptyCells;
    LatticeReader samples;
    LightRays light;
};

/// A volume whose value is the place along x, and scenes on it.
struct Ramp {
    Ramp() : stored([](const glm::dvec3& p) { return p.x; }) {}
    Scene scene(const std::vector<OpacityPoint>& extinction, const Lighting& lighting) const {
        Scene s = stored.scene({});
        s.volumes[0].transferFunction = TransferFunction::fromExtinction(extinction, {});
        s.lighting = lighting;
        return s;
    }
    Stored stored;
};

Light keyLight(double softness = 0) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = {-1, 1, 1};
    light.shadow = true;
    light.softness = softness;
    return light;
}

/// Every ray in one extinction, to its end or to the border, beyond which nothing is.
TEST(ReferenceLight, OcclusionInOneMedium) {
    const Ramp ramp;
    const glm::dvec3 place(22.3, 19.1, 24.7), extent(ramp.stored.info.extentVoxels);
    for (const double radius : {12.0, 1000.0})
        for (const double tau : {1e-4, 0.1, 1.0, 30.0, 1e4}) {
            Lighting lighting;
            lighting.occlusion = Occlusion{.rays = 80, .radiusMm = radius, .offsetMm = 2};
            const Scene scene = ramp.scene({{0, tau}}, lighting);
            const auto prepared = ramp.stored.prepare(scene);
            RaysOfLight rays(*prepared, scene);
            double sum = 0;
            for (const glm::dvec3& direction : sphereDirections(80)) {
                const glm::dvec3 along = rays.voxelsPerMm(direction);
                double border = std::numeric_limits<double>::max(); // mm
                for (int axis = 0; axis < 3; ++axis)
                    if (std::abs(along[axis]) > 1e-12)
                        border = std::min(border,
                                          ((along[axis] > 0 ? extent[axis] : 0) - place[axis]) / along[axis]);
                const double inside = std::min(border, radius) - 2;
                const double seen =
                    -std::expm1(-tau * inside) / tau + std::exp(-tau * inside) * (radius - 2 - inside);
                const double expected = seen / (radius - 2);
                // Rays end where less is left than kDark: a share of a short ray, a little of a long one.
                ASSERT_NEAR(rays.light.openness(rays.patient(place), direction), expected,
                            radius > 100 ? LightRays::kDark : 1e-12 + 2e-6 * expected)
                    << tau << " to " << radius;
                sum += expected;
            }
            ASSERT_NEAR(rays.light.at(place)[0], std::pow(0.1 + sum / 80, 0.6), 1e-6);
        }
}

/// Extinction that rises along the ramp: what is left is the exponential of a parabola, summed by fine steps.
TEST(ReferenceLight, OcclusionInARisingMedium) {
    const Ramp ramp;
    for (const double steep : {0.002, 0.05, 2.0}) {
        Lighting lighting;
        lighting.occlusion = Occlusion{.rays = 32, .radiusMm = 11};
        const Scene scene = ramp.scene({{0, 0}, {44, 44 * steep}}, lighting);
        const auto prepared = ramp.stored.prepare(scene);
        RaysOfLight rays(*prepared, scene);
        const glm::dvec3 place(20.2, 19.1, 24.7);
        for (const glm::dvec3& direction : sphereDirections(32)) {
            const double rise = rays.voxelsPerMm(direction).x;
            constexpr int kSteps = 40000;
            double sum = 0;
            for (int n = 0; n < kSteps; ++n) {
                const double s = 11 * (n + 0.5) / kSteps;
                sum += std::exp(-steep * (place.x * s + rise * s * s / 2));
            }
            ASSERT_NEAR(rays.light.openness(rays.patient(place), direction), sum / kSteps, 2e-6) << steep;
        }
    }
}

/// A wall: rays that turn away from it are open, others up to where they meet it.
TEST(ReferenceLight, OcclusionBesideAWall) {
    const Ramp ramp;
    for (const double tau : {0.5, 1e5})
        for (const double away : {1e-6, 0.3, 4.0}) { // voxels
            Lighting lighting;
            lighting.occlusion = Occlusion{.rays = 128, .radiusMm = 9, .bias = 0, .gamma = 1};
            const Scene scene = ramp.scene({{20, 0}, {20, tau}}, lighting);
            const auto prepared = ramp.stored.prepare(scene);
            RaysOfLight rays(*prepared, scene);
            const glm::dvec3 place(20 - away, 19.1, 24.7);
            double sum = 0;
            for (const glm::dvec3& direction : sphereDirections(128)) {
                const double rise = rays.voxelsPerMm(direction).x;
                const double free = rise > 0 ? std::min(9.0, away / rise) : 9;
                sum += (free - std::expm1(-tau * (9 - free)) / tau) / 9;
            }
            ASSERT_NEAR(rays.light.at(place)[0], sum / 128, 1e-6) << tau << ", " << away;
            if (tau > 1 && away < 1e-3) {
                EXPECT_NEAR(sum / 128, 0.5, 1e-3); // one half is open
            }
        }
}

/// The other ways to sum: the light at a ray's end; nothing taken by what thins out along it.
TEST(ReferenceLight, OtherSums) {
    const Ramp ramp;
    const glm::dvec3 place(20.2, 19.1, 24.7);
    for (const OcclusionMethod method : {OcclusionMethod::positional, OcclusionMethod::rejecting}) {
        Lighting lighting;
        lighting.occlusion = Occlusion{.method = method, .rays = 32, .radiusMm = 11};
        const Scene scene = ramp.scene({{0, 0}, {44, 2}}, lighting);
        const auto prepared = ramp.stored.prepare(scene);
        RaysOfLight rays(*prepared, scene);
        for (const glm::dvec3& direction : sphereDirections(32)) {
            const double rise = rays.voxelsPerMm(direction).x;
            const double depth = 2.0 / 44 * 11 * (place.x + rise * 11 / 2);
            const bool takes = method == OcclusionMethod::positional || rise > 0;
            ASSERT_NEAR(rays.light.openness(rays.patient(place), direction), takes ? std::exp(-depth) : 1,
                        1e-6);
        }
    }
}

/// A slab between two steps of the function, and isosurfaces, behind which it is as dense as they are opaque.
TEST(ReferenceLight, ShadowsOfASlab) {
    const Ramp ramp;
    Lighting lighting;
    lighting.lights = {keyLight(), keyLight(20), keyLight()};
    lighting.lights[0].direction = lighting.lights[1].direction = {3, 1, -0.5};
    lighting.lights[2].kind = LightKind::point;
    lighting.lights[2].position = glm::dvec3(ramp.stored.info.patientFromVoxel * glm::dvec4(38, 21, 20, 1));
    const double tau = 0.4;
    Scene scene = ramp.scene({{20, 0}, {20, tau}, {23, tau}, {23, 0}}, lighting);
    const auto prepared = ramp.stored.prepare(scene);
    RaysOfLight rays(*prepared, scene);
    ASSERT_EQ(rays.light.channels(), 3);
    const auto through = [&](const glm::dvec3& direction) {
        return std::exp(-tau * 3 / std::abs(rays.voxelsPerMm(direction).x));
    };
    const glm::dvec3 before(12.2, 17.3, 26.1), behind(30.4, 21.2, 20);
    const glm::dvec3 toKey = glm::normalize(lighting.lights[0].direction);
    const LightShares here = rays.light.at(before), there = rays.light.at(behind);
    EXPECT_NEAR(here[0], through(toKey), 1e-12);
    double soft = 0;
    for (const glm::dvec3& place : rays.sources.casters[1].places) {
        EXPECT_LE(glm::dot(place, toKey), 1);
        EXPECT_GE(glm::dot(place, toKey), std::cos(glm::radians(10.0)));
        soft += through(place) / 8;
    }
    EXPECT_NEAR(here[1], soft, 1e-12);
    EXPECT_GT(std::abs(soft - here[0]), 1e-5);
    const glm::dvec3 toPoint = rays.patient({38, 21, 20}) - rays.patient(before);
    EXPECT_NEAR(here[2], through(glm::normalize(toPoint)), 1e-12);
    for (int n = 0; n < 3; ++n)
        EXPECT_EQ(there[static_cast<std::size_t>(n)], 1);
    // A point light before the slab, and one that is nearer than rays start off.
    const glm::dvec3 place = rays.patient(before);
    EXPECT_EQ(rays.light.shadow(place, toKey, 2), 1);
    EXPECT_EQ(rays.light.at({38, 21, 20})[2], 1);

    // From x = 25 on an isosurface's inside takes 0.7 of the light in a voxel's length.
    scene.surfaces = {{25, {1, 1, 1}, 0.7}};
    RaysOfLight more(*prepared, scene);
    const double voxelMm =
        std::cbrt(std::abs(glm::determinant(glm::dmat3(rays.input.info->patientFromVoxel))));
    const double inside = 30; // mm, from a place behind it
    EXPECT_NEAR(more.light.shadow(more.patient({27, 20, 24}), {1, 0, 0}, 3), std::pow(0.3, 3 / voxelMm),
                1e-9);
    EXPECT_LT(more.light.shadow(more.patient({27, 20, 24}), {1, 0, 0}, inside), 1e-3);
}

/// Rays start and go where those of the light of voxels do.
TEST(ReferenceLight, LightsAreWhereShadowMapsHaveThem) {
    EXPECT_EQ(LightSources::kPlacesOfSoftLight, ShadowQuality::kMapsOfSoftLight);
    EXPECT_EQ(LightSources::kOffsetVoxels, ShadowQuality{}.offset);
    Lighting lighting;
    lighting.lights = {keyLight(), keyLight(15), keyLight(15)};
    lighting.lights[1].frame = LightFrame::camera;
    lighting.lights[2].kind = LightKind::point;
    lighting.lights[2].position = {300, -400, 500};
    Scene scene = sceneOn(infoOf("torso"), "bone", 0, {8, 8});
    scene.lighting = lighting;
    Prepared prepared("torso", scene);
    const ScenePlan& p = prepared.p;
    const LightPath path{p.volume.cache.get(), &p.info(),          &p.volume.selection, nullptr,
                         &p.volume.optics,     &p.volume.occupancy};
    const LightSources sources(referenceInput(prepared, scene));
    ShadowQuality quality;
    quality.mapSize = 2;
    for (std::size_t n = 0; n < 3; ++n) {
        const ShadowMaps maps(placedLight(lighting.lights[n], p.view.camera), path, quality);
        const std::vector<glm::dvec3>& places = sources.casters[n].places;
        ASSERT_EQ(places.size(), maps.maps().size());
        for (std::size_t m = 0; m < places.size(); ++m) {
            const Camera& camera = maps.camera(m);
            const glm::dvec3 towards = glm::normalize(camera.position - camera.focalPoint);
            EXPECT_LT(glm::distance(places[m], n == 2 ? camera.position : towards), n == 2 ? 1e-9 : 1e-12);
        }
    }
}

/// What shares of light are known to: rays of light with four times the panels; light along rays of the eye a
/// tenth as coarse.
TEST(ReferenceLight, FinerRaysChangeNothing) {
    Lighting lighting;
    lighting.occlusion = Occlusion{};
    lighting.lights = {keyLight(), Light{}};
    for (const char* preset : {"soft-tissue", "bone"}) {
        Scene scene = sceneOn(infoOf("torso"), preset, 0, {8, 8});
        scene.lighting = lighting;
        Prepared prepared("torso", scene);
        RaysOfLight once(prepared, scene), finer(prepared, scene, 4);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> anywhere(0.05, 0.95);
        double panels = 0, shade = 0;
        for (int n = 0; n < 200; ++n) {
            const glm::dvec3 place = glm::dvec3(prepared.p.info().extentVoxels) *
                                     glm::dvec3(anywhere(random), anywhere(random), anywhere(random));
            const LightShares a = once.light.at(place), b = finer.light.at(place);
            panels = std::max({panels, std::abs(a[0] - b[0]), std::abs(a[1] - b[1])});
            shade += 1 - a[1];
        }
        EXPECT_GT(shade, 20);
        EXPECT_LT(panels, 1e-6) << preset; // kDark
        const ReferenceInput input = referenceInput(prepared, scene);
        ReferenceInput closer = input;
        closer.lightTolerance = input.lightTolerance / 10;
        const ImageDifference d =
            compare(referencePicture(input, prepared), referencePicture(closer, prepared));
        tell("%s: panels %.3g; tolerance rms %.3g largest %.3g\n", preset, panels, d.rms, d.maxAbs);
        EXPECT_LT(d.maxAbs, 5e-4) << preset;
        EXPECT_LT(d.rms, 5e-5) << preset;
    }
}

struct PictureCase {
    const char *store, *preset;
    bool occlusion, shadow;
    double rms[2], luvP99[2]; // at finest level 0 and 1
};

/// Light of voxels, through the mirror, against rays of light from every place that is seen.
void expectNear(const PictureCase& c) {
    Lighting lighting;
    if (c.occlusion)
        lighting.occlusion = Occlusion{};
    if (c.shadow) {
        lighting.lights = {keyLight()};
        lighting.lights[0].frame = LightFrame::camera;
    }
    Image truth;
    for (int level = 0; level < 2; ++level) {
        Scene scene = sceneOn(infoOf(c.store), c.preset, 0, {20, 20});
        scene.lighting = lighting;
        scene.lighting.finestLevel = level;
        scene.quality.integrator = Integrator::preintegrated;
        Prepared prepared(c.store, scene);
        const ScenePlan& p = prepared.p;
        if (level == 0)
            truth = referencePicture(referenceInput(prepared, scene), prepared);
        MirrorInput input = mirrorInput(p, true);
        std::optional<SceneLight> light;
        std::optional<StoredLight> stored;
        if (c.occlusion || c.shadow) {
            light.emplace(p, 0);
            stored.emplace(*light, p, prepared.budgets.ram);
            input.light = &*stored;
        }
        Image image(p.view.imageSize);
        Work work;
        image.pixels =
            mirrorRays<float>(input, image.pixels.size(), frameRays(cast<float>(p.view.frame)), 0, work);
        const ImageDifference d = compare(image, truth);
        tell("%s %s%s%s level %d: rms %.3g bias %.3g luv mean %.3g p99 %.3g pixels %zu\n", c.store, c.preset,
             c.occlusion ? " occlusion" : "", c.shadow ? " shadow" : "", level, d.rms, d.bias, d.luvMean,
             d.luvP99, d.maskedPixels);
        const std::string what = std::string(c.store) + (c.occlusion ? " occlusion" : "") +
                                 (c.shadow ? " shadow" : "") + " at level " + std::to_string(level);
        EXPECT_LT(d.rms, c.rms[level]) << what;
        EXPECT_LT(d.luvP99, c.luvP99[level]) << what;
        EXPECT_GT(d.maskedPixels, 30u) << what;
    }
}

// Twice what was measured. Of the rms and the distances of no light at all (0.010 and 3.6; 0.0094 and 8.4)
// the march's step makes part of each; the rest is light that is known at samples only: surfaces lie between
// them, where light changes most, and at level 1 between samples twice as far apart. Where directional
// lights' shadows begin at the sample itself, the rms is 0.07.
TEST(ReferenceLight, PicturesOfTheTorso) {
    expectNear({"torso", "bone", false, false, {0.021, 0.021}, {7.3, 7.3}});
    expectNear({"torso", "bone", true, false, {0.037, 0.06}, {6.5, 9}});
    expectNear({"torso", "bone", false, true, {0.018, 0.025}, {7.8, 12.2}});
    expectNear({"torso", "bone", true, true, {0.032, 0.061}, {12.7, 26}});
}
TEST(ReferenceLight, PicturesOfTheAbdomen) {
    if (!std::filesystem::exists(storePath("abdomen")))
        GTEST_SKIP() << "the scan is absent";
    expectNear({"abdomen", "bone", false, false, {0.019, 0.019}, {16.8, 16.8}});
    expectNear({"abdomen", "bone", true, false, {0.031, 0.046}, {16.9, 16.9}});
    expectNear({"abdomen", "bone", false, true, {0.024, 0.041}, {14.8, 21}});
    expectNear({"abdomen", "bone", true, true, {0.029, 0.058}, {16.7, 27.4}});
}

/// As evenly spread as directions can be: a spiral with one of them for every equal slice of the sphere.
std::vector<glm::dvec3> spiral(int count) {
    std::vector<glm::dvec3> all;
    for (int n = 0; n < count; ++n) {
        const double z = 1 - (2 * n + 1.0) / count, r = std::sqrt(1 - z * z), angle = n * 2.399963229728653;
        all.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return all;
}

/// Parts of the sphere that are nearest to each direction; together 1.
std::vector<double> partsOfSphere(const std::vector<glm::dvec3>& directions) {
    std::vector<double> parts(directions.size());
    const std::vector<glm::dvec3> places = spiral(40000);
    for (const glm::dvec3& place : places) {
        std::size_t nearest = 0;
        for (std::size_t n = 1; n < directions.size(); ++n)
            if (glm::dot(directions[n], place) > glm::dot(directions[nearest], place))
                nearest = n;
        parts[nearest] += 1.0 / static_cast<double>(places.size());
    }
    return parts;
}

/// Errors of K rays against 4096, at samples that show something. Weighted by the parts of the sphere that
/// they stand for they fall at least as their number's root. All alike, as occlusion takes them, they do so
/// down to a floor: faces cut into four at the middles of their edges are not of one size, so that directions
/// crowd around a solid's corners, around a tetrahedron's most.
void expectFallingWithRays(const char* store, const char* preset) {
    Scene scene = sceneOn(infoOf(store), preset, 0, {8, 8});
    scene.lighting.occlusion = Occlusion{};
    Prepared prepared(store, scene);
    std::mt19937 random(3);
    std::vector<glm::dvec3> places; // patient space
    RaysOfLight rays(prepared, scene);
    const glm::ivec3 extent = prepared.p.info().extentVoxels;
    while (places.size() < 120) {
        const glm::ivec3 voxel(std::uniform_int_distribution(0, extent.x - 1)(random),
                               std::uniform_int_distribution(0, extent.y - 1)(random),
                               std::uniform_int_distribution(0, extent.z - 1)(random));
        if (rays.function.extinction(rays.samples.at(voxel)) > 0)
            places.push_back(rays.patient(glm::dvec3(voxel) + 0.5));
    }
    const auto mean = [&](const glm::dvec3& place, const std::vector<glm::dvec3>& directions,
                          const std::vector<double>& parts) {
        double sum = 0;
        for (std::size_t n = 0; n < directions.size(); ++n)
            sum += parts[n] * rays.light.openness(place, directions[n]);
        return sum;
    };
    std::vector<double> truth;
    for (const glm::dvec3& place : places)
        truth.push_back(mean(place, spiral(4096), std::vector<double>(4096, 1.0 / 4096)));
    double first = 0;
    constexpr double kFloor = 0.009;
    for (const int count : {4, 8, 16, 20, 32, 64, 80, 128, 256, 320, 512}) {
        const std::vector<glm::dvec3> directions = sphereDirections(count);
        const std::vector<double> parts = partsOfSphere(directions), alike(directions.size(), 1.0 / count);
        double sum = 0, weighted = 0;
        for (std::size_t n = 0; n < places.size(); ++n) {
            sum += std::pow(mean(places[n], directions, alike) - truth[n], 2);
            weighted += std::pow(mean(places[n], directions, parts) - truth[n], 2);
        }
        const double rms = std::sqrt(sum / static_cast<double>(places.size())),
                     rmsWeighted = std::sqrt(weighted / static_cast<double>(places.size()));
        first = count == 4 ? rms : first;
        const double root = first * std::sqrt(4.0 / count);
        tell("| %s, %s | %d | %.5f | %.5f | %.5f |\n", store, preset, count, rms, rmsWeighted, root);
        EXPECT_LT(rms, std::max(1.25 * root, kFloor)) << store << ", " << count;
        EXPECT_LT(rmsWeighted, 1.25 * root) << store << ", " << count;
    }
}

TEST(ReferenceLight, OcclusionFallsWithRays) {
    expectFallingWithRays("torso", "soft-tissue");
    if (std::filesystem::exists(storePath("abdomen")))
        expectFallingWithRays("abdomen", "bone");
}

/// Lights that nobody would set, by native engine, march and reference: finite, no brighter than the light
/// that there is, and drawn to the end.
void expectSane(const std::string& what, const std::string& preset, const TransferFunction* function,
                const Lighting& lighting) {
    SCOPED_TRACE(what + ", " + preset);
    Scene scene = sceneOn(infoOf("sphere"), preset, 0, {10, 10});
    if (function)
        scene.volumes[0].transferFunction = *function;
    scene.lighting = lighting;
    Prepared prepared("sphere", scene);
    prepared.p.view.shadowQuality.mapSize = 32;
    const double most = 1.5 * std::max(1.0, mostLight(lighting.lights)) *
                        (scene.shading.ambient * 1.1 + scene.shading.diffuse + scene.shading.specular);
    const auto check = [&](const Image& image, const char* engine) {
        for (const glm::vec4& p : image.pixels)
            for (int c = 0; c < 4; ++c) {
                ASSERT_TRUE(std::isfinite(p[c])) << engine;
                ASSERT_GE(p[c], 0) << engine;
                ASSERT_LE(static_cast<double>(p[c]), c == 3 ? 1 + 1e-5 : most) << engine;
            }
    };
    check(referencePicture(referenceInput(prepared, scene), prepared), "reference");
    check(nativePicture(prepared).image, "native");
    check(marchOn(prepared, kFeatureSkipping | kFeatureShading).image, "march");
}

TEST(LightExtremes, AreFiniteAndBounded) {
    const GlContext context({"software"});
    const VolumeInfo info = infoOf("sphere");
    const auto pointAt = [&](const glm::dvec3& voxel, double softness) {
        Lighting lighting;
        Light light = keyLight(softness);
        light.kind = LightKind::point;
        light.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1));
        lighting.lights = {light};
        lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
        return lighting;
    };
    const TransferFunction nothing = TransferFunction::fromExtinction({}, {}),
                           wall = TransferFunction::fromOpacity({{0, 1}}, {}, 1e-3);
    Lighting without = pointAt(glm::dvec3(0), 0), far = without;
    without.lights[0].kind = LightKind::directional;
    without.lights[0].direction = glm::dvec3(0);
    far.occlusion = Occlusion{.rays = 8, .radiusMm = 1e5};
    for (const TransferFunction* function :
         {static_cast<const TransferFunction*>(nullptr), &nothing, &wall}) {
        expectSane("a light inside", "bone", function, pointAt(glm::dvec3(info.extentVoxels) * 0.45, 0));
        expectSane("a large one inside", "bone", function, pointAt(glm::dvec3(info.extentVoxels) * 0.45, 90));
        expectSane("on a corner of bricks", "bone", function, pointAt({32, 32, 32}, 0));
        expectSane("behind bone", "bone", function, pointAt({-9, 200, 25}, 0));
        expectSane("without a direction", "bone", function, without);
        expectSane("a radius beyond the volume", "bone", function, far);
    }
}

} // namespace
} // namespace tessera::test
