// tests/render/light/light_map_picture_test.cpp: pictures with light maps.
#include "core/base/progress.h" // secondsSince
#include "render/contract/lattice.h"
#include "render/geometry/tube_shape.h"
#include "render/light/light_memory.h"
#include "render/light/light_sweep.h"
#include "render/light/scene_light.h"
#include "tests/support/lit_picture.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/paths_and_kept.h"
#include "tests/support/reference_light.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

Light backLight() { // 150 degrees from the viewer
    Light light;
    light.kind = LightKind::directional;
    light.direction = {-0.354, 0.354, -0.866};
    light.shadow = true;
    return light;
}

/// Lit from behind: what light maps add is nearer to what paths of up to 64 scatterings add to those of one.
/// Kept light answers to all sides alike: f is what the phase function makes of the angle from light to
/// viewer. TESSERA_TELL=1 tells of sizes and of g; TESSERA_SCATTER_STORE=a.zarr of another store.
TEST(LightMapPicture, IsNearerToPaths) {
    const char* const other = std::getenv("TESSERA_SCATTER_STORE");
    const bool tells = std::getenv("TESSERA_TELL") != nullptr;
    for (const std::string preset : {"soft-tissue", "bone-1"})
        for (const double g : {0.8, 0.95}) {
            if (!tells && (preset != "soft-tissue" || g > 0.9))
                continue;
            PathsAndKept pictures(other ? other : storePath("torso").string(), preset, backLight(),
                                  tells ? 128 : 96, 8, g);
            const double cosine = std::cos(glm::radians(30.0)),
                         f = (1 - g * g) / std::pow(1 + g * g - 2 * g * cosine, 1.5);
            const double without = pictures.rms(0, false, f), all = pictures.rms(0, true, f);
            tell("%s, g %g: f %.3f (fitted %.3f), rms of further scatterings %.4f, of all light %.4f\n",
                 preset.c_str(), g, f, pictures.ofPhase(), without, all);
            const auto measure = [&](const std::string& what, const std::function<void(Lighting&)>& change) {
                pictures.scatter(change);
                const double best = pictures.bestFactor(false, f), ofBest = pictures.rms(best, false, f);
                const double with = pictures.rms(1, false, f), allWith = pictures.rms(1, true, f);
                tell("    %s: %.4f, %.2f (%.2f: %.2f); of all light %.4f, %.2f\n", what.c_str(), with,
                     with / without, best, ofBest / without, allWith, allWith / all);
                std::fflush(stdout);
                return std::pair(with / without, ofBest / without);
            };
            const auto ofMap = [&](int size, double mapG) {
                return measure("map of " + std::to_string(size) + ", g " + std::to_string(mapG).substr(0, 4),
                               [=](Lighting& lighting) {
                                   lighting.scatterBy = ScatterSource::map;
                                   lighting.lightMap = {size, mapG};
                               });
            };
            if (!tells) {
                const auto [with, best] = ofMap(96, g);
                EXPECT_LT(with, 0.56) << "of the rms without";
                EXPECT_LT(best, 0.5) << "with the best factor";
                continue;
            }
            measure("rays of 2 mm", [](Lighting&) {});
            for (const int size : {48, 96, 128, 192})
                ofMap(size, g);
            for (const double mapG : {0.5, 0.8, 0.9})
                ofMap(96, mapG);
        }
}

