// tests/render/light/shadow_views_test.cpp: from where shadow maps look, and how much they hold: the box of
// what shows, soft lights, lights inside the volume, memory; what meshes take beside the volume.
#include "bricking/levels/selection.h"
#include "render/contract/ray.h"
#include "render/light/light_memory.h"
#include "render/light/mesh_shade.h"
#include "render/light/scene_light.h"
#include "render/light/shadow_maps.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

const glm::ivec3 kEvenExtent(70, 75, 100);

/// A medium of one extinction everywhere, and the path of light through it.
struct Even {
    explicit Even(double extinction, bool plain, const glm::ivec3& extent = kEvenExtent)
        : stored([](const glm::dvec3&) { return 1.0; }, extent, plain) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, extinction}, {2, extinction}}, {});
        prepared = stored.prepare(scene);
        const Planner& p = prepared->p;
        path.cache = p.layer().cache.get();
        path.info = &p.info();
        path.selection = &p.layer().selection;
        path.optics = &p.layer().optics;
    }
    glm::dvec3 patient(const glm::dvec3& voxel) const {
        return glm::dvec3(stored.info.patientFromVoxel * glm::dvec4(voxel, 1));
    }
    Stored stored;
    std::unique_ptr<Prepared> prepared;
    LightPath path;
};

/// In an even medium the light left is exp(-tau s), s the way from two samples of the level before the place,
/// as docs/sampling.md has it.
TEST(ShadowMaps, OfAnEvenMediumAreItsClosedForm) {
    const double tau = 0.03;
    const Even even(tau, true);
    ShadowQuality quality;
    quality.mapSize = 32;
    EXPECT_EQ(quality.offset, 2);
    EXPECT_EQ(quality.stepVoxels, 1);
    EXPECT_EQ(quality.error, 1.0f / 128);
    const double bound = 1.0 / 128 + 2e-3;
    for (const glm::dvec3& towards : {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1)}) {
        ShadowMaps maps({false, towards}, even.path, quality);
        maps.build(even.path, 1);
        for (int level = 0; level < 4; ++level)
            for (const glm::dvec3& place : {glm::dvec3(31, 40, 55), glm::dvec3(20, 30, 17)}) {
                const glm::dvec3 faces = glm::max(towards, glm::dvec3(0)) * glm::dvec3(kEvenExtent);
                // At least the distance of two rays.
                const double offset =
                    std::max(2 * std::ldexp(1.0, level), 2 * maps.camera(0).parallelScale / quality.mapSize);
                const double way = glm::dot(faces - place, towards) - offset;
                EXPECT_NEAR(maps.light(place, level), std::exp(-tau * way), bound) << level;
            }
    }
    // From inside, to all six sides; and nearer to the light than the offset nothing is skipped.
    const glm::dvec3 lamp(30, 42, 60);
    ShadowMaps maps({true, {0, 0, 1}, lamp}, even.path, quality);
    ASSERT_EQ(maps.maps().size(), 6u);
    maps.build(even.path, 1);
    for (const glm::dvec3& away : {glm::dvec3(20, 3, -5), glm::dvec3(-25, 6, 1), glm::dvec3(2, 24, 9),
                                   glm::dvec3(1, -28, 12), glm::dvec3(-3, 8, 30), glm::dvec3(4, -5, -26)}) {
        for (int level = 0; level < 3; ++level)
            EXPECT_NEAR(maps.light(lamp + away, level),
                        std::exp(-tau * (glm::length(away) - 2 * std::ldexp(1.0, level))), bound);
    }
    EXPECT_NEAR(maps.light(lamp + glm::dvec3(0, 1.5, 0)), std::exp(-tau * 1.5), bound)
        << "nearer than the offset";
    EXPECT_NEAR(maps.light(lamp + glm::dvec3(0, 0, -7), 2), std::exp(-tau * 7), bound) << "of level 2: 8 mm";
    EXPECT_GE(maps.largestError(), quality.error);
}

