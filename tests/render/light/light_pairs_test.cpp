// tests/render/light/light_pairs_test.cpp: every pair of the keys that change how light is found, and of
// those beside them: a pair is drawn, by native and mirror alike, or is refused by the sentence of the table.
#include "core/base/error.h"
#include "core/scene/preset.h"
#include "render/geometry/tube_shape.h"
#include "render/picture/render_scene.h"
#include "tests/support/reference_light.h"
#include "tests/support/scene_fixture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

using testing::HasSubstr;

Occlusion& occlusionOf(Scene& scene) {
    if (!scene.lighting.occlusion)
        scene.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
    return *scene.lighting.occlusion;
}
Light& casterOf(Scene& scene) {
    if (scene.lighting.lights.empty())
        scene.lighting.lights = {keyLight(), Light{}};
    return scene.lighting.lights.front();
}
Transport& transportOf(Scene& scene) {
    if (!scene.lighting.transport)
        scene.lighting.transport = Transport{.bounces = 2};
    scene.quality.pixels.samples = 2;
    return *scene.lighting.transport;
}
TransferFunction& functionOf(Scene& scene) {
    SceneVolume& volume = scene.volumes.front();
    if (!std::holds_alternative<TransferFunction>(volume.transferFunction))
        volume.transferFunction = presetFunction("soft-tissue", {-1000, 2000, true, 1, {}});
    return std::get<TransferFunction>(volume.transferFunction);
}

MemoryBudget& ramOfShapes() {
    static MemoryBudget ram("RAM", "--ram", std::size_t{1} << 20);
    return ram;
}
void addTube(Scene& scene) {
    SceneMesh tube;
    tube.tube = Tube{{{-10, 0, -10}, {10, 5, 10}}, 3};
    tube.shape = std::make_shared<const TubeShape>(*tube.tube, ramOfShapes());
    scene.meshes = {tube};
}

/// What a scene may have. Of one slot there is one: such pairs are none.
struct Feature {
    const char* name;
    const char* slot;
    std::function<void(Scene&)> add;
};

const std::vector<Feature>& features() {
    const auto method = [](OcclusionMethod kind) {
        return [kind](Scene& s) { occlusionOf(s).method = kind; };
    };
    static const std::vector<Feature> all = {
        {"local", "method", method(OcclusionMethod::local)},
        {"positional", "method", method(OcclusionMethod::positional)},
        {"rejecting", "method", method(OcclusionMethod::rejecting)},
        {"histogram", "method", method(OcclusionMethod::histogram)},
        {"bleeding", "bleeding",
         [](Scene& s) {
             occlusionOf(s).method = OcclusionMethod::histogram;
             occlusionOf(s).bleeding = 0.5;
         }},
        {"hemisphere", "directions",
         [](Scene& s) { occlusionOf(s).directions = OcclusionDirections::hemisphere; }},
        {"weights", "weights",
         [](Scene& s) {
             occlusionOf(s).weights = DirectionWeights{{0, -1, 1}, 3};
         }},
        {"emission", "emission",
         [](Scene& s) {
             occlusionOf(s).emission = 2;
             functionOf(s).setMaterials({{-2000, 4000, 0.2, 0.8, 0, 1, {1, 0.5, 0.2}}});
         }},
        {"shadow", "kind", [](Scene& s) { casterOf(s); }},
        {"first hits", "kind",
         [](Scene& s) {
             casterOf(s);
             s.lighting.shadowMap.kind = ShadowMapKind::first;
         }},
        {"variance", "kind",
         [](Scene& s) {
             casterOf(s);
             s.lighting.shadowMap.kind = ShadowMapKind::variance;
         }},
        {"soft light", "softness", [](Scene& s) { casterOf(s).softness = 8; }},
        {"scatter", "scatter", [](Scene& s) { casterOf(s).scatter = 2; }},
        {"light map", "scatter",
         [](Scene& s) {
             casterOf(s).scatter = 2;
             s.lighting.scatterBy = ScatterSource::map;
             s.lighting.lightMap = {24, 0.7};
         }},
        {"coarse light", "level", [](Scene& s) { s.lighting.finestLevel = 1; }},
        {"isosurface", "surface",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 0.5}};
         }},
        {"occluded isosurface", "surface",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 0.5}};
             s.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 4, .radiusMm = 6};
         }},
        {"isosurface occluded at half", "surface",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 0.5}};
             s.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 4, .radiusMm = 6, .scale = 2};
         }},
        {"mirror", "surface",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 0.5}};
             s.surfaces[0].reflection = Reflection{.strength = 0.8};
         }},
        {"glass", "surface",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 0.2}};
             s.surfaces[0].reflection = Reflection{.kind = ReflectionKind::fresnel, .transmits = true};
         }},
        {"surfaces alone", "mode",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 1}};
             s.mode = Mode::isosurface;
         }},
        {"surface occlusion", "mode",
         [](Scene& s) {
             s.surfaces = {{300, {1, 1, 1}, 1}};
             s.mode = Mode::isosurface;
             s.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 4, .radiusMm = 6};
         }},
        {"paths", "transport", [](Scene& s) { transportOf(s); }},
        {"contract", "transport", [](Scene& s) { transportOf(s).response = TransportResponse::contract; }},
        {"sky", "sky",
         [](Scene& s) {
             transportOf(s);
             s.lighting.environment = Environment{};
         }},
        {"second volume", "volumes", [](Scene& s) { s.volumes.push_back(s.volumes[0]); }},
        {"cut", "cut",
         [](Scene& s) {
             s.cuts.planes = {{{0, 0, 0}, {1, 0.2, 0}, Keep::inside}};
         }},
        {"mesh", "mesh", addTube},
        {"occluded mesh", "mesh",
         [](Scene& s) {
             addTube(s);
             if (!s.lighting.surfaceOcclusion)
                 s.lighting.surfaceOcclusion = SurfaceOcclusion{.rays = 4, .radiusMm = 6};
         }},
        {"gradient opacity", "gradient",
         [](Scene& s) {
             functionOf(s).setGradientOpacity(GradientOpacity::fromPoints({{0, 0}, {20, 1}}));
         }},
        {"maximum", "mode", [](Scene& s) { s.mode = Mode::maximum; }},
        {"radiograph", "mode", [](Scene& s) { s.mode = Mode::radiograph; }},
        {"error bound", "bound", [](Scene& s) { s.quality.maxError = 20; }},
        {"automatic samples", "samples",
         [](Scene& s) { s.quality.pixels.samples = PixelSampling::kAutomatic; }},
    };
    return all;
}

