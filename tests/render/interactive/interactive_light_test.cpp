// tests/render/interactive/interactive_light_test.cpp: light of voxels in successive pictures. It is coarse
// at first and reported as such. In the end it is bit for bit that of a renderer that waited for all of it,
// whatever was set before. An edit recomputes only what depends on it.
#include "core/image/image_metrics.h"
#include "core/scene/preset.h"
#include "tests/support/interactive_fixture.h"
#include "tests/support/native_fixture.h"

#include <functional>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;
using std::chrono::milliseconds;
using Clock = InteractiveRenderer::Clock;

constexpr glm::ivec2 kLitSize(40, 36);
constexpr std::size_t kAmpleForLight = std::size_t{1} << 30;

Light keyLight(LightFrame frame, double softness) {
    Light light;
    light.kind = LightKind::directional;
    light.frame = frame;
    light.direction = {-1, 1, 1};
    light.shadow = true;
    light.softness = softness;
    return light;
}

Scene litScene() {
    Scene scene = interactiveScene("soft-tissue", 0, kLitSize);
    scene.lighting.lights = {keyLight(LightFrame::camera, 4), Light{}};
    scene.lighting.occlusion = Occlusion{.rays = 16, .radiusMm = 12};
    return scene;
}

TransferFunction presetOf(const std::string& name) {
    ValueSummary values;
    values.isHu = true;
    return presetFunction(name, values);
}

/// The pictures drawn until nothing more came.
struct Pictures {
    std::vector<Image> all;
    std::vector<bool> coarse;
    const Image& last() const { return all.back(); }
};
Pictures picturesUntilAtRest(Session& session, milliseconds each = milliseconds(20)) {
    Pictures pictures;
    for (int n = 0; n < 5000; ++n) {
        const auto progress = session.renderer.advance(Clock::now() + each);
        if (progress.newPicture) {
            pictures.all.push_back(session.renderer.picture());
            pictures.coarse.push_back(progress.lightIsCoarse);
        }
        if (progress.converged)
            return pictures;
    }
    ADD_FAILURE() << "no end";
    return pictures;
}

/// The pictures drawn in haste, in which light stays coarse, until no brick was to come and nothing new was
/// drawn.
Pictures hastyPictures(Session& session, double stepVoxels) {
    Pictures pictures;
    session.renderer.setHaste(InteractiveRenderer::Haste{kLitSize, stepVoxels});
    for (int n = 0, still = 0; n < 5000 && still < 50; ++n) {
        const auto progress = session.renderer.advance(Clock::now() + milliseconds(5));
        still = progress.newPicture || progress.movesLeft > 0 || progress.choosing ? 0 : still + 1;
        if (progress.newPicture) {
            pictures.all.push_back(session.renderer.picture());
            pictures.coarse.push_back(progress.lightIsCoarse);
        }
    }
    session.renderer.setHaste(std::nullopt);
    return pictures;
}

/// The final picture of a renderer that knows nothing else, and has all light before each picture.
Image alone(const Scene& scene, bool native) {
    InteractiveOptions options;
    options.coarseLightFirst = false;
    Session session(scene, kAmpleForLight, options, storePath("torso"), native);
    const Pictures pictures = picturesUntilAtRest(session);
    for (const bool coarse : pictures.coarse)
        EXPECT_FALSE(coarse);
    return pictures.last();
}

class InteractiveLight : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Engines, InteractiveLight, testing::Bool(),
                         [](const auto& info) { return info.param ? "native" : "gpu"; });