/// Spacings count: the offset is by the mean spacing, and ways are in millimetres.
TEST(ShadowMaps, OfAnEvenMediumInAnyLattice) {
    const double tau = 0.03;
    const Even even(tau, false);
    const glm::dmat3 axes(even.stored.info.patientFromVoxel);
    const double offset = 2 * std::cbrt(std::abs(glm::determinant(axes)));
    ShadowQuality quality;
    quality.mapSize = 32;
    const glm::dvec3 lamp = even.patient({35, 30, 48});
    ShadowMaps maps({true, {0, 0, 1}, lamp}, even.path, quality);
    maps.build(even.path, 1);
    for (const glm::dvec3& voxels : {glm::dvec3(22, 2, 3), glm::dvec3(-4, -21, 2), glm::dvec3(3, 1, -17)}) {
        const glm::dvec3 away = axes * voxels;
        EXPECT_NEAR(maps.light(lamp + away), std::exp(-tau * (glm::length(away) - offset)), 1.0 / 128 + 2e-3);
    }
}

/// Maps hold the box of the bricks that show something, as tightly as a square does, and nothing else.
TEST(ShadowMaps, HoldTheBoxOfWhatShows) {
    const Even even(0.1, false);
    const glm::ivec3 grid = brickGrid(kEvenExtent);
    Selection some = *even.path.selection;
    for (std::size_t b = 0; b < some.levels.size(); ++b) {
        const glm::ivec3 at = gridPosition(b, grid);
        some.levels[b] = at == glm::ivec3(1, 0, 3) || at == glm::ivec3(2, 1, 2) ? 0 : Selection::kEmpty;
    }
    LightPath path = even.path;
    path.selection = &some;
    const glm::dvec3 low(32, 0, 64), high(70, 64, 100); // of bricks, held to the volume
    std::vector<glm::dvec3> corners;
    glm::dvec3 middle(0);
    for (int n = 0; n < 8; ++n) {
        corners.push_back(even.patient(
            {(n & 1) != 0 ? high.x : low.x, (n & 2) != 0 ? high.y : low.y, (n & 4) != 0 ? high.z : low.z}));
        middle += corners.back() / 8.0;
    }
    for (const glm::dvec3& direction : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(0.3, -0.7, 0.5),
                                        glm::dvec3(-0.2, 0.1, -0.95)}) {
        const glm::dvec3 towards = glm::normalize(direction);
        const ShadowMaps maps({false, towards}, path, {});
        ASSERT_EQ(maps.maps().size(), 1u);
        EXPECT_EQ(maps.maps()[0]->size(), 512);
        const Camera& camera = maps.camera(0);
        EXPECT_EQ(camera.projection, Projection::parallel);
        EXPECT_LT(glm::distance(camera.focalPoint, middle), 1e-9);
        EXPECT_LT(glm::distance(glm::normalize(camera.position - camera.focalPoint), towards), 1e-12);
        EXPECT_NEAR(glm::dot(camera.viewUp, towards), 0, 1e-12);
        const glm::dvec3 right = glm::cross(camera.viewUp, towards);
        double half = 0;
        for (const glm::dvec3& corner : corners) {
            half = std::max({half, std::abs(glm::dot(corner - middle, right)),
                             std::abs(glm::dot(corner - middle, camera.viewUp))});
            EXPECT_LT(glm::dot(corner - camera.position, towards), 0) << "behind the map";
        }
        EXPECT_NEAR(camera.parallelScale, half, 1e-9);
    }
    // Nothing shows: the first brick's box.
    for (std::uint8_t& level : some.levels)
        level = Selection::kEmpty;
    const ShadowMaps none({false, {0, 0, 1}}, path, {});
    EXPECT_LT(glm::distance(none.camera(0).focalPoint, even.patient({16, 16, 16})), 1e-9);
}