/// What is refused: any of the first with any of the others, by a part of the sentence. Each other pair is
/// drawn.
struct Refusal {
    std::vector<std::string> any, with;
    const char* sentence;
    bool is(const std::string& a, const std::string& b) const {
        const auto has = [](const std::vector<std::string>& names, const std::string& name) {
            return std::find(names.begin(), names.end(), name) != names.end();
        };
        return (has(any, a) && has(with, b)) || (has(any, b) && has(with, a));
    }
};

const Refusal kRefusals[] = {
    {{"histogram", "bleeding"}, {"hemisphere"}, "expected a method of rays with directions"},
    {{"histogram", "bleeding"}, {"weights"}, "expected a method of rays with weights"},
    {{"positional", "rejecting", "histogram", "bleeding"}, {"emission"}, "emission needs method \"local\""},
    {{"hemisphere"}, {"emission"}, "expected sphere with emission"},
    {{"histogram", "bleeding"}, {"second volume"}, "expected one volume with method \"histogram\""},
    {{"mirror", "glass"}, {"paths", "contract", "sky"}, "expected no paths of light (lighting.transport)"},
    {{"mirror", "glass"},
     {"mesh", "occluded mesh"},
     "expected no meshes, which it would lack, beside \"reflection\""},
    {{"isosurface", "occluded isosurface", "isosurface occluded at half", "mirror", "glass", "surfaces alone",
      "surface occlusion"},
     {"second volume"},
     "isosurfaces: expected none in a scene of several volumes"},
    {{"occluded mesh"},
     {"second volume"},
     "lighting.surfaceOcclusion: expected none in a scene of several volumes"},
    {{"scatter", "light map"},
     {"surface occlusion", "occluded isosurface", "isosurface occluded at half"},
     "expected no surfaceOcclusion"},
    {{"scatter", "light map"},
     {"second volume"},
     "expected none with \"scatter\" in a scene of several volumes"},
    {{"scatter", "light map"},
     {"contract"},
     "expected no light with \"scatter\" beside response \"contract\""},
    {{"paths", "contract", "sky"},
     {"second volume"},
     "lighting.transport: expected none in a scene of several"},
    {{"paths", "contract", "sky"}, {"mesh", "occluded mesh"}, "expected no meshes"},
    {{"paths", "contract", "sky"}, {"error bound"}, "expected no error bound"},
    {{"paths", "contract", "sky"}, {"automatic samples"}, "expected a number of samples"},
    {{"contract"},
     {"isosurface", "occluded isosurface", "isosurface occluded at half", "surfaces alone",
      "surface occlusion"},
     "expected no isosurfaces beside response"},
    {{"contract"},
     {"positional", "rejecting", "histogram", "bleeding", "hemisphere", "emission"},
     "expected occlusion of method local, directions sphere and emission 0"},
};

