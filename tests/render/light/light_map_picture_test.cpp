// tests/render/light/light_map_picture_test.cpp: light maps of volumes: that they see what shadows see, of
// lights of every kind, however they are built; in pictures by engines; what they take.
#include "render/geometry/tube_shape.h"
#include "render/light/light_memory.h"
#include "render/light/light_sweep.h"
#include "tests/support/light_maps.h"
#include "tests/support/lit_picture.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <vector>

namespace tessera::test {
namespace {

/// An even medium in a box of 48 mm, seen from a light.
struct EvenBox {
    explicit EvenBox(const PlacedLight& light, const glm::vec3& colour = {0.8f, 0.6f, 0.4f},
                     double extinction = 0.08)
        : stored([](const glm::dvec3&) { return 1.0; }, glm::ivec3(48), true) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction =
            TransferFunction::fromExtinction({{0, extinction}, {2, extinction}}, {{0, colour}, {2, colour}});
        prepared = stored.prepare(scene);
        made.emplace(*prepared, light, LightMapping{32, 0.8}, 16, 1);
    }
    glm::vec3 at(const glm::dvec3& place) const { return made->maps.scattered(place); }
    Stored stored;
    std::unique_ptr<Prepared> prepared;
    std::optional<MadeMaps> made;
};

/// The numbers of a map are those of slices that are known beforehand, and its nodes are where it says.
TEST(LightMapPicture, SeesTheTissueThatShadowsSee) {
    const PlacedLight above{false, {0, 0, 1}, {}, 0, true};
    for (const double extinction : {0.08, 0.5}) { // and where next to no light comes through
        const EvenBox box(above, {0.8f, 0.6f, 0.4f}, extinction);
        ASSERT_EQ(box.made->maps.lightMaps().size(), 1u);
        const LightMap& map = *box.made->maps.lightMaps().front();
        const LightGrid& grid = map.grid();
        EXPECT_EQ(grid.size, 32);
        EXPECT_EQ(grid.slices, 32);
        EXPECT_NEAR(grid.sliceMm, 1.5, 1e-9);
        MapSweep sweep(grid, 0.8);
        LightMap expected(grid);
        const std::vector<LightSlice> slices(32, {static_cast<float>(extinction * 1.5), {0.8f, 0.6f, 0.4f}});
        for (int n = 0; n < 32 * 32; ++n)
            sweep.setRay({n % 32, n / 32}, slices);
        sweep.run(1, expected);
        int most = 0;
        for (std::size_t n = 0; n < grid.nodes(); ++n)
            for (int c = 0; c < 3; ++c)
                most = std::max(most, std::abs(map.node(n)[c] - expected.node(n)[c]));
        EXPECT_LT(most, 20) << "of 16384, at " << extinction;
        for (const double depth : {1.0, 7.0, 20.0, 40.0}) {
            const glm::vec3 light = box.at({20, 27, 48 - depth});
            const glm::vec3 same =
                expected.at({32 * 20 / 48.0f, 32 * 27 / 48.0f}, static_cast<float>(grid.nearMm + depth));
            for (int c = 0; c < 3; ++c) // an even medium is the same mirrored
                EXPECT_NEAR(light[c], same[c], 0.01f) << depth;
            EXPECT_GE(light.r, 1.2f * light.g);
            EXPECT_GE(light.g, 1.2f * light.b);
        }
        EXPECT_GT(box.at({24, 24, 44}).g, 0.1f);
        EXPECT_EQ(box.at({24, -5, 30}), box.at({24, 0, 30})) << "beside the map";
    }
    const EvenBox black(above, glm::vec3(0));
    EXPECT_EQ(black.at({24, 24, 30}), glm::vec3(0));
}

/// Lights of other kinds are about as bright in an even medium; a light inside is alike to all sides.
TEST(LightMapPicture, HasMapsOfEveryKindOfLight) {
    const glm::dvec3 middle(24, 24, 24);
    const float hard = EvenBox({false, {0, 0, 1}, {}, 0, true}).at(middle).g;
    const EvenBox soft({false, {0, 0, 1}, {}, 8, true}), far({true, {}, {24, 24, 800}, 0, true});
    EXPECT_EQ(soft.made->maps.lightMaps().size(), 4u);
    EXPECT_EQ(soft.made->maps.lightMaps().front()->grid().size, 16);
    EXPECT_NEAR(soft.at(middle).g, hard, 0.05f * hard);
    EXPECT_TRUE(far.made->maps.lightMaps().front()->grid().perspective);
    EXPECT_NEAR(far.at(middle).g, hard, 0.05f * hard);
    const EvenBox inside({true, {}, middle, 0, true});
    ASSERT_EQ(inside.made->maps.lightMaps().size(), 6u);
    const float above = inside.at(middle + glm::dvec3(0, 0, 9)).g;
    EXPECT_GT(above, 0.1f);
    for (const glm::dvec3& side : {glm::dvec3(9, 0, 0), {-9, 0, 0}, {0, 9, 0}, {0, -9, 0}, {0, 0, -9}})
        EXPECT_NEAR(inside.at(middle + side).g, above, 0.03f * above);
    EXPECT_NEAR(inside.at(middle + 9.0 * glm::normalize(glm::dvec3(1, 1, 1))).g, above, 0.2f * above);
    EXPECT_TRUE(ShadowMaps({false, {0, 0, 1}}, inside.made->path, {}).lightMaps().empty());
}

/// Meshes take light and send none on.
TEST(LightMapPicture, MeshesAreInItsWay) {
    const EvenBox box({false, {0, 0, 1}, {}, 0, true});
    MemoryBudget ram("RAM", "--ram", std::size_t{16} << 20);
    SceneMesh tube;
    tube.tube = Tube{{{-5, 24, 40}, {53, 24, 40}}, 6};
    tube.shape = std::make_shared<const TubeShape>(*tube.tube, ram);
    LightPath path = box.made->path;
    path.meshes = {&tube, 1};
    ShadowQuality quality;
    quality.mapSize = 16;
    quality.lightMap = LightMapping{32, 0.8};
    ShadowMaps maps({false, {0, 0, 1}, {}, 0, true}, path, quality);
    maps.build(path, 1);
    EXPECT_LT(maps.scattered({24, 24, 31}).g, 0.6f * box.at({24, 24, 31}).g);
    EXPECT_GT(maps.scattered({24, 24, 31}).g, 0) << "from beside it";
}

/// In rows, with deadlines that are over, it has the same bits; so do packets of an engine.
TEST(LightMapPicture, IsTheSameHoweverItIsBuilt) {
    Prepared prepared("torso", sceneOn(infoOf("torso"), "soft-tissue", 0, {16, 16}));
    const PlacedLight light{true, {}, {40, -60, 20}, 0, true};
    const MadeMaps one(prepared, light, LightMapping{20, 0.8}, 16, 1),
        three(prepared, light, LightMapping{20, 0.8}, 16, 3);
    ShadowQuality quality;
    quality.mapSize = 16;
    quality.lightMap = LightMapping{20, 0.8};
    ShadowMaps turns(light, one.path, quality);
    int calls = 1;
    while (!turns.buildUntil(one.path, 2, std::chrono::steady_clock::now()))
        ++calls;
    EXPECT_GT(calls, 4);
    ASSERT_EQ(one.maps.lightMaps().size(), turns.lightMaps().size());
    std::size_t bright = 0;
    for (std::size_t map = 0; map < turns.lightMaps().size(); ++map) {
        const LightMap& a = *one.maps.lightMaps()[map];
        for (std::size_t n = 0; n < a.grid().nodes(); ++n)
            for (int c = 0; c < 3; ++c) {
                ASSERT_EQ(a.node(n)[c], turns.lightMaps()[map]->node(n)[c]);
                ASSERT_EQ(a.node(n)[c], three.maps.lightMaps()[map]->node(n)[c]);
                bright += a.node(n)[c] > 200 ? 1 : 0;
            }
    }
    EXPECT_GT(bright, 1000u);
}

/// Of lights of every kind, beside occlusion, one level and mixed, with surfaces.
TEST(LightMapPicture, NativeIsTheMirror) {
    const VolumeInfo info = infoOf("torso");
    for (const int kind : {0, 1, 2, 3}) {
        Scene scene = sceneOn(info, "soft-tissue", kind % 3, {24, 24});
        Light light = backLight();
        light.scatter = 3;
        light.softness = kind == 1 ? 6 : 0;
        if (kind == 2) { // inside
            light.kind = LightKind::point;
            light.frame = LightFrame::patient;
            light.direction = {0, 0, 1};
            light.position =
                glm::dvec3(info.patientFromVoxel * glm::dvec4(glm::dvec3(info.extentVoxels) * 0.45, 1));
            light.attenuation = {1, 0.01, 0};
        }
        scene.lighting.lights = {light};
        scene.lighting.scatterBy = ScatterSource::map;
        scene.lighting.lightMap = {24, 0.8};
        scene.quality.integrator = Integrator::midpoint;
        if (kind == 0)
            scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
        if (kind == 3)
            scene.surfaces = {{300, {1, 0.9, 0.8}, 0.7}};
        Scene without = scene;
        without.lighting.lights[0].scatter = 0;
        Prepared prepared("torso", scene), dark("torso", without);
        for (Prepared* p : {&prepared, &dark})
            p->p.view.shadowQuality.mapSize = 64;
        if (kind == 1)
            prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 3));
        const Image mirror = mirrorLit(prepared);
        for (const native::PacketTarget* target : nativeTargets()) {
            NativeChoices choices;
            choices.target = target;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u) << kind << target->name;
        }
        EXPECT_GT(differing(nativePicture(dark).image, mirror), 100u) << kind;
    }
}