/// A point light has one map while its view of the box is at most 110 degrees wide, and six beyond.
TEST(ShadowMaps, PointLightsHaveOneMapOrSix) {
    const Even even(0.1, true, glm::ivec3(64));
    // The near face's half edge of 32 mm is seen at a distance of d - 32 from d before the middle.
    const double widest = 32 + 32 / std::tan(glm::radians(55.0));
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            glm::dvec3 forward(0);
            forward[axis] = sign;
            const auto maps = [&](double d, double softness) {
                ShadowQuality quality;
                quality.mapSize = 4;
                return ShadowMaps({true, {0, 0, 1}, glm::dvec3(32) + d * forward, softness}, even.path,
                                  quality);
            };
            EXPECT_EQ(maps(widest + 0.01, 0).maps().size(), 1u);
            EXPECT_EQ(maps(widest - 0.01, 0).maps().size(), 6u);
            EXPECT_EQ(maps(20, 0).maps().size(), 6u) << "inside";
            EXPECT_EQ(maps(0, 0).maps().size(), 6u) << "in the middle";
            EXPECT_EQ(maps(20, 5).maps().size(), 24u);
            const ShadowMaps one = maps(132, 0);
            EXPECT_NEAR(one.camera(0).viewAngle, 2 * glm::degrees(std::atan(0.32)), 1e-9)
                << "32 mm at 100 mm";
            EXPECT_LT(
                glm::distance(glm::normalize(one.camera(0).focalPoint - one.camera(0).position), -forward),
                1e-12);
            EXPECT_NEAR(maps(1e5, 0).camera(0).viewAngle, 1, 1e-12) << "at least a degree";
            const ShadowMaps six = maps(20, 0);
            glm::dvec3 sum(0), squares(0);
            for (std::size_t n = 0; n < 6; ++n) {
                const Camera& camera = six.camera(n);
                EXPECT_EQ(camera.viewAngle, 90);
                sum += camera.focalPoint - camera.position;
                squares += (camera.focalPoint - camera.position) * (camera.focalPoint - camera.position);
            }
            EXPECT_LT(glm::length(sum), 1e-12);
            EXPECT_LT(glm::distance(squares, glm::dvec3(2)), 1e-12) << "two of them along each axis";
        }
}

/// A soft light has four maps of half the side, from places of equal areas of its disk, a golden angle apart.
TEST(ShadowMaps, OfSoftLightsLookFromItsDisk) {
    const Even even(0.1, false);
    const double softness = 24, reach = std::tan(glm::radians(12.0));
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    ShadowQuality quality;
    quality.mapSize = 64;
    const glm::dvec3 middle = even.patient(glm::dvec3(kEvenExtent) / 2.0);
    const auto expectDisk = [&](const std::vector<glm::dvec2>& places) {
        ASSERT_EQ(places.size(), 4u);
        for (std::size_t n = 0; n < 4; ++n) {
            EXPECT_NEAR(glm::length(places[n]), reach * std::sqrt((static_cast<double>(n) + 0.5) / 4), 1e-9);
            const double turn = std::atan2(places[n].y, places[n].x) - std::atan2(places[0].y, places[0].x);
            EXPECT_NEAR(std::cos(turn - static_cast<double>(n) * golden), 1, 1e-9) << n;
        }
    };
    for (const glm::dvec3& direction : {glm::dvec3(0, 0, 1), glm::dvec3(0.3, -0.7, 0.5)}) {
        const glm::dvec3 towards = glm::normalize(direction);
        const ShadowMaps hard({false, towards}, even.path, quality);
        const ShadowMaps soft({false, towards, {}, softness}, even.path, quality);
        const glm::dvec3 up = hard.camera(0).viewUp, right = glm::cross(up, towards);
        std::vector<glm::dvec2> places;
        for (std::size_t n = 0; n < soft.maps().size(); ++n) {
            EXPECT_EQ(soft.maps()[n]->size(), 32);
            const Camera& camera = soft.camera(n);
            const glm::dvec3 to = glm::normalize(camera.position - camera.focalPoint);
            places.push_back(glm::dvec2(glm::dot(to, right), glm::dot(to, up)) / glm::dot(to, towards));
        }
        expectDisk(places);
        // A lamp there: its disk is seen from the middle of the box under the same angle.
        const glm::dvec3 position = middle + 900.0 * towards;
        const ShadowMaps lamp({true, {0, 0, 1}, position, softness}, even.path, quality);
        EXPECT_EQ(lamp.position(), position);
        places.clear();
        for (std::size_t n = 0; n < lamp.maps().size(); ++n) {
            const glm::dvec3 off = lamp.camera(n).position - position;
            EXPECT_NEAR(glm::dot(off, towards), 0, 1e-9);
            EXPECT_LT(glm::distance(glm::normalize(lamp.camera(n).focalPoint - lamp.camera(n).position),
                                    glm::normalize(middle - lamp.camera(n).position)),
                      1e-12);
            // Its own right is the other way round: forward is away from the light.
            places.push_back(glm::dvec2(-glm::dot(off, right), glm::dot(off, up)) / 900.0);
        }
        expectDisk(places);
    }
}

