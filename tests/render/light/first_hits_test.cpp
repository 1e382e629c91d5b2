// tests/render/light/first_hits_test.cpp: shadow maps of first hits and variance maps: closed forms, sums
// made once more, maps of volumes, engines, memory, and scenes without them.
#include "render/light/first_hit_map.h"
#include "render/light/light_memory.h"
#include "render/light/scene_light.h"
#include "tests/support/lit_picture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <chrono>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();

TEST(FirstHit, IsWhereLightPassesTheThreshold) {
    const std::vector<LightLeft> samples = {{10, 1}, {12, 1}, {14, 0.6f}, {18, 0.2f}, {20, 0}};
    EXPECT_FLOAT_EQ(firstHit(samples, 0.4f), 14);
    EXPECT_FLOAT_EQ(firstHit(samples, 0.2f), 13);
    EXPECT_FLOAT_EQ(firstHit(samples, 0.7f), 17);
    EXPECT_FLOAT_EQ(firstHit(samples, 0.999f), 19.99f);
    const std::vector<LightLeft> thin = {{10, 1}, {30, 0.55f}};
    EXPECT_EQ(firstHit(thin, 0.5f), kNever);
    EXPECT_EQ(firstHit({}, 0.5f), kNever);
    const std::vector<LightLeft> begins = {{5, 0.25f}, {6, 0.2f}};
    EXPECT_FLOAT_EQ(firstHit(begins, 0.5f), 5);
}

/// Something opaque at a distance, or nothing.
void put(ShadowMap& map, const glm::ivec2& ray, float mm) {
    const std::vector<LightLeft> wall = {{mm, 1}, {mm + 1e-4f, 0}};
    EXPECT_EQ(
        map.fit(ray, mm < kNever ? std::span<const LightLeft>(wall) : std::span<const LightLeft>(), 0.25f),
        0);
}

/// Distances of random rays, a third of which meet nothing.
std::vector<float> randomWalls(int size, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> mm(10, 40);
    std::vector<float> walls;
    for (int n = 0; n < size * size; ++n)
        walls.push_back(random() % 3 == 0 ? kNever : mm(random));
    return walls;
}

TEST(FirstHitMap, TellsTheShareOfRaysAround) {
    constexpr int kSize = 9;
    const std::vector<float> walls = randomWalls(kSize, 5);
    for (const int filter : {0, 1, 3})
        for (const float bias : {0.0f, 2.5f}) {
            FirstHitMap map(kSize, {0.5f, filter, bias});
            for (int n = 0; n < kSize * kSize; ++n)
                put(map, {n % kSize, n / kSize}, walls[static_cast<std::size_t>(n)]);
            map.finish();
            for (int y = -2; y < kSize + 2; ++y)
                for (int x = -2; x < kSize + 2; ++x)
                    for (const float mm : {5.0f, 22.0f, 31.0f, 100.0f}) {
                        double lit = 0;
                        for (int j = y - filter; j <= y + filter; ++j)
                            for (int i = x - filter; i <= x + filter; ++i) {
                                const bool inside = i >= 0 && j >= 0 && i < kSize && j < kSize;
                                lit += !inside || walls[static_cast<std::size_t>(j * kSize + i)] + bias >= mm;
                            }
                        const glm::vec2 at(static_cast<float>(x) + 0.25f, static_cast<float>(y) + 0.75f);
                        ASSERT_NEAR(map.between(at, mm), lit / std::pow(2 * filter + 1, 2), 1e-6)
                            << x << " " << y << " " << mm;
                    }
        }
    EXPECT_EQ(FirstHitMap(4, {}).between({2, 2}, 1e6f), 1) << "rays that are not stored meet nothing";
}