/// All that it takes is told before, and no more is taken; rays take other memory.
TEST(LightMapPicture, BytesAreTold) {
    Scene scene = sceneOn(infoOf("torso"), "soft-tissue", 0, {24, 24});
    Light light = backLight();
    light.scatter = 1;
    scene.lighting.lights = {light};
    const auto bytes = [&](const std::function<void(Lighting&)>& change) {
        Scene changed = scene;
        change(changed.lighting);
        const Prepared p("torso", changed);
        return lightRamBytes(p.p.view.lighting, p.p.info(), p.p.view.shadowQuality, 2, false, false);
    };
    const auto map = [](int size) {
        return [size](Lighting& l) { l.scatterBy = ScatterSource::map, l.lightMap.size = size; };
    };
    const std::size_t small = bytes(map(32)), large = bytes(map(96));
    EXPECT_EQ(large - small,
              LightMap::bytes(96) + MapSweep::bytes(96) - LightMap::bytes(32) - MapSweep::bytes(32));
    // Four maps of half the side; one is made at a time.
    EXPECT_EQ(bytes([&](Lighting& l) { map(96)(l), l.lights[0].softness = 4; }),
              bytes([&](Lighting& l) { l.lights[0].softness = 4, l.lights[0].scatter = 1, map(16)(l); }) +
                  4 * (LightMap::bytes(48) - LightMap::bytes(8)) + MapSweep::bytes(48) - MapSweep::bytes(8));
    Prepared prepared("torso", [&] {
        Scene changed = scene;
        map(64)(changed.lighting);
        return changed;
    }());
    SceneLight lit(prepared.p, 0);
    lit.ready();
    const LightReport report = lit.report(0);
    EXPECT_EQ(report.lightMaps, 1u);
    EXPECT_EQ(report.lightMapSize, 64);
    EXPECT_LE(report.lightMapBytes, LightMap::bytes(64));
    EXPECT_GT(report.lightMapBytes, LightMap::bytes(64) / 4);
    // With little memory maps are coarser, not left out.
    const ShadowQuality poor = shadowQualityFor(prepared.p.view.lighting, std::size_t{8} << 20);
    EXPECT_GT(poor.lightMapPart, 1);
    EXPECT_LT(poor.mapSize, 512);
}

} // namespace
} // namespace tessera::test