/// The share of a soft light is the mean of its maps'; no share exceeds 1.
TEST(ShadowMaps, OfSoftLightsAreTheMean) {
    const double tau = 0.02;
    const Even even(tau, true);
    ShadowQuality quality;
    quality.mapSize = 32;
    const glm::dvec3 place(35, 37, 40);
    ShadowMaps maps({false, {0, 0, 1}, {}, 30}, even.path, quality);
    maps.build(even.path, 2);
    double sum = 0, offset = 2;
    for (std::size_t n = 0; n < 4; ++n) // the distance of two rays of the widest map
        offset = std::max(offset, 2 * maps.camera(n).parallelScale / (quality.mapSize / 2));
    for (std::size_t n = 0; n < 4; ++n) {
        const glm::dvec3 to = glm::normalize(maps.camera(n).position - maps.camera(n).focalPoint);
        // All leave by the upper face.
        sum += std::exp(-tau * ((100 - place.z) / to.z - offset));
    }
    EXPECT_NEAR(maps.light(place), sum / 4, 1.0 / 128 + 2e-3);
    EXPECT_EQ(maps.light({35, 37, 99.9}), 1);
    EXPECT_EQ(maps.light({35, 37, 1000}), 1);
}

/// Memory is that of the maps, whatever their number.
TEST(ShadowMaps, BytesAreThoseOfTheMaps) {
    const Even even(0.1, true, glm::ivec3(64));
    for (const double softness : {0.0, 10.0})
        for (const bool isPoint : {false, true}) {
            Light light;
            light.kind = isPoint ? LightKind::point : LightKind::directional;
            light.frame = LightFrame::patient;
            light.position = glm::dvec3(20);
            light.softness = softness;
            ShadowQuality quality;
            quality.mapSize = 20;
            const ShadowMaps maps(placedLight(light, {}), even.path, quality);
            std::size_t bytes = 0;
            for (const std::shared_ptr<ShadowMap>& map : maps.maps())
                bytes += DeepShadowMap::bytes(map->size());
            EXPECT_EQ(ShadowMaps::bytes(light, quality), bytes);
        }
}

TEST(PlacedLights, AreInPatientSpace) {
    Camera camera;
    camera.position = {10, -20, 30};
    camera.focalPoint = {10, 80, 30};
    camera.viewUp = {0, 0, 1}; // right is +x, towards the viewer -y
    Light light;
    light.direction = {3, 0, 4};
    light.position = {1, 2, 5};
    light.softness = 7;
    const PlacedLight head = placedLight(light, camera);
    EXPECT_FALSE(head.isPoint);
    EXPECT_EQ(head.softness, 7);
    EXPECT_LT(glm::distance(head.towards, {0.6, -0.8, 0}), 1e-12);
    EXPECT_LT(glm::distance(head.position, {11, -25, 32}), 1e-12);
    light.frame = LightFrame::patient;
    light.kind = LightKind::point;
    EXPECT_TRUE(placedLight(light, camera).isPoint);
    EXPECT_LT(glm::distance(placedLight(light, camera).towards, {0.6, 0, 0.8}), 1e-12);
    EXPECT_EQ(placedLight(light, camera).position, light.position);
    light.direction = glm::dvec3(0);
    EXPECT_EQ(placedLight(light, camera).towards, glm::dvec3(0, 0, 1));
}

