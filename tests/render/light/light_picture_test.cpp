// tests/render/light/light_picture_test.cpp: pictures with light of voxels, occlusion and shadows: the native
// engine has the mirror's bits, whatever levels meet. Light appears in the right places, and has no cost
// where it is off.
#include "core/scene/preset.h"
#include "render/light/scene_light.h"
#include "render/picture/render_scene.h"
#include "tests/support/interactive_fixture.h"
#include "tests/support/lit_picture.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

Light castingLight(double softness = 0) {
    Light light;
    light.kind = LightKind::directional;
    light.direction = {-1, 1, 1};
    light.shadow = true;
    light.softness = softness;
    return light;
}
Light pointLight(const VolumeInfo& info) { // inside the volume
    Light light;
    light.kind = LightKind::point;
    light.frame = LightFrame::patient;
    light.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(glm::dvec3(info.extentVoxels) * 0.45, 1));
    light.shadow = true;
    return light;
}

Scene litScene(const std::string& store, const std::string& preset, int camera, Lighting lighting,
               const glm::ivec2& size = {24, 24}) {
    Scene scene = sceneOn(infoOf(store), preset, camera, size);
    scene.lighting = std::move(lighting);
    return scene;
}

/// With maps that are made soon.
struct LitPlan {
    LitPlan(const std::string& store, const Scene& scene) : prepared(store, scene) {
        prepared.p.view.shadowQuality.mapSize = 64;
    }
    Prepared prepared;
};

void expectNativeIsTheMirror(Prepared& prepared, const std::string& what) {
    const Image mirror = mirrorLit(prepared);
    for (const native::PacketTarget* target : nativeTargets())
        for (const bool ghostLayers : {true, false}) {
            NativeChoices choices;
            choices.target = target;
            choices.ghostLayers = ghostLayers;
            EXPECT_EQ(differing(nativePicture(prepared, choices).image, mirror), 0u)
                << what << ", " << target->name << (ghostLayers ? " with ghost layers" : "");
        }
}

TEST(LightPicture, NativeIsTheMirror) {
    const VolumeInfo info = infoOf("torso");
    Lighting occluded, shadowed, all;
    occluded.occlusion = Occlusion{};
    shadowed.lights = {castingLight()};
    all.occlusion = Occlusion{.rays = 16, .radiusMm = 9};
    all.lights = {Light{}, castingLight(10), pointLight(info)};
    all.lights[0].intensity = 0.3;
    all.finestLevel = 1;
    int camera = 0;
    for (const auto& [lighting, what] :
         {std::pair(occluded, "occlusion"), std::pair(shadowed, "a shadow"), std::pair(all, "all light")})
        for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated}) {
            Scene scene = litScene("torso", "soft-tissue", camera++ % 3, lighting);
            scene.quality.integrator = integrator;
            LitPlan lit("torso", scene);
            expectNativeIsTheMirror(lit.prepared, what);
        }
}

TEST(LightPicture, NativeIsTheMirrorWhereLevelsMix) {
    Lighting all;
    all.occlusion = Occlusion{.rays = 16, .radiusMm = 12};
    all.lights = {castingLight(), Light{}};
    for (unsigned seed = 0; seed < 3; ++seed) {
        LitPlan lit("torso", litScene("torso", "soft-tissue", static_cast<int>(seed), all));
        Planner& p = lit.prepared.p;
        p.setSelection(randomShownLevels(p.layer().selection, seed));
        expectNativeIsTheMirror(lit.prepared, "levels of seed " + std::to_string(seed));
    }
}

TEST(LightPicture, SurfacesAreLitToo) {
    Lighting all;
    all.occlusion = Occlusion{};
    all.lights = {castingLight()};
    for (const bool mixed : {false, true}) {
        Scene scene = litScene("torso", "soft-tissue", 0, all);
        scene.quality.integrator = mixed ? Integrator::midpoint : Integrator::preintegrated;
        scene.surfaces = {{300, {1, 0.9, 0.8}, 0.7}};
        LitPlan lit("torso", scene);
        Planner& p = lit.prepared.p;
        if (mixed)
            p.setSelection(randomShownLevels(p.layer().selection, 2));
        expectNativeIsTheMirror(lit.prepared, mixed ? "a surface, mixed levels" : "a surface");
    }
}