TEST_P(InteractiveLight, IsCoarseFirstAndWholeInTheEnd) {
    const Scene scene = litScene();
    Scene unlit = scene;
    unlit.lighting.occlusion.reset();
    unlit.lighting.lights[0].shadow = false;
    Pictures coarse, pictures;
    {
        Session session(scene, kAmpleForLight, {}, storePath("torso"), GetParam());
        coarse = hastyPictures(session, scene.quality.stepVoxels);
        pictures = picturesUntilAtRest(session, milliseconds(1));
        session.checkStep();
        EXPECT_FALSE(session.renderer.advance(Clock::now()).lightIsCoarse);
    }
    ASSERT_GE(coarse.all.size(), 1u);
    EXPECT_TRUE(coarse.coarse.front());
    EXPECT_TRUE(coarse.coarse.back());
    EXPECT_FALSE(pictures.coarse.back());
    const Image whole = alone(scene, GetParam());
    EXPECT_TRUE(bitEqual(pictures.last(), whole)) << compare(pictures.last(), whole).maxAbs;

    // A coarse picture whose bricks are at their levels is nearer than one without light. Not by much here: a
    // coarse sample is as wide as occlusion's radius.
    EXPECT_FALSE(bitEqual(coarse.last(), whole));
    const double without = compare(alone(unlit, GetParam()), whole).rms;
    EXPECT_LT(compare(coarse.last(), whole).rms, 0.8 * without);
}

struct LitChange {
    const char* name;
    std::function<void(InteractiveRenderer&, Scene&)> make;
};
std::vector<LitChange> litChanges() {
    const auto relight = [](const char* name, const std::function<void(Scene&)>& edit) {
        return LitChange{name, [edit](InteractiveRenderer& r, Scene& s) {
                             edit(s);
                             EXPECT_TRUE(r.setLight(s.lighting, s.shading));
                         }};
    };
    return {
        {"a function",
         [](InteractiveRenderer& r, Scene& s) {
             s.volumes[0].transferFunction = presetOf("bone-1");
             r.setFunction(presetOf("bone-1"));
         }},
        {"a camera that carries the light",
         [](InteractiveRenderer& r, Scene& s) {
             s.camera = cameraNumber(1, infoOf("torso"), kLitSize);
             r.setCamera(std::get<Camera>(s.camera));
         }},
        relight("how bright a light is", [](Scene& s) { s.lighting.lights[0].intensity = 0.5; }),
        relight("where a light is",
                [](Scene& s) {
                    s.lighting.lights[0].direction = {1, 0.5, 1};
                }),
        relight("how far occlusion looks", [](Scene& s) { s.lighting.occlusion->radiusMm = 6; }),
        relight("how fine light is", [](Scene& s) { s.lighting.finestLevel = 1; }),
        relight("what answers to light", [](Scene& s) { s.shading.ambient = 0.6, s.shading.specular = 0; }),
    };
}
/// Changes while those before are still worked on.
std::vector<LitChange> unfinishedChanges() {
    return {
        {"a function while light becomes finer",
         [](InteractiveRenderer& r, Scene& s) {
             s.lighting.lights[0].direction = {-1, 0.2, 1};
             r.setLight(s.lighting, s.shading);
             for (int n = 0; n < 12; ++n)
                 r.advance(Clock::now() + milliseconds(5));
             s.volumes[0].transferFunction = presetOf("soft-tissue");
             r.setFunction(presetOf("soft-tissue"));
         }},
        {"a camera in haste, and rest",
         [](InteractiveRenderer& r, Scene& s) {
             for (int n = 0; n < 3; ++n) {
                 s.camera = cameraNumber(n, infoOf("torso"), kLitSize);
                 r.setCamera(std::get<Camera>(s.camera));
                 r.setHaste(InteractiveRenderer::Haste{kLitSize / 2, 1});
                 for (int turn = 0; turn < 8; ++turn)
                     r.advance(Clock::now() + milliseconds(10));
             }
             r.setHaste(std::nullopt);
         }},
    };
}

/// A session makes changes one after another, and comes after each to what a renderer alone comes to.
void expectTheSameAfter(Scene scene, const std::vector<LitChange>& changes, bool native) {
    std::vector<Scene> scenes;
    std::vector<Image> pictures;
    {
        Session session(scene, kAmpleForLight, {}, storePath("torso"), native);
        picturesUntilAtRest(session);
        for (const LitChange& change : changes) {
            change.make(session.renderer, scene);
            const Pictures drawn = picturesUntilAtRest(session, milliseconds(3));
            ASSERT_FALSE(drawn.all.empty()) << change.name;
            pictures.push_back(drawn.last());
            scenes.push_back(scene);
        }
    }
    for (std::size_t n = 0; n < changes.size(); ++n) {
        SCOPED_TRACE(changes[n].name);
        const Image whole = alone(scenes[n], native);
        EXPECT_TRUE(bitEqual(pictures[n], whole)) << compare(pictures[n], whole).maxAbs;
        if (n > 0) {
            EXPECT_FALSE(bitEqual(pictures[n], pictures[n - 1]));
        }
    }
}