/// Sides of maps are halved until all take at most an eighth of what is free, down to 32.
TEST(LightMemory, MapsTakeAnEighthOfWhatIsFree) {
    Light light;
    light.kind = LightKind::directional;
    light.shadow = true;
    Lighting one, two, none;
    one.lights = {light, Light{}};
    two.lights = {light, light};
    const auto sideFor = [](const Lighting& lighting, std::size_t free) {
        return shadowQualityFor(lighting, free).mapSize;
    };
    EXPECT_EQ(sideFor(none, 0), 512);
    for (const int side : {512, 256, 128, 64}) {
        const std::size_t bytes = DeepShadowMap::bytes(side);
        EXPECT_EQ(sideFor(one, 8 * bytes), side);
        EXPECT_EQ(sideFor(one, 8 * bytes - 1), side / 2);
        EXPECT_EQ(sideFor(two, 16 * bytes), side);
        EXPECT_EQ(sideFor(two, 16 * bytes - 1), side / 2);
    }
    EXPECT_EQ(sideFor(one, 0), 32);
    EXPECT_EQ(sideFor(one, std::size_t{1} << 40), 512);
}

/// What light takes: nothing without channels; maps twice where meshes shade; working sets by threads.
TEST(LightMemory, IsTheSumOfItsParts) {
    VolumeInfo info;
    info.extentVoxels = kEvenExtent;
    Light light;
    light.kind = LightKind::directional;
    light.shadow = true;
    ShadowQuality quality;
    quality.mapSize = 64;
    const auto bytes = [&](int shadows, bool occludes, int threads, bool meshes = false,
                           bool others = false) {
        Lighting lighting;
        lighting.lights.assign(static_cast<std::size_t>(shadows), light);
        lighting.lights.emplace_back();
        if (occludes)
            lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
        return lightRamBytes(lighting, info, quality, threads, meshes, others);
    };
    const std::size_t map = DeepShadowMap::bytes(64), room = OcclusionRoom::bytes(glm::ivec3(0));
    EXPECT_EQ(bytes(0, false, 4), 0u);
    EXPECT_EQ(bytes(1, false, 3) - bytes(1, false, 1), 2 * room);
    EXPECT_EQ(bytes(1, false, 1, true) - bytes(1, false, 1), map);
    EXPECT_EQ(bytes(2, false, 1, true) - bytes(2, false, 1), 2 * map);
    EXPECT_EQ(bytes(1, false, 1, false, true), bytes(1, false, 1));
    // A channel more: a map, and the texels of the chunks that are kept.
    const std::size_t channel = bytes(2, false, 1) - bytes(1, false, 1);
    EXPECT_EQ(bytes(3, false, 1) - bytes(2, false, 1), channel);
    EXPECT_EQ(bytes(1, false, 1), room + channel);
    EXPECT_GE(channel - map, 128 * kChunkTexels * sizeof(std::uint16_t));
    // With rays, extinctions of chunks: of all that the volume has, twice among others.
    const std::size_t extinctions = ChunkExtinctions::bytes(info, 2);
    EXPECT_EQ(bytes(0, true, 2, false, true) - bytes(0, true, 2), extinctions);
    std::size_t chunks = 0;
    for (int level = 0; level < kLevelCount; ++level)
        chunks += cellCount(chunkGrid(kEvenExtent, level));
    EXPECT_GE(extinctions, chunks * kChunkTexels * sizeof(float)) << "fewer chunks than are kept";
    EXPECT_LE(extinctions, chunks * (kChunkTexels * sizeof(float) + 2 * kChunkExtent * kChunkExtent));
    info.extentVoxels = glm::ivec3(2048);
    EXPECT_EQ(ChunkExtinctions::bytes(info, 5) /
                  (ChunkExtinctions::bytes(info, 5) - ChunkExtinctions::bytes(info, 4)),
              ChunkExtinctions::kMost + 5);
    const glm::ivec3 reach = occlusionRays(Occlusion{.rays = 8, .radiusMm = 6}, info, 0).reach;
    EXPECT_GT(bytes(0, true, 2) - bytes(0, true, 1), OcclusionRoom::bytes(reach));
}

