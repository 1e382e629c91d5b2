// tests/render/transport/path_rounds_test.cpp: pictures of paths of light before they have all their samples:
// they are the pictures of so many samples, with their noise, and change nothing of the last one.
#include "core/base/error.h"
#include "render/picture/frame_renderer.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

namespace tessera::test {
namespace {

using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

Scene scattering(const VolumeInfo& info, int samples) {
    Scene scene = sceneOn(info, "bone-1", 0, {40, 24});
    Light sun;
    sun.kind = LightKind::directional;
    sun.direction = {0.5, 0.7, 0.6};
    sun.softness = 8;
    scene.lighting.lights = {sun};
    scene.lighting.transport = Transport{};
    scene.lighting.environment = Environment{Sky::twoTone, 0.5};
    scene.quality.pixels.samples = samples;
    scene.quality.pixels.seed = 3;
    return scene;
}

struct Rounds {
    RenderResult last;
    std::vector<Image> images;
    std::vector<int> samples;
    std::vector<std::optional<double>> noise;
};

Rounds drawn(const Scene& scene, EngineKind engine, bool asks = true) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
    const StoreReader store(storePath("torso"), ram);
    RenderOptions options;
    options.engine = engine;
    Rounds rounds;
    if (asks)
        options.onRound = [&](Image image, int samples, std::optional<double> noise) {
            rounds.images.push_back(std::move(image));
            rounds.samples.push_back(samples);
            rounds.noise.push_back(noise);
        };
    rounds.last = renderScene(scene, store, ram, gpu, options);
    EXPECT_LE(ram.peakBytes(), ram.limitBytes());
    return rounds;
}

VolumeInfo torso() {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    return StoreReader(storePath("torso"), ram).info();
}

TEST(PathRounds, AreThePicturesOfSoManySamples) {
    for (const EngineKind engine : {EngineKind::native, EngineKind::mirror})
        for (const int samples : {2, 11, 16}) {
            const Scene scene = scattering(torso(), samples);
            const Rounds rounds = drawn(scene, engine);
            EXPECT_TRUE(bitEqual(rounds.last.image, drawn(scene, engine, false).last.image));
            std::vector<int> expected;
            for (int n = 1; n < samples; n *= 2)
                expected.push_back(n);
            for (std::size_t n = 0; n < rounds.images.size(); ++n) {
                const int taken = rounds.samples[n];
                EXPECT_EQ(rounds.noise[n].has_value(), taken > 1);
                if (taken == 1)
                    continue;
                const RenderResult still = drawn(scattering(torso(), taken), engine, false).last;
                EXPECT_TRUE(bitEqual(rounds.images[n], still.image)) << taken;
                EXPECT_EQ(*rounds.noise[n], still.pixels.error->rms);
                EXPECT_LT(rounds.last.pixels.error->rms, *rounds.noise[n]);
            }
            ASSERT_THAT(rounds.samples, ElementsAreArray(expected)) << samples;
            ASSERT_FALSE(rounds.images.empty());
            EXPECT_FALSE(isBlank(rounds.images.front()));
        }
}

// From one sample to the mean of two.
TEST(PathRounds, TheFirstIsHalfOfTheSecond) {
    const Rounds rounds = drawn(scattering(torso(), 4), EngineKind::native);
    ASSERT_EQ(rounds.images.size(), 2u);
    std::size_t apart = 0;
    for (std::size_t i = 0; i < rounds.images[0].pixels.size(); ++i) {
        const glm::vec4 one = rounds.images[0].pixels[i], other = 2.0f * rounds.images[1].pixels[i] - one;
        for (int c = 0; c < 4; ++c)
            EXPECT_GE(other[c], -1e-6f) << "no light is negative";
        apart += one != other ? 1 : 0;
    }
    EXPECT_GT(apart, 50u);
}

TEST(PathRounds, ThereAreNoneWithoutPaths) {
    Scene scene = scattering(torso(), 16);
    scene.lighting.transport.reset();
    scene.lighting.environment.reset();
    EXPECT_TRUE(drawn(scene, EngineKind::native).images.empty());
    scene.quality.pixels.samples = PixelSampling::kAutomatic;
    EXPECT_TRUE(drawn(scene, EngineKind::native).images.empty());
}

// An engine that follows no paths draws no frame of a film without saying so.
TEST(PathRounds, FilmsAreDrawnByAnEngineThatFollowsPaths) {
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{256} << 20);
    const StoreReader store(storePath("torso"), ram);
    const StoreReader* const stores[] = {&store};
    const Scene scene = scattering(torso(), 2);
    RenderOptions options;
    options.device.text = "software";
    options.engine = EngineKind::gpu;
    std::string why = "drawn";
    try {
        FrameRenderer(store, ram, gpu, options).draw(scene);
    } catch (const InputError& e) {
        why = e.what();
    }
    EXPECT_THAT(why, HasSubstr("it follows no paths of light"));
    EXPECT_THROW(optionsFor(scene, stores, options), InputError);
    options.engine = EngineKind::native;
    EXPECT_EQ(optionsFor(scene, stores, options).engine, EngineKind::native);
}

} // namespace
} // namespace tessera::test