Scene quickScene() {
    Scene scene = litScene();
    scene.lighting.occlusion->rays = 8; // light is found whole for every change, twice
    return scene;
}
TEST_P(InteractiveLight, ComesToTheSameWhateverWasSetBefore) {
    expectTheSameAfter(quickScene(), litChanges(), GetParam());
}
TEST_P(InteractiveLight, ComesToTheSameWhateverWasLeftUndone) {
    expectTheSameAfter(quickScene(), unfinishedChanges(), GetParam());
}

// Scattered light follows from shadow maps, too.
TEST(InteractiveLight, ScatteredLightComesToTheSameWhateverWasSetBefore) {
    Scene scene = quickScene();
    scene.lighting.lights[0].scatter = 2;
    scene.lighting.scatterRadiusMm = 9;
    std::vector<LitChange> changes = litChanges();
    std::erase_if(changes, [](const LitChange& change) {
        const std::string name = change.name;
        return name == "how fine light is" || name == "how far occlusion looks";
    });
    const auto relight = [&](const char* name, const std::function<void(Lighting&)>& edit) {
        changes.push_back({name, [edit](InteractiveRenderer& r, Scene& s) {
                               edit(s.lighting);
                               EXPECT_TRUE(r.setLight(s.lighting, s.shading));
                           }});
    };
    relight("how much is scattered", [](Lighting& l) { l.lights[0].scatter = 0.5; });
    relight("how far", [](Lighting& l) { l.scatterRadiusMm = 5; });
    // Then light by coarse maps is as fine as any, and still not that by whole maps.
    relight("how fine", [](Lighting& l) { l.finestLevel = 3; });
    relight("where the light is", [](Lighting& l) { l.lights[0].direction = {1, 1, 0.3}; });
    expectTheSameAfter(scene, changes, true);
}

// So do light maps: after an edit of anything that they keep there is no light of the one before.
TEST(InteractiveLight, LightMapsComeToTheSameWhateverWasSetBefore) {
    Scene scene = quickScene();
    scene.lighting.lights[0].scatter = 2;
    scene.lighting.scatterBy = ScatterSource::map;
    scene.lighting.lightMap = {48, 0.8};
    std::vector<LitChange> changes = litChanges();
    std::erase_if(changes,
                  [](const LitChange& change) { return change.name == std::string("how fine light is"); });
    changes.push_back({"colours alone", [](InteractiveRenderer& r, Scene& s) {
                           const TransferFunction before = presetOf("bone-1");
                           std::vector<ColourPoint> colours = before.colourPoints();
                           for (ColourPoint& point : colours)
                               std::swap(point.colour.r, point.colour.b);
                           const TransferFunction other = TransferFunction::fromOpacity(
                               before.opacityPoints(), colours, before.referenceLengthMm());
                           s.volumes[0].transferFunction = other;
                           r.setFunction(other);
                       }});
    const auto relight = [&](const char* name, const std::function<void(Lighting&)>& edit) {
        changes.push_back({name, [edit](InteractiveRenderer& r, Scene& s) {
                               edit(s.lighting);
                               EXPECT_TRUE(r.setLight(s.lighting, s.shading));
                           }});
    };
    relight("how much is scattered", [](Lighting& l) { l.lights[0].scatter = 0.5; });
    relight("how far onwards", [](Lighting& l) { l.lightMap.g = 0.3; });
    relight("how fine maps are", [](Lighting& l) { l.lightMap.size = 24; });
    relight("how fine", [](Lighting& l) { l.finestLevel = 3; });
    relight("where the light is", [](Lighting& l) { l.lights[0].direction = {1, 1, 0.3}; });
    expectTheSameAfter(scene, changes, true);
    // Larger ones take more memory: another renderer.
    Session session(scene, kAmpleForLight, {}, storePath("torso"), true);
    scene.lighting.lightMap.size = 96;
    EXPECT_FALSE(session.renderer.setLight(scene.lighting, scene.shading));
}