/// The report tells what the maps are.
TEST(SceneLight, ReportsItsMaps) {
    const Stored stored(
        [](const glm::dvec3& p) { return p.z > 30 ? 1 + std::sin(0.7 * p.x + 0.3 * p.z) : 0; }, {40, 48, 70});
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0.5, 0}, {2, 0.2}}, {});
    Light light;
    light.kind = LightKind::directional;
    light.frame = LightFrame::patient;
    light.direction = {0.2, 0.3, 1};
    light.shadow = true;
    scene.lighting.lights = {light, light};
    scene.lighting.lights[1].softness = 8;
    const auto prepared = stored.prepare(scene);
    prepared->p.view.shadowQuality.mapSize = 24;
    prepared->p.view.shadowQuality.error = 1e-6f; // more than eight layers hold
    SceneLight lit(prepared->p, 1);
    EXPECT_FALSE(lit.mapsAreWhole());
    lit.ready();
    EXPECT_TRUE(lit.mapsAreWhole());
    EXPECT_FALSE(lit.makeMaps()) << "they are";
    lit.took(1.5), lit.took(0.25);
    const LightReport report = lit.report(1234);
    EXPECT_EQ(report.channels, 2);
    EXPECT_FALSE(report.emission);
    EXPECT_EQ(report.planeBytes, 1234u);
    EXPECT_EQ(report.maps, 5u);
    EXPECT_EQ(report.mapSize, 12) << "of the last, a soft light's";
    EXPECT_EQ(report.mapBytes, DeepShadowMap::bytes(24) + 4 * DeepShadowMap::bytes(12));
    EXPECT_EQ(report.seconds, 1.75);
    float error = 0;
    double more = 0;
    for (std::size_t n = 0; n < 2; ++n) {
        const ShadowMaps& maps = lit.shadows()[n];
        error = std::max(error, maps.largestError());
        more += (n == 0 ? 1 : 4) * maps.shareOfMore() / 5;
    }
    EXPECT_EQ(report.mapError, error);
    EXPECT_GT(error, 1e-6f);
    EXPECT_NEAR(report.shareOfMore, more, 1e-5);
    EXPECT_GT(more, 0);
    EXPECT_LT(more, 1);
}