/// The share of light that gets to a place, from the nodes of a light map's grid (figure 10.2: no deep map
/// beside it): kept as exactly as numbers allow.
class DirectGrid {
  public:
    DirectGrid(const LightPath& path, const ShadowMaps& maps) : grid_(maps.lightMaps().front()->grid()) {
        const RayFrame<float> frame =
            cast<float>(rayFrame(maps.camera(0), *path.info, glm::ivec2(grid_.size), 1));
        plane_ = rayPlane(maps.camera(0), *path.info, glm::ivec2(grid_.size));
        light_.assign(grid_.nodes(), 1);
        withCacheField<float>(
            *path.cache, *path.info, *path.selection, nullptr, Gradient::central, [&](auto& values) {
                std::vector<LightLeft> samples;
                std::vector<LightSlice> slices(static_cast<std::size_t>(grid_.slices));
                struct Unlabelled {
                    std::decay_t<decltype(values)>& field;
                    float value(const glm::vec3& p) { return field.value(p); }
                    glm::vec3 gradient(const glm::vec3& p) { return field.gradient(p); }
                    leaf::LabelShares<float> labels(const glm::vec3&) { return {}; }
                } field{values};
                Strides strides;
                strides.uniformSegments = 1;
                strides.segmentVoxels = 1;
                for (int y = 0; y < grid_.size; ++y)
                    for (int x = 0; x < grid_.size; ++x) {
                        const auto ray = segmentedRay(frame, glm::vec2(x, y) + 0.5f);
                        const glm::dvec3 entry(path.info->patientFromVoxel *
                                               glm::dvec4(glm::dvec3(ray.entry), 1));
                        const auto mm = static_cast<float>(glm::dot(entry - plane_.centre, plane_.forward));
                        lightAlong(ray, field, path, strides, mm, samples, 1e-30f);
                        std::fill(slices.begin(), slices.end(), LightSlice{});
                        for (std::size_t n = 1; n < samples.size(); ++n)
                            if (samples[n].light > 0 && samples[n].light < samples[n - 1].light)
                                addToSlices(grid_, samples[n - 1].mm, samples[n].mm,
                                            std::log(samples[n - 1].light / samples[n].light), {}, slices);
                        double depth = 0;
                        for (int k = 0; k < grid_.slices; ++k) {
                            depth += static_cast<double>(slices[static_cast<std::size_t>(k)].depth);
                            light_[nodeAt({x, y, k + 1})] = static_cast<float>(std::exp(-depth));
                        }
                    }
            });
    }
    double at(const glm::dvec3& place) const {
        const glm::dvec3 d = place - plane_.centre;
        const auto along = [&](const glm::dvec3& side) { return glm::dot(d, side) / glm::dot(side, side); };
        const glm::dvec3 node(0.5 * (1 + along(plane_.right)) * grid_.size - 0.5,
                              0.5 * (1 - along(plane_.up)) * grid_.size - 0.5,
                              (glm::dot(d, plane_.forward) - grid_.nearMm) / grid_.sliceMm);
        const glm::ivec3 low(glm::floor(node)), most(grid_.size - 1, grid_.size - 1, grid_.slices);
        double sum = 0;
        for (int n = 0; n < 8; ++n) {
            const glm::ivec3 corner = low + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2);
            const glm::dvec3 weights = 1.0 - glm::abs(node - glm::dvec3(corner));
            sum += weights.x * weights.y * weights.z *
                   double{light_[nodeAt(glm::clamp(corner, glm::ivec3(0), most))]};
        }
        return sum;
    }

  private:
    std::size_t nodeAt(const glm::ivec3& at) const {
        return static_cast<std::size_t>(at.z) * grid_.nodesOfPlane() +
               static_cast<std::size_t>(at.y * grid_.size + at.x);
    }
    LightGrid grid_;
    RayPlane plane_;
    std::vector<float> light_;
};

/// Light left at a place, by the midpoint rule in double with short segments.
double lightByRay(const LightPath& path, const glm::dvec3& place, const glm::dvec3& towards) {
    const glm::dmat4 voxels = glm::inverse(path.info->patientFromVoxel);
    constexpr double kStep = 0.1;
    double depth = 0;
    withCacheField<double>(*path.cache, *path.info, *path.selection, path.levels, Gradient::central,
                           [&](auto& field) {
                               for (double t = kStep / 2;; t += kStep) {
                                   const glm::dvec3 p(voxels * glm::dvec4(place + t * towards, 1));
                                   if (glm::any(glm::lessThan(p, glm::dvec3(0))) ||
                                       glm::any(glm::greaterThan(p, glm::dvec3(path.info->extentVoxels))))
                                       break;
                                   depth += kStep * lookUp(*path.optics, field.value(p)).a;
                               }
                           });
    return std::exp(-depth);
}