/// Chebyshev's bound, once more, from all rays around.
TEST(VarianceMap, BoundsTheShareOfRaysAround) {
    constexpr int kSize = 8, kFilter = 2;
    constexpr float kMiddle = 25, kLeast = 0.01f;
    const std::vector<float> walls = randomWalls(kSize, 9);
    VarianceMap map(kSize, {0.5f, kFilter, 0}, kMiddle, kLeast);
    for (int n = 0; n < kSize * kSize; ++n)
        put(map, {n % kSize, n / kSize}, walls[static_cast<std::size_t>(n)]);
    map.finish();
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            double hits = 0, sum = 0, squares = 0, all = 0;
            // Where a box is cut by the map's edge, along one axis and then the other.
            for (int j = std::max(0, y - kFilter); j <= std::min(kSize - 1, y + kFilter); ++j)
                for (int i = std::max(0, x - kFilter); i <= std::min(kSize - 1, x + kFilter); ++i) {
                    ++all;
                    if (const double mm = walls[static_cast<std::size_t>(j * kSize + i)]; mm < 1e6)
                        ++hits, sum += mm, squares += mm * mm;
                }
            for (const double mm : {5.0, 20.0, 30.0, 45.0}) {
                const double mean = sum / hits, variance = std::max(squares / hits - mean * mean, 1e-4);
                const double passes = mm <= mean ? 1 : variance / (variance + (mm - mean) * (mm - mean));
                const double lit =
                    mm <= mean ? 1 : 1 - hits / all + hits / all * std::max(0.0, (passes - 0.2) / 0.8);
                const glm::vec2 at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                ASSERT_NEAR(map.between(at, static_cast<float>(mm)), lit, 2e-4) << x << " " << y << " " << mm;
            }
        }
    // Between rays their moments are mixed; beyond the edge nothing is met.
    VarianceMap two(2, {0.5f, 0, 0}, 0, kLeast);
    for (const int y : {0, 1})
        put(two, {0, y}, 10), put(two, {1, y}, 20);
    two.finish();
    EXPECT_NEAR(two.between({1, 1}, 20), (25.0 / 50 - 0.2) / 0.8, 1e-3);
    EXPECT_NEAR(two.between({0.5f, 0.5f}, 11), 0, 1e-3);
    EXPECT_NEAR(two.between({0, 1}, 11), 0.5, 1e-3) << "half of it beyond";
    EXPECT_EQ(two.between({-3, 1}, 11), 1);
    VarianceMap tilted(2, {0.5f, 0, 3}, 0, kLeast);
    put(tilted, {0, 0}, 10);
    tilted.finish();
    EXPECT_EQ(tilted.between({0.5f, 0.5f}, 12.5f), 1);
    EXPECT_LT(tilted.between({0.5f, 0.5f}, 14), 0.1);
}

/// Places far beyond a map, or nowhere, meet nothing: no number is cast that does not fit.
TEST(FirstHits, MeetNothingFarBeyondAMap) {
    FirstHitMap first(4, {0.5f, 8, 0});
    VarianceMap variance(4, {0.5f, 8, 0}, 0, 0.1f);
    for (ShadowMap* map : {static_cast<ShadowMap*>(&first), static_cast<ShadowMap*>(&variance)}) {
        for (int n = 0; n < 16; ++n)
            put(*map, {n % 4, n / 4}, 1);
        map->finish();
        for (const float far : {1e4f, 1e20f, kNever, -1e20f, std::nanf("")}) {
            EXPECT_EQ(map->between({far, 2}, 50), 1) << far;
            EXPECT_EQ(map->between({2, far}, 50), 1) << far;
        }
        EXPECT_LT(map->between({2, 2}, 50), 0.95);
    }
}

TEST(FirstHits, TakeTheirPartOfADeepMapsMemory) {
    for (const int size : {1, 64, 512}) {
        EXPECT_EQ(16 * FirstHitMap::bytes(size), DeepShadowMap::bytes(size));
        EXPECT_EQ(3 * FirstHitMap::bytes(size), VarianceMap::bytes(size));
        EXPECT_EQ(FirstHitMap(size, {}).bytes(), FirstHitMap::bytes(size));
        EXPECT_EQ(VarianceMap(size, {}, 0, 1).bytes(), VarianceMap::bytes(size));
    }
    Light light = keyLight();
    ShadowQuality quality;
    EXPECT_EQ(quality.mapping, ShadowMapping{});
    EXPECT_EQ(ShadowMaps::bytes(light, quality), DeepShadowMap::bytes(quality.mapSize));
    quality.mapping.kind = ShadowMapKind::first;
    EXPECT_EQ(ShadowMaps::bytes(light, quality), FirstHitMap::bytes(quality.mapSize));
    // So they are larger where memory is short.
    Lighting lighting;
    lighting.lights = {light};
    const std::size_t free = 8 * DeepShadowMap::bytes(128);
    EXPECT_EQ(shadowQualityFor(lighting, free).mapSize, 128);
    lighting.shadowMap.kind = ShadowMapKind::first;
    EXPECT_EQ(shadowQualityFor(lighting, free).mapSize, 512);
}