/// A sphere on nothing: what faces the light is lit, what does not is dark, and it darkens what lies behind.
TEST(LightPicture, DarkensWhatIsHidden) {
    const auto mean = [](const Image& image) {
        double sum = 0;
        for (const glm::vec4& p : image.pixels)
            sum += static_cast<double>(p.r + p.g + p.b);
        return sum / static_cast<double>(image.pixels.size());
    };
    Lighting plain, open, shadow, occlusion;
    plain.lights = {castingLight()};
    plain.lights[0].shadow = false;
    shadow.lights = {castingLight()};
    occlusion = plain;
    occlusion.occlusion = Occlusion{};
    open = plain;
    open.occlusion = Occlusion{.radiusMm = 1e-3, .bias = 0, .gamma = 1e-6}; // I^0: all of it
    const auto drawn = [&](const Lighting& lighting) {
        LitPlan lit("torso", litScene("torso", "bone-1", 0, lighting));
        return nativePicture(lit.prepared).image;
    };
    const Image bright = drawn(plain);
    EXPECT_LT(mean(drawn(shadow)), 0.95 * mean(bright));
    EXPECT_LT(mean(drawn(occlusion)), 0.98 * mean(bright));
    EXPECT_NEAR(mean(drawn(open)), mean(bright), 1e-3 * mean(bright));
}

double largestDifference(const std::vector<glm::vec4>& a, const std::vector<glm::vec4>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 4; ++c)
            largest = std::max(largest, static_cast<double>(std::abs(a[i][c] - b[i][c])));
    return largest;
}