/// A prepared picture's maps of one light of the scene, and its path.
struct MadeMaps {
    MadeMaps(Prepared& prepared, const PlacedLight& light, std::optional<LightMapping> mapping,
             int mapSize = 512, int threads = 0)
        : path(lightPathOf(prepared.p, nullptr)), maps(light, path, [&] {
              ShadowQuality quality;
              quality.mapSize = mapSize;
              quality.lightMap = mapping;
              return quality;
          }()) {
        const auto start = std::chrono::steady_clock::now();
        maps.build(path, threads);
        seconds = secondsSince(start);
    }
    LightPath path;
    ShadowMaps maps;
    double seconds = 0;
};

/// An even medium in a box of 48 mm, seen from a light.
struct EvenBox {
    explicit EvenBox(const PlacedLight& light, const glm::vec3& colour = {0.8f, 0.6f, 0.4f}, int size = 32)
        : stored([](const glm::dvec3&) { return 1.0; }, glm::ivec3(48), true) {
        Scene scene = stored.scene({});
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction(
            {{0, kExtinction}, {2, kExtinction}}, {{0, colour}, {2, colour}});
        prepared = stored.prepare(scene);
        made.emplace(*prepared, light, LightMapping{size, 0.8}, 16, 1);
    }
    glm::vec3 at(const glm::dvec3& place) const { return made->maps.scattered(place); }
    static constexpr double kExtinction = 0.08;
    Stored stored;
    std::unique_ptr<Prepared> prepared;
    std::optional<MadeMaps> made;
};

/// The numbers of a map are those of slices that are known beforehand, and its nodes are where it says.
TEST(LightMapPicture, SeesTheTissueThatShadowsSee) {
    const PlacedLight above{false, {0, 0, 1}, {}, 0, true};
    const EvenBox box(above);
    ASSERT_EQ(box.made->maps.lightMaps().size(), 1u);
    const LightMap& map = *box.made->maps.lightMaps().front();
    const LightGrid& grid = map.grid();
    EXPECT_EQ(grid.size, 32);
    EXPECT_EQ(grid.slices, 32);
    EXPECT_NEAR(grid.sliceMm, 1.5, 1e-9);
    LightSweep sweep(grid, 0.8);
    LightMap expected(grid);
    const std::vector<LightSlice> slices(
        32, {static_cast<float>(EvenBox::kExtinction * 1.5), {0.8f, 0.6f, 0.4f}});
    for (int n = 0; n < 32 * 32; ++n)
        sweep.setRay({n % 32, n / 32}, slices);
    sweep.run(1, expected);
    float most = 0;
    for (std::size_t n = 0; n < grid.nodes(); ++n)
        for (int c = 0; c < 3; ++c)
            most = std::max(most, std::abs(static_cast<float>(map.node(n)[c] - expected.node(n)[c])));
    EXPECT_LT(most, 0.003f * 16384);
    for (const double depth : {3.0, 20.0, 40.0}) {
        const glm::vec3 light = box.at({20, 27, 48 - depth});
        const glm::vec3 same =
            expected.at({32 * 20 / 48.0f, 32 * 27 / 48.0f}, static_cast<float>(grid.nearMm + depth));
        for (int c = 0; c < 3; ++c) // an even medium is the same mirrored
            EXPECT_NEAR(light[c], same[c], 0.01f) << depth;
        EXPECT_GT(light.r, 1.2f * light.g);
        EXPECT_GT(light.g, 1.2f * light.b);
    }
    EXPECT_GT(box.at({24, 24, 30}).g, 0.05f);
    EXPECT_EQ(box.at({24, -5, 30}), glm::vec3(0)) << "beside the map";
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
              LightMap::bytes(96) + LightSweep::bytes(96) - LightMap::bytes(32) - LightSweep::bytes(32));
    // Four maps of half the side; one is made at a time.
    EXPECT_EQ(bytes([&](Lighting& l) { map(96)(l), l.lights[0].softness = 4; }),
              bytes([&](Lighting& l) { l.lights[0].softness = 4, l.lights[0].scatter = 1, map(16)(l); }) +
                  4 * (LightMap::bytes(48) - LightMap::bytes(8)) + LightSweep::bytes(96) -
                  LightSweep::bytes(16));
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

