// tests/render/light/light_reference_test.cpp: occlusion and shadows as the reference has them, by rays of
// its own: against closed forms, and against finer ones.
#include "core/image/image_metrics.h"
#include "render/light/directions.h"
#include "render/light/shadow_maps.h"
#include "tests/support/native_fixture.h"
#include "tests/support/reference_light.h"
#include "tests/support/surface_fixture.h"

#include <cmath>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera::test {
namespace {

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
            for (const auto& [direction, part] : sphereDirections(80)) {
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
                sum += part * expected;
            }
            ASSERT_NEAR(rays.light.at(place)[0], std::pow(0.1 + sum, 0.6), 1e-6);
        }
}

/// Below a wall that hides all, light from above: what weights of directions leave is their share of the open
/// side.
TEST(ReferenceLight, WeighsDirections) {
    const Ramp ramp; // its value is x
    for (const double side : {1.0, -1.0})
        for (const double strength : {0.0, 2.0, 20.0}) {
            Lighting lighting;
            lighting.occlusion = Occlusion{.rays = 320, .radiusMm = 500, .bias = 0, .gamma = 1};
            lighting.occlusion->weights = DirectionWeights{{side, 0, 0}, strength};
            const Scene scene = ramp.scene({{23, 0}, {23.01, 1e4}}, lighting); // opaque from there on
            const auto prepared = ramp.stored.prepare(scene);
            RaysOfLight rays(*prepared, scene);
            double open = 0, all = 0;
            for (const auto& [direction, part] : sphereDirections(320)) {
                const double weight = part * (1 + strength * std::max(0.0, side * direction.x));
                all += weight;
                open += rays.voxelsPerMm(direction).x < 1e-9 ? weight : 0; // those along the wall, too
            }
            EXPECT_NEAR(rays.light.at({22.9, 20, 24})[0], open / all, 0.01) << side << " " << strength;
        }
}

/// Of a wall that hides all the hemisphere sees the open side alone, at its plane and a little before it.
TEST(ReferenceLight, SeesTheOpenHemisphere) {
    const Ramp ramp;
    for (const auto& [directions, least, most] : {std::tuple(OcclusionDirections::hemisphere, 0.97, 1.0),
                                                  std::tuple(OcclusionDirections::sphere, 0.4, 0.6)}) {
        Lighting lighting;
        lighting.occlusion = Occlusion{.rays = 320, .radiusMm = 20, .bias = 0, .gamma = 1};
        lighting.occlusion->directions = directions;
        const Scene scene = ramp.scene({{23, 0}, {23.01, 1e4}}, lighting); // opaque from there on
        const auto prepared = ramp.stored.prepare(scene);
        RaysOfLight rays(*prepared, scene);
        for (const double x : {22.5, 22.95}) {
            const double open = rays.light.at({x, 20, 24})[0];
            EXPECT_GE(open, least) << x;
            EXPECT_LE(open, most) << x;
        }
    }
}

/// The normal of an oblique wall in skewed voxels is that of patient space: no ray into the wall counts.
TEST(ReferenceLight, SeesTheOpenHemisphereOfAnObliqueWall) {
    const Stored oblique([](const glm::dvec3& p) { return p.x + 0.5 * p.z; });
    Lighting lighting;
    lighting.occlusion = Occlusion{.rays = 320, .radiusMm = 20, .bias = 0, .gamma = 1};
    lighting.occlusion->directions = OcclusionDirections::hemisphere;
    Scene scene = oblique.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{32, 0}, {32.01, 1e4}}, {});
    scene.lighting = lighting;
    const auto prepared = oblique.prepare(scene);
    RaysOfLight rays(*prepared, scene);
    EXPECT_GE(rays.light.at({21.9, 20, 20})[0], 0.98);
    EXPECT_GE(rays.light.at({20.4, 18, 23})[0], 0.98);
}