/// A slab that hides what is behind it, above a slope: what each kind of map tells of its shadow.
class FirstHitShadows : public testing::TestWithParam<ShadowMapKind> {
  protected:
    FirstHitShadows() {
        Scene scene = stored_.scene({});
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, 0}, {99, 0}, {100, 2}, {101, 2}}, {});
        prepared_ = stored_.prepare(scene);
        const Planner& p = prepared_->p;
        path_.cache = p.layer().cache.get();
        path_.info = &p.info();
        path_.selection = &p.layer().selection;
        path_.optics = &p.layer().optics;
        quality_.mapSize = 64;
        quality_.mapping = {GetParam(), 0.5, 1};
    }
    ShadowMaps maps(const PlacedLight& light) {
        ShadowMaps maps(light, path_, quality_);
        maps.build(path_, 2);
        return maps;
    }
    const Stored stored_{[](const glm::dvec3& p) { return p.z >= 40 && p.z < 44 && p.x < 32 ? 100.0 : 0.0; },
                         glm::ivec3(64), true};
    std::unique_ptr<Prepared> prepared_;
    LightPath path_;
    ShadowQuality quality_;
};

TEST_P(FirstHitShadows, AreWhereTheSlabHidesTheLight) {
    const ShadowMaps sun = this->maps({false, {0, 0, 1}});
    const ShadowMaps lamp = this->maps({true, {0, 0, 1}, {16, 32, 200}});
    const ShadowMaps inside = this->maps({true, {0, 0, 1}, {16, 32, 55}});
    for (const ShadowMaps* maps : {&sun, &lamp, &inside}) {
        EXPECT_NEAR(maps->light({16, 32, 20}), 0, 0.01) << "behind it";
        EXPECT_NEAR(maps->light({16, 32, 50}), 1, 0.01) << "before it";
        if (maps != &inside) {
            EXPECT_NEAR(maps->light({50, 32, 20}), 1, 0.01) << "beside it";
        }
        EXPECT_NEAR(maps->light({16, 32, 43.5}), 1, 0.01) << "its lit side, by the offset";
    }
    EXPECT_EQ(inside.maps().size(), 6u);
    // The bias is a distance of rays for each ray of the filter, at most four voxels.
    if (GetParam() == ShadowMapKind::first)
        for (const auto& [filter, most] : {std::pair(0, 4.0), std::pair(2, 4.0), std::pair(8, 4.0)}) {
            quality_.mapping.filter = filter;
            const ShadowMaps biased = this->maps({false, {0, 0, 1}});
            const double bias =
                std::min(most, filter * 2 * biased.camera(0).parallelScale / quality_.mapSize);
            const double hit = 43.5; // as near as the slab's rise and a segment's ends tell
            EXPECT_EQ(biased.light({16, 32, hit - 2 - bias + 1.2}), 1) << filter;
            EXPECT_EQ(biased.light({16, 32, hit - 2 - bias - 1.2}), 0) << filter;
        }
    quality_.mapping.filter = 1;
    // Packets of places are these places.
    float run[native::kOcclusionRun];
    for (const native::PacketTarget* target : nativeTargets()) {
        sun.light({20, 30, 20}, {2, 0.25, 1}, 1, *target, run);
        for (int n = 0; n < native::kOcclusionRun; ++n)
            EXPECT_NEAR(run[n], sun.light(glm::dvec3(20, 30, 20) + double(n) * glm::dvec3(2, 0.25, 1), 1),
                        1e-5);
    }
    // Rows at a time are the same maps.
    ShadowMaps parts({false, {0, 0, 1}}, path_, quality_);
    int turns = 1;
    while (!parts.buildUntil(path_, 1, std::chrono::steady_clock::time_point()))
        ++turns;
    EXPECT_EQ(turns, 8);
    for (double x = 20; x < 40; x += 0.7)
        EXPECT_EQ(parts.light({x, 30, 20}), sun.light({x, 30, 20}));
}

/// Outside of a closed shell around a lamp it is dark to all sides: at edges and corners of its six views,
/// too.
TEST_P(FirstHitShadows, HaveNoSeamsBetweenSixViews) {
    const glm::dvec3 lamp(32);
    const Stored stored(
        [&](const glm::dvec3& p) {
            const double r = glm::length(p - lamp);
            return r > 10 && r < 16 ? 100.0 : 0.0;
        },
        glm::ivec3(64), true);
    Scene scene = stored.scene({});
    scene.volumes[0].transferFunction =
        TransferFunction::fromExtinction({{0, 0}, {50, 0}, {100, 2}, {101, 2}}, {});
    const auto prepared = stored.prepare(scene);
    const Planner& p = prepared->p;
    path_.cache = p.layer().cache.get();
    path_.info = &p.info();
    path_.selection = &p.layer().selection;
    path_.optics = &p.layer().optics;
    const ShadowMaps all = maps({true, {0, 0, 1}, lamp});
    ASSERT_EQ(all.maps().size(), 6u);
    for (const glm::dvec3& to :
         {glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0), glm::dvec3(0, -1, 1), glm::dvec3(1, 1, 1),
          glm::dvec3(-1, 1, -1), glm::dvec3(1, 0.98, 0.2), glm::dvec3(1, 1.03, -0.97)}) {
        const glm::dvec3 towards = glm::normalize(to);
        EXPECT_NEAR(all.light(lamp + 24.0 * towards), 0, 0.02) << to.x << " " << to.y << " " << to.z;
        EXPECT_NEAR(all.light(lamp + 6.0 * towards), 1, 0.02);
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, FirstHitShadows,
                         testing::Values(ShadowMapKind::deep, ShadowMapKind::first, ShadowMapKind::variance));