/// TESSERA_TELL=1: what light maps cost, and what their grid would err by as a shadow's.
TEST(LightMapPicture, TellsWhatTheyTakeAndErrBy) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL is not set";
    for (const auto& [store, preset] : {std::pair{"torso", "soft-tissue"},
                                        {"abdomen", "soft-tissue"},
                                        {"abdomen", "bone-1"},
                                        {"head", "skin-1"}}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        Prepared prepared(store, sceneOn(infoOf(store), preset, 0, {16, 16}));
        PlacedLight light;
        light.towards = glm::normalize(glm::dvec3(0.4, -0.7, 0.5));
        light.scatters = true;
        const double deepAlone = MadeMaps(prepared, light, std::nullopt).seconds;
        const VolumeInfo& info = prepared.p.info();
        std::vector<glm::dvec3> places;
        std::vector<double> truth;
        std::mt19937 random(7);
        std::uniform_real_distribution<double> anywhere(0.02, 0.98);
        for (const int size : {64, 96, 128, 192}) {
            const MadeMaps made(prepared, light, LightMapping{size, 0.8});
            for (int n = 0; places.size() < 300 && n < 400000; ++n) {
                const glm::dvec3 voxel = glm::dvec3(info.extentVoxels) *
                                         glm::dvec3(anywhere(random), anywhere(random), anywhere(random));
                const glm::dvec3 place(info.patientFromVoxel * glm::dvec4(voxel, 1));
                bool shows = false;
                withCacheField<double>(
                    *made.path.cache, info, *made.path.selection, nullptr, Gradient::central,
                    [&](auto& field) { shows = lookUp(*made.path.optics, field.value(voxel)).a > 0.01; });
                const double left = shows ? lightByRay(made.path, place, light.towards) : 0;
                if (left >= 0.02) {
                    places.push_back(place);
                    truth.push_back(left);
                }
            }
            const DirectGrid direct(made.path, made.maps);
            ShadowQuality exact;
            exact.offset = 0;
            ShadowMaps deep(light, made.path, exact);
            deep.build(made.path, 0);
            double ofGrid = 0, ofMap = 0;
            for (std::size_t n = 0; n < places.size(); ++n) {
                ofGrid += std::pow(direct.at(places[n]) - truth[n], 2);
                ofMap += std::pow(double{deep.light(places[n])} - truth[n], 2);
            }
            const auto count = static_cast<double>(places.size());
            tell("%s, %s, %d rays, %d slices: %.2f s beside %.2f s of a deep map, %.1f MiB kept, %.1f MiB of "
                 "room; rms of direct light by its grid %.4f, by the deep map %.4f (%zu places)\n",
                 store, preset, size, made.maps.lightMaps().front()->grid().slices, made.seconds - deepAlone,
                 deepAlone, static_cast<double>(made.maps.lightMaps().front()->bytes()) / 1048576,
                 static_cast<double>(LightSweep::bytes(size)) / 1048576, std::sqrt(ofGrid / count),
                 std::sqrt(ofMap / count), places.size());
            std::fflush(stdout);
        }
    }
}

} // namespace
} // namespace tessera::test