/// Optical depths are inverted: in one medium by a logarithm, and in any volume to the place up to which a
/// shadow leaves the share that is sought.
TEST(ReferenceLight, ReachesThePlaceWhereAShareIsLeft) {
    const Ramp ramp;
    const Stored noisy(
        [](const glm::dvec3& p) { return 200 * std::sin(p.x) * std::cos(1.3 * p.y) + 9 * p.z; });
    for (const double tau : {1e-6, 0.1, 30.0, 1e6}) {
        const Scene scene = ramp.scene({{0, tau}}, {});
        const auto prepared = ramp.stored.prepare(scene);
        RaysOfLight rays(*prepared, scene);
        const glm::dvec3 along = rays.voxelsPerMm({0.6, 0, 0.8});
        for (const double share : {0.999, 0.5, 1e-4}) {
            const double expected = -std::log(share) / tau;
            const LightRays::Reached reached = rays.light.reach({3, 20, 3}, along, 5, share);
            if (expected < 5) {
                EXPECT_NEAR(reached.mm, expected, 1e-9 * (1 + expected)) << tau << " " << share;
            } else {
                EXPECT_LT(reached.mm, 0);
                EXPECT_NEAR(reached.left, std::exp(-5 * tau), 1e-9) << tau;
            }
        }
    }
    Scene scene = noisy.scene({});
    scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{0, 0}, {60, 0.3}, {61, 0}, {150, 0.02}, {300, 4}}, {});
    const auto prepared = noisy.prepare(scene);
    RaysOfLight rays(*prepared, scene);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    int found = 0;
    for (int n = 0; n < 400; ++n) {
        const glm::dvec3 extent(noisy.info.extentVoxels);
        const glm::dvec3 from = extent * glm::dvec3(uniform(random), uniform(random), uniform(random));
        const glm::dvec3 towards =
            glm::normalize(glm::dvec3(uniform(random), uniform(random), uniform(random)) - 0.5);
        const double share = 1 - uniform(random), mm = 60 * uniform(random);
        const LightRays::Reached reached = rays.light.reach(from, rays.voxelsPerMm(towards), mm, share);
        const double whole = rays.light.shadow(rays.patient(from), towards, mm);
        EXPECT_EQ(reached.mm >= 0, whole < share) << n;
        if (reached.mm < 0) {
            EXPECT_NEAR(reached.left, whole, 1e-9);
            continue;
        }
        ++found;
        EXPECT_LE(reached.mm, mm);
        EXPECT_NEAR(rays.light.shadow(rays.patient(from), towards, reached.mm), share, 1e-6) << n;
    }
    EXPECT_GT(found, 100);
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
        for (const SphereDirection& ray : sphereDirections(32)) {
            const glm::dvec3 direction = ray.towards;
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
            for (const auto& [direction, part] : sphereDirections(128)) {
                const double rise = rays.voxelsPerMm(direction).x;
                const double free = rise > 0 ? std::min(9.0, away / rise) : 9;
                sum += part * (free - std::expm1(-tau * (9 - free)) / tau) / 9;
            }
            ASSERT_NEAR(rays.light.at(place)[0], sum, 1e-6) << tau << ", " << away;
            if (tau > 1 && away < 1e-3) {
                EXPECT_NEAR(sum, 0.5, 1e-3); // one half is open
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
        for (const SphereDirection& ray : sphereDirections(32)) {
            const glm::dvec3 direction = ray.towards;
            const double rise = rays.voxelsPerMm(direction).x;
            const double depth = 2.0 / 44 * 11 * (place.x + rise * 11 / 2);
            const bool takes = method == OcclusionMethod::positional || rise > 0;
            ASSERT_NEAR(rays.light.openness(rays.patient(place), direction), takes ? std::exp(-depth) : 1,
                        1e-6);
        }
    }
}

/// Shadows in a volume that rises and falls from sample to sample, against fine steps through it.
TEST(ReferenceLight, ShadowsInAnyVolume) {
    const Stored stored([](const glm::dvec3& p) {
        const double x = std::sin(12.9898 * p.x + 78.233 * p.y + 37.719 * p.z) * 43758.5453;
        return x - std::floor(x);
    });
    Lighting lighting;
    lighting.lights = {keyLight()};
    Scene scene = stored.scene({});
    scene.lighting = lighting;
    const double most = 0.4;
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0, 0}, {1, most}}, {});
    const auto prepared = stored.prepare(scene);
    RaysOfLight rays(*prepared, scene);
    LatticeReader samples(*prepared->p.layer().cache, prepared->p.info(), 0, nullptr);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int ray = 0; ray < 20; ++ray) {
        const glm::dvec3 extent(stored.info.extentVoxels);
        const glm::dvec3 from = extent * (0.3 + 0.4 * glm::dvec3(unit(random), unit(random), unit(random)));
        const glm::dvec3 direction =
            glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)) - 0.5);
        const glm::dvec3 along = rays.voxelsPerMm(direction);
        constexpr int kSteps = 20000;
        const double mm = 5;
        double depth = 0;
        for (int n = 0; n < kSteps; ++n)
            depth +=
                most * fieldValue<double>(samples, from + mm * (n + 0.5) / kSteps * along, 1.0) * mm / kSteps;
        EXPECT_NEAR(rays.light.shadow(rays.patient(from), direction, mm), std::exp(-depth), 1e-6) << ray;
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
        soft += through(place) / static_cast<double>(rays.sources.casters[1].places.size());
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
    Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, {8, 8});
    scene.lighting = lighting;
    Prepared prepared("torso", scene);
    const FramePlan& p = prepared.p;
    const LightPath path{p.layer().cache.get(), &p.info(),           &p.layer().selection, nullptr,
                         &p.layer().optics,     &p.layer().occupancy};
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

/// The precision of shares of light: rays of light with four times the panels; light along rays of the eye a
/// tenth as coarse.
TEST(ReferenceLight, FinerRaysChangeNothing) {
    Lighting lighting;
    lighting.occlusion = Occlusion{};
    lighting.lights = {keyLight(), Light{}};
    for (const char* preset : {"soft-tissue", "bone-1"}) {
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

} // namespace
} // namespace tessera::test