// Bytes of light that are put beside the bricks tell what was computed. The GPU ray caster's texels hold all
// channels of a sample, which are put together.
TEST_P(InteractiveLight, AnEditOfLightsComputesWhatDependsOnIt) {
    Scene scene = litScene();
    scene.lighting.finestLevel = 3; // coarse light is all there is: one pass
    Session session(scene, kAmpleForLight, {}, storePath("torso"), GetParam());
    picturesUntilAtRest(session);
    const auto bytesOf = [&](const auto& edit) {
        const std::uint64_t before = session.renderer.work().bytesUploaded;
        edit();
        EXPECT_TRUE(session.renderer.setLight(scene.lighting, scene.shading));
        picturesUntilAtRest(session);
        return session.renderer.work().bytesUploaded - before;
    };
    EXPECT_EQ(bytesOf([&] { scene.lighting.lights[0].intensity = 0.2; }), 0u);
    EXPECT_EQ(bytesOf([&] { scene.shading.diffuse = 0.2; }), 0u);
    const std::uint64_t ambient = bytesOf([&] { scene.lighting.occlusion->gamma = 1; });
    EXPECT_GT(ambient, 0u);
    const std::uint64_t shadow = bytesOf([&] { scene.lighting.lights[0].direction = {1, 1, 1}; });
    EXPECT_EQ(shadow, 2 * ambient); // by coarse maps, and by whole ones
}

TEST_P(InteractiveLight, WhatTakesAnotherRendererIsRefused) {
    const Scene scene = litScene();
    Session session(scene, kAmpleForLight, {}, storePath("torso"), GetParam());
    const Image before = picturesUntilAtRest(session).last();
    Lighting more = scene.lighting, less = scene.lighting, wider = scene.lighting;
    more.lights.push_back(keyLight(LightFrame::patient, 0));
    less.occlusion.reset();
    wider.occlusion->radiusMm = 40;
    Shading unlit = scene.shading, sobel = scene.shading;
    unlit.on = false;
    sobel.gradient = Gradient::sobel;
    for (const Lighting& lighting : {more, less, wider})
        EXPECT_FALSE(session.renderer.setLight(lighting, scene.shading));
    for (const Shading& shading : {unlit, sobel})
        EXPECT_FALSE(session.renderer.setLight(scene.lighting, shading));
    session.renderer.setHaste(InteractiveRenderer::Haste{kLitSize, 1});
    session.renderer.setHaste(std::nullopt); // drawn again
    EXPECT_TRUE(bitEqual(picturesUntilAtRest(session).last(), before));
}

// Interactive pictures have the scene's lights without their paths, whatever renderer or edit brought them.
TEST(InteractiveLight, PathsAreLeftOut) {
    Scene plain = litScene(), paths = plain;
    paths.lighting.transport = Transport{};
    paths.lighting.environment = Environment{};
    Session without(plain, kAmpleForLight, {}, storePath("torso"), true);
    const Image expected = picturesUntilAtRest(without).last();
    const std::size_t gpu = without.gpu.usedBytes(), ram = without.ram.usedBytes();
    EXPECT_FALSE(isBlank(expected));
    EXPECT_TRUE(without.renderer.setLight(paths.lighting, paths.shading)) << "light planes made again";
    EXPECT_TRUE(bitEqual(picturesUntilAtRest(without).last(), expected));
    Session with(paths, kAmpleForLight, {}, storePath("torso"), true);
    EXPECT_TRUE(bitEqual(picturesUntilAtRest(with).last(), expected));
    EXPECT_EQ(with.gpu.usedBytes(), gpu) << "something was made for paths";
    EXPECT_EQ(with.ram.usedBytes(), ram);
}

} // namespace
} // namespace tessera