class LightPairs : public testing::TestWithParam<std::size_t> {};

TEST_P(LightPairs, AreDrawnOrRefused) {
    Budgets setup;
    const StoreReader store(storePath("torso"), setup.ram);
    const Feature& first = features()[GetParam()];
    for (std::size_t n = GetParam() + 1; n < features().size(); ++n) {
        const Feature& second = features()[n];
        if (std::string(first.slot) == second.slot)
            continue;
        Scene scene = sceneOn(store.info(), "soft-tissue", 1, {8, 8});
        scene.quality.terminationTransmittance = 1.0 / 255;
        first.add(scene);
        second.add(scene);
        const std::string what = std::string(first.name) + " + " + second.name;
        Image pictures[2];
        std::string refused[2];
        for (const EngineKind kind : {EngineKind::native, EngineKind::mirror}) {
            MemoryBudget ram("RAM", "--ram", std::size_t{scene.volumes.size() > 1 ? 256u : 120u} << 20),
                gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
            const StoreReader mine(storePath("torso"), ram);
            std::vector<const StoreReader*> stores(scene.volumes.size(), &mine);
            RenderOptions options;
            options.engine = kind;
            options.checking = options.searching = false;
            options.threads = 2;
            try {
                pictures[kind == EngineKind::mirror] = renderScene(scene, stores, ram, gpu, options).image;
            } catch (const InputError& error) {
                refused[kind == EngineKind::mirror] = error.what();
            }
        }
        const auto* const found =
            std::find_if(std::begin(kRefusals), std::end(kRefusals),
                         [&](const Refusal& refusal) { return refusal.is(first.name, second.name); });
        if (found != std::end(kRefusals)) {
            for (const std::string& sentence : refused)
                EXPECT_THAT(sentence, HasSubstr(found->sentence)) << what;
            continue;
        }
        EXPECT_EQ(refused[0] + refused[1], "") << what;
        std::size_t shown = 0;
        for (const glm::vec4& p : pictures[0].pixels) {
            ASSERT_TRUE(std::isfinite(p.r + p.g + p.b + p.a)) << what;
            shown += p.a > 0 ? 1 : 0;
        }
        EXPECT_GT(shown, 4u) << what;
        EXPECT_EQ(pictures[0].pixels, pictures[1].pixels) << what;
    }
}

/// None is left out in silence: each changes the picture of a scene with occlusion, a shadow and a mesh.
/// Method local is that scene's; samples and bounds are no light.
TEST(LightFeatures, EachChangesThePicture) {
    Budgets setup;
    const StoreReader store(storePath("torso"), setup.ram);
    const auto drawn = [&](const std::function<void(Scene&)>& add) {
        Scene scene = sceneOn(store.info(), "soft-tissue", 1, {16, 16});
        occlusionOf(scene);
        casterOf(scene);
        add(scene);
        MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
            gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
        const StoreReader mine(storePath("torso"), ram);
        const std::vector<const StoreReader*> stores(scene.volumes.size(), &mine);
        RenderOptions options;
        options.engine = EngineKind::native;
        options.checking = options.searching = false;
        return renderScene(scene, stores, ram, gpu, options).image.pixels;
    };
    const auto plain = drawn([](Scene&) {});
    for (const Feature& feature : features()) {
        const std::string name = feature.name;
        if (name == "local" || name == "shadow" || name == "error bound")
            continue;
        EXPECT_NE(drawn(feature.add), plain) << name;
    }
    // The kinds of maps reach meshes: thin tissue before one casts all of a shadow or none.
    const auto addMesh = [](Scene& s) {
        std::find_if(features().begin(), features().end(), [](const Feature& f) {
            return f.name == std::string("mesh");
        })->add(s);
    };
    const auto meshDeep = drawn(addMesh);
    EXPECT_NE(drawn([&](Scene& s) {
                  addMesh(s);
                  s.lighting.shadowMap = {ShadowMapKind::first, 0.05, 0};
              }),
              meshDeep);
}

INSTANTIATE_TEST_SUITE_P(Each, LightPairs, testing::Range(std::size_t{0}, features().size() - 1),
                         [](const auto& info) {
                             std::string name = features()[info.param].name;
                             std::erase(name, ' ');
                             return name;
                         });

} // namespace
} // namespace tessera::test