/// Thin tissue casts all of a shadow or none, where deep maps have a part of it.
TEST(FirstHitShadowsOfThinTissue, AreAllOrNothing) {
    const Stored stored([](const glm::dvec3&) { return 1.0; }, glm::ivec3(64), true);
    for (const double tau : {0.005, 0.03}) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0, tau}, {2, tau}}, {});
        const auto prepared = stored.prepare(scene);
        const Planner& p = prepared->p;
        LightPath path;
        path.cache = p.layer().cache.get();
        path.info = &p.info();
        path.selection = &p.layer().selection;
        path.optics = &p.layer().optics;
        ShadowQuality quality;
        quality.mapSize = 32;
        quality.mapping = {ShadowMapKind::first, 0.5, 0};
        ShadowMaps maps({false, {0, 0, 1}}, path, quality);
        maps.build(path, 1);
        const double half = std::log(2.0) / tau; // from the face, of half of the light
        for (const double z : {60.0, 50.0, 30.0, 10.0}) {
            const double offset = std::max(2.0, 2 * 2 * maps.camera(0).parallelScale / quality.mapSize / 2);
            const double way = 64 - z - offset;
            if (std::abs(way - half) > 0.5) {
                EXPECT_EQ(maps.light({32, 32, z}), way < half ? 1 : 0) << tau << " " << z;
            }
        }
    }
}

/// Engines read planes of light and learn nothing of what fills them.
TEST(FirstHitShadowsOfPictures, NativeHasTheMirrorsBits) {
    for (const ShadowMapKind kind : {ShadowMapKind::first, ShadowMapKind::variance}) {
        Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 1, {24, 24});
        scene.lighting.lights = {keyLight(kind == ShadowMapKind::first ? 0 : 8), Light{}};
        scene.lighting.shadowMap = {kind, 0.3, 2};
        Prepared prepared("torso", scene);
        prepared.p.view.shadowQuality.mapSize = 64;
        const Image mirror = mirrorLit(prepared);
        for (const native::PacketTarget* target : nativeTargets()) {
            NativeChoices choices;
            choices.target = target;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u) << target->name;
        }
        scene.lighting.shadowMap = {};
        Prepared deep("torso", scene);
        deep.p.view.shadowQuality.mapSize = 64;
        EXPECT_GT(differing(mirrorLit(deep), mirror), 20u);
    }
}

/// A change of the kind is a change of shadows alone.
TEST(FirstHitShadowsOfPictures, FollowAChangeOfTheKind) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 1, {24, 24});
    scene.lighting.lights = {keyLight()};
    scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 4};
    Prepared prepared("torso", scene);
    prepared.p.view.shadowQuality.mapSize = 32;
    SceneLight light(prepared.p, 1);
    light.ready();
    EXPECT_EQ(light.report(0).mapKind, ShadowMapKind::deep);
    EXPECT_EQ(light.report(0).mapBytes, DeepShadowMap::bytes(32));
    prepared.p.view.lighting.shadowMap.kind = ShadowMapKind::variance;
    EXPECT_EQ(light.lightingChanged(), kShadowLight);
    EXPECT_FALSE(light.mapsAreWhole());
    light.ready();
    EXPECT_EQ(light.report(0).mapKind, ShadowMapKind::variance);
    EXPECT_EQ(light.report(0).mapBytes, VarianceMap::bytes(32));
    prepared.p.view.lighting.shadowMap.filter = 3;
    EXPECT_EQ(light.lightingChanged(), kShadowLight);
    EXPECT_EQ(light.lightingChanged(), LightParts{0}) << "nothing has changed since";
    prepared.p.view.lighting.shadowMap = {};
    EXPECT_EQ(light.lightingChanged(), kShadowLight);
    light.ready();
    prepared.p.view.lighting.shadowMap.filter = 5;
    EXPECT_EQ(light.lightingChanged(), LightParts{0}) << "deep maps have no filter";
    EXPECT_TRUE(light.mapsAreWhole());
}

} // namespace
} // namespace tessera::test
