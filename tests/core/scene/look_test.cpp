// tests/core/scene/look_test.cpp: lighting presets, built in by name.
#include "core/scene/scene_presets.h"

#include "core/base/error.h"
#include "core/scene/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Look, AllAreReadableAndKeepWhatTheyAreNotAbout) {
    for (const std::string& name : lookNames()) {
        Scene scene;
        scene.volumes = {SceneVolume{"volume.zarr"}};
        scene.shading.gradient = Gradient::sobel;
        scene.shading.specularPower = 77;
        scene.lighting.finestLevel = 3;
        applyLook(name, scene);
        EXPECT_EQ(scene.shading.gradient, Gradient::sobel) << name;
        EXPECT_TRUE(scene.shading.on);
        EXPECT_NE(scene.shading.specularPower, 77) << name; // a lighting preset starts from the defaults
        const bool keepsNone = name == "plain" || name == "endoscope" || scene.lighting.transport;
        const int channels = keepsNone ? 0 : name.rfind("soft", 0) == 0 ? 1 : 2;
        EXPECT_EQ(lightChannels(scene.lighting), channels) << name;
        EXPECT_EQ(name == "plain", isHeadLightAlone(scene.lighting.lights)) << name;
        const Scene again = parseScene(sceneJson(scene), "/", "look");
        EXPECT_EQ(again.lighting, scene.lighting) << name;
    }
}

// In a lumen all is in shadow of what is around it: the lamp is at the eye, and what is deep is dark.
TEST(Look, TheEndoscopesLampIsAtTheEyeAndFallsOff) {
    Scene scene;
    scene.volumes = {SceneVolume{"volume.zarr"}};
    applyLook("endoscope", scene);
    ASSERT_EQ(scene.lighting.lights.size(), 1u);
    const Light& lamp = scene.lighting.lights[0];
    EXPECT_EQ(lamp.kind, LightKind::point);
    EXPECT_EQ(lamp.frame, LightFrame::camera);
    EXPECT_LE(glm::length(lamp.position), 2);
    EXPECT_FALSE(lamp.shadow);
    const auto light = [&](double mm) {
        return lamp.intensity / glm::dot(lamp.attenuation, glm::dvec3(1, mm, mm * mm));
    };
    EXPECT_GT(light(10), 0.8);
    EXPECT_LT(light(60), 0.5 * light(10));
}

TEST(Look, RefusalsHelp) {
    Scene scene;
    try {
        applyLook("studioo", scene);
        FAIL();
    } catch (const InputError& e) {
        EXPECT_THAT(e.what(), testing::HasSubstr("nearest: \"studio\""));
    }
}

} // namespace
} // namespace tessera