/// Same operations on the same rays, as in gates_test.cpp; lights divide and take roots, of which drivers'
/// differ. Not along an axis of the phantom: on walls that rays run along, rounding decides which side they
/// see.
TEST(LightPicture, MarchIsTheMirror) {
    const GlContext context({"software"});
    const VolumeInfo info = infoOf("torso");
    Lighting one, two, three;
    one.occlusion = Occlusion{};
    two.occlusion = Occlusion{.rays = 16, .radiusMm = 9};
    two.lights = {castingLight(10), Light{}};
    three = two;
    three.lights.push_back(pointLight(info));
    int n = 0;
    for (const Lighting& lighting : {one, two, three})
        for (const bool mixed : {false, true})
            for (const bool surfaces : {false, true}) {
                Scene scene = litScene("torso", "soft-tissue", 2 * (n++ % 2), lighting);
                if (surfaces)
                    scene.surfaces = {{300, {1, 0.9, 0.8}, 0.7}};
                LitPlan lit("torso", scene);
                Planner& p = lit.prepared.p;
                if (mixed)
                    p.setSelection(randomShownLevels(p.layer().selection, 5));
                const std::vector<SegmentedRay<float>> rays = gpuRays(p.view.frame, lit.prepared.budgets.gpu);
                SceneLight light(p, 0);
                const StoredLight stored(light, p, lit.prepared.budgets.ram);
                MirrorInput input = mirrorInput(p, true);
                input.light = &stored;
                Work work;
                const auto mirror = mirrorRays<float>(
                    input, rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
                const GpuPicture gpu = marchOn(lit.prepared, kFeatureSkipping | kFeatureShading);
                EXPECT_LT(largestDifference(gpu.image.pixels, mirror), 5e-5)
                    << lightChannels(lighting) << " channels" << (mixed ? ", mixed levels" : "")
                    << (surfaces ? ", a surface" : "");
            }
}

TEST(LightPicture, CutsAndThreadsChangeNothing) {
    Lighting all;
    all.occlusion = Occlusion{};
    all.lights = {castingLight(5)};
    LitPlan lit("torso", litScene("torso", "bone-1", 0, all));
    const Image picture = nativePicture(lit.prepared).image;
    NativeChoices one, shreds, refined;
    one.threads = 1;
    shreds.shreds = true;
    shreds.slicing.fixedIterations = 3;
    refined.blocks = true;
    for (const NativeChoices& choices : {one, shreds, refined})
        EXPECT_EQ(differing(nativePicture(lit.prepared, choices).image, picture), 0u);
}

/// Planes, maps and what threads work in are inside both budgets, whichever engine; less is drawn coarser,
/// never more taken.
TEST(LightPicture, KeepsItsBudgets) {
    Lighting all;
    all.occlusion = Occlusion{.rays = 8, .radiusMm = 6};
    all.lights = {castingLight(4), Light{}};
    for (const EngineKind kind : {EngineKind::native, EngineKind::gpu})
        for (const std::size_t mib : {4, 9, 40}) {
            MemoryBudget ram("RAM", "--ram", std::size_t{160} << 20),
                gpu("GPU memory", "--gpu-memory", mib << 20);
            StoreReader reader(storePath("torso"), ram);
            RenderOptions options;
            options.engine = kind;
            options.device = {"software"};
            options.verify = Verify::none;
            const RenderResult result =
                renderScene(litScene("torso", "soft-tissue", 0, all), reader, ram, gpu, options);
            EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
            EXPECT_LE(ram.peakBytes(), ram.limitBytes());
            ASSERT_TRUE(result.light);
            EXPECT_EQ(result.light->channels, 2);
            EXPECT_GT(result.light->planeBytes, 0u);
            if (mib == 4) {
                EXPECT_LT(result.bricksOfLevel[0], result.residentBricks);
            }
        }
}

/// An interactive picture after an edit of the function has the light of the new one.
TEST(LightPicture, FollowsAnEdit) {
    Scene before = interactiveScene("bone-1", 0, {24, 24});
    before.lighting.occlusion = Occlusion{.rays = 8, .radiusMm = 9};
    Scene after = before;
    after.volumes[0].transferFunction = "skin-1";
    Session edited(before, std::size_t{64} << 20, {}, storePath("torso"), true);
    edited.converge();
    edited.renderer.setFunction(presetFunction("skin-1", {-1000, 2000, true, 1, {}}));
    edited.converge();
    Session fresh(after, std::size_t{64} << 20, {}, storePath("torso"), true);
    fresh.converge();
    EXPECT_EQ(differing(edited.renderer.picture(), fresh.renderer.picture()), 0u);
}

/// The medium behind a surface attenuates light, whether rays leap over empty space or not.
TEST(LightPicture, WhatIsBehindASurfaceTakesLight) {
    Lighting lighting;
    lighting.lights = {castingLight()};
    Scene scene = litScene("torso", "bone-1", 0, lighting);
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({}, {});
    scene.surfaces = {{-300, {0.9, 0.6, 0.5}, 0.05}}; // skin, through which light comes far
    const auto lights = [&](bool skipping) {
        scene.quality.skipping = skipping;
        LitPlan lit("torso", scene);
        SceneLight light(lit.prepared.p, 0);
        light.ready();
        const VolumeInfo& info = lit.prepared.p.info();
        std::vector<float> left;
        for (int n = 0; n < 1000; ++n) {
            const glm::dvec3 place =
                (glm::dvec3(n % 10, n / 10 % 10, n / 100) + 0.5) * 0.1 * glm::dvec3(info.extentVoxels);
            left.push_back(
                light.shadows().front().light(glm::dvec3(info.patientFromVoxel * glm::dvec4(place, 1))));
        }
        return left;
    };
    const std::vector<float> leaping = lights(true), walking = lights(false);
    EXPECT_EQ(leaping, walking);
    EXPECT_LT(*std::min_element(walking.begin(), walking.end()), 0.05f);
}

/// Bytes, samples and pictures of a scene without light are those of a scene that never heard of it.
TEST(LightPicture, CostsNothingWhereItIsNotAskedFor) {
    Lighting none;
    Light off = castingLight();
    off.intensity = 0;
    Lighting dark;
    off.scatter = 1;
    dark.lights = {Light{}, off};
    dark.scatterBy = ScatterSource::map;
    dark.lightMap.size = 192;
    Prepared plain("torso", litScene("torso", "bone-1", 0, none)),
        unlit("torso", litScene("torso", "bone-1", 0, dark));
    EXPECT_EQ(lightChannels(dark), 0);
    const NativePicture a = nativePicture(plain), b = nativePicture(unlit);
    EXPECT_EQ(differing(a.image, b.image), 0u);
    EXPECT_EQ(a.work.bytesUploaded, b.work.bytesUploaded);
    EXPECT_EQ(plain.budgets.gpu.peakBytes(), unlit.budgets.gpu.peakBytes());
    EXPECT_EQ(plain.budgets.ram.peakBytes(), unlit.budgets.ram.peakBytes());
}

} // namespace
} // namespace tessera::test