/// An edit changes the parts of light that follow from it, and no others.
TEST(SceneLight, TellsWhatAnEditChanges) {
    const Stored stored([](const glm::dvec3& p) { return p.z; }, {40, 36, 33});
    Light sun, plain;
    sun.kind = plain.kind = LightKind::directional;
    sun.frame = plain.frame = LightFrame::patient;
    sun.direction = {0.2, 0.3, 1};
    sun.shadow = true;
    const auto changed = [&](const std::function<void(Lighting&)>& edit, double scatter, bool occludes = true,
                             const std::function<void(Lighting&)>& before = {}) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{5, 0}, {30, 0.1}}, {});
        scene.lighting.lights = {sun, plain};
        scene.lighting.lights[0].scatter = scatter;
        if (occludes)
            scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
        if (before)
            before(scene.lighting);
        const auto prepared = stored.prepare(scene);
        Planner& p = prepared->p;
        p.view.shadowQuality.mapSize = 8;
        SceneLight light(p, 1);
        light.ready();
        EXPECT_TRUE(light.mapsAreWhole());
        EXPECT_EQ(light.takeChanges(), 0u) << "the same function";
        edit(p.view.lighting);
        const LightParts parts = light.lightingChanged();
        EXPECT_EQ(light.mapsAreWhole(), (parts & kShadowLight) == 0 || light.voxels().finestLevel() == 1);
        EXPECT_EQ(light.lightingChanged(), 0u) << "once";
        return parts;
    };
    const auto nothing = [](Lighting&) {};
    EXPECT_EQ(changed(nothing, 0), 0u);
    EXPECT_EQ(changed(nothing, 1), 0u);
    for (const double scatter : {0.0, 0.7}) {
        const LightParts byLight = scatter > 0 ? kAmbientLight : 0u;
        EXPECT_EQ(changed([](Lighting& l) { l.lights[0].intensity = 0.4; }, scatter), byLight);
        EXPECT_EQ(changed([](Lighting& l) { l.lights[1].direction = {1, 0, 0}; }, scatter), byLight);
        const LightParts byMaps = kShadowLight | byLight;
        EXPECT_EQ(changed([](Lighting& l) { l.lights[0].direction.x = 0.3; }, scatter), byMaps);
        EXPECT_EQ(changed([](Lighting& l) { l.lights[0].softness = 3; }, scatter), byMaps);
        EXPECT_EQ(changed([](Lighting& l) { l.lights[0].frame = LightFrame::camera; }, scatter), byMaps);
        EXPECT_EQ(changed([](Lighting& l) { l.lights[0].kind = LightKind::point; }, scatter), byMaps);
        EXPECT_EQ(changed([](Lighting& l) { l.scatterRadiusMm = 5; }, scatter), byLight);
        EXPECT_EQ(changed([](Lighting& l) { l.occlusion->radiusMm = 7; }, scatter), kAmbientLight);
        EXPECT_EQ(changed([](Lighting& l) { l.occlusion->bias = 0.3; }, scatter), kAmbientLight);
        EXPECT_EQ(changed([](Lighting& l) { l.finestLevel = 1; }, scatter), kAllLight);
    }
    EXPECT_EQ(changed([](Lighting& l) { l.lights[0].intensity = 0.4; }, 0, false), 0u);
    // Light maps, and with them all light: other ones, of other lights, or none.
    const auto ofMaps = [&](const std::function<void(Lighting&)>& edit) {
        return changed([&](Lighting& l) { edit(l); }, 0.7, true,
                       [](Lighting& l) { l.scatterBy = ScatterSource::map; });
    };
    EXPECT_EQ(ofMaps([](Lighting& l) { l.lights[0].scatter = 1; }), kAmbientLight);
    EXPECT_EQ(ofMaps([](Lighting& l) { l.lights[0].intensity = 0.4; }), kAmbientLight);
    EXPECT_EQ(ofMaps([](Lighting& l) { l.lightMap.g = 0.5; }), kAllLight);
    EXPECT_EQ(ofMaps([](Lighting& l) { l.lightMap.size = 48; }), kAllLight);
    EXPECT_EQ(ofMaps([](Lighting& l) { l.scatterBy = ScatterSource::rays; }), kAllLight);
    EXPECT_EQ(changed([](Lighting& l) { l.scatterBy = ScatterSource::map; }, 0.7), kAllLight);
    EXPECT_EQ(changed([](Lighting& l) { l.lightMap.g = 0.5; }, 0.7), 0u) << "of rays";
    // The camera moves a light that is fixed to it, and no other.
    for (const LightFrame frame : {LightFrame::patient, LightFrame::camera}) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{5, 0}, {30, 0.1}}, {});
        scene.lighting.lights = {sun, plain};
        scene.lighting.lights[0].frame = frame;
        scene.lighting.lights[1].frame = LightFrame::camera; // without a shadow
        const auto prepared = stored.prepare(scene);
        prepared->p.view.shadowQuality.mapSize = 8;
        SceneLight light(prepared->p, 1);
        light.ready();
        light.viewChanged();
        EXPECT_EQ(light.viewIsNew(), frame == LightFrame::camera);
        EXPECT_EQ(light.mapsAreWhole(), frame == LightFrame::patient);
        EXPECT_EQ(light.makeMaps(), frame == LightFrame::camera);
        EXPECT_TRUE(light.mapsAreWhole());
        // Coarse ones are made where there are none, or where the view counts: a quarter of the side.
        EXPECT_FALSE(light.makeCoarseMaps(true));
        light.viewChanged();
        EXPECT_FALSE(light.makeCoarseMaps(false));
        EXPECT_EQ(light.makeCoarseMaps(true), frame == LightFrame::camera);
        EXPECT_EQ(light.shadows()[0].maps()[0]->size(), frame == LightFrame::camera ? 2 : 8);
        EXPECT_EQ(light.mapsAreWhole(), frame == LightFrame::patient);
        light.levelsChanged();
        EXPECT_FALSE(light.mapsAreWhole());
        EXPECT_TRUE(light.makeMaps());
        EXPECT_EQ(light.shadows()[0].maps()[0]->size(), 8);
    }
}

/// Maps that are cast in parts, and whose view, levels or lights change amid that, are those of the new ones.
TEST(SceneLight, BeginsMapsAgainWhereSomethingChanges) {
    const Stored stored([](const glm::dvec3& p) { return p.z; }, {40, 36, 33});
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{5, 0}, {30, 0.1}}, {});
    Light sun;
    sun.kind = LightKind::directional;
    sun.direction = {0.2, 0.3, 1};
    sun.shadow = true;
    scene.lighting.lights = {sun};
    constexpr auto kPassed = SceneLight::Deadline::min();
    for (int change = 0; change < 3; ++change) {
        const auto prepared = stored.prepare(scene);
        Planner& p = prepared->p;
        p.view.shadowQuality.mapSize = 24;
        SceneLight light(p, 1);
        EXPECT_FALSE(light.makeMapsUntil(kPassed)) << "eight of 24 rows";
        if (change == 0) {
            p.view.camera.position = p.view.camera.focalPoint + glm::dvec3(40, -90, 70);
            light.viewChanged();
        } else if (change == 1) {
            Selection coarse = p.layer().selection;
            coarse.counts = {};
            for (std::uint8_t& level : coarse.levels) {
                level = level == Selection::kEmpty ? level : std::uint8_t{2};
                ++coarse.counts[level];
            }
            p.setSelection(coarse);
            light.levelsChanged();
        } else {
            p.view.lighting.lights[0].direction = {-1, 0, 0.1};
            EXPECT_EQ(light.lightingChanged(), kShadowLight);
        }
        int rounds = 1;
        while (!light.makeMapsUntil(kPassed) && rounds < 9)
            ++rounds;
        EXPECT_EQ(rounds, 3) << "from the first row on";
        EXPECT_TRUE(light.mapsAreWhole());
        SceneLight fresh(p, 1);
        EXPECT_TRUE(fresh.makeMaps());
        const float* const mine = light.shadows()[0].maps()[0]->numbers();
        const float* const its = fresh.shadows()[0].maps()[0]->numbers();
        EXPECT_TRUE(std::equal(mine, mine + 24 * 24 * 2 * DeepShadowMap::kLayers, its)) << change;
    }
}

/// Light behind a volume and surfaces is the product of what each lets through.
TEST(MeshShade, IsTheProductOfVolumeAndSurfaces) {
    const auto of = [](const std::vector<LightLeft>& samples, double mm) {
        if (samples.empty() || mm < static_cast<double>(samples.front().mm))
            return samples.empty() ? 1.0 : double{samples.front().light};
        for (std::size_t n = 1; n < samples.size(); ++n)
            if (mm < static_cast<double>(samples[n].mm)) {
                const double from = samples[n - 1].mm, to = samples[n].mm;
                return std::lerp(double{samples[n - 1].light}, double{samples[n].light},
                                 (mm - from) / (to - from));
            }
        return double{samples.back().light};
    };
    std::mt19937 random(5);
    std::uniform_real_distribution<double> part(0, 1);
    std::vector<LightLeft> shaded;
    for (int turn = 0; turn < 200; ++turn) {
        std::vector<LightLeft> samples;
        for (int n = 0; n < turn % 5; ++n)
            samples.push_back({static_cast<float>(10 * n + 9 * part(random)),
                               n == 0 ? 1.0f : static_cast<float>(samples.back().light * part(random))});
        std::vector<ShadeStep> steps;
        for (int n = 0; n < turn % 4; ++n)
            steps.push_back({60 * part(random) - 5, part(random)});
        if (turn % 7 == 0 && !steps.empty() && !samples.empty())
            steps[0].t = samples.back().mm; // where a sample is
        std::sort(steps.begin(), steps.end(),
                  [](const ShadeStep& a, const ShadeStep& b) { return a.t < b.t; });
        shadeSamples(samples, steps, shaded);
        EXPECT_TRUE(std::is_sorted(shaded.begin(), shaded.end(),
                                   [](const LightLeft& a, const LightLeft& b) { return a.mm < b.mm; }));
        for (double mm = -10; mm < 70; mm += 1.37) {
            double left = of(samples, mm);
            for (const ShadeStep& step : steps)
                left *= step.t < mm ? 1 - step.opacity : 1;
            ASSERT_NEAR(of(shaded, mm), left, 1e-5) << turn << ", " << mm;
        }
    }
}

} // namespace
} // namespace tessera::test
