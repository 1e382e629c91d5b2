// tests/render/picture/renderer_test.cpp: a renderer without rays is planned, measured and reported like all
// others.
#include "render/picture/draw_scene.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <cmath>

namespace tessera::test {
namespace {

constexpr glm::vec4 kDrawn{0.25f, 0.5f, 0.125f, 1}, kTruth{0.5f, 0.25f, 0.125f, 1};

/// One colour wherever it is asked; the truth is another one.
class FlatPixels : public PixelSource {
  public:
    explicit FlatPixels(std::string whyNot) : whyNot_(std::move(whyNot)) {}
    About about() const override { return {true, false, 1}; }
    std::optional<Image> draw(std::span<const glm::vec2> places, const glm::ivec2& arraySize, const Slicing&,
                              std::uint64_t, Work&) override {
        EXPECT_EQ(places.size(), rayCount(arraySize));
        Image image(arraySize);
        std::fill(image.pixels.begin(), image.pixels.end(), colour_);
        return image;
    }
    std::string toTruth() override {
        colour_ = kTruth;
        return whyNot_;
    }

  private:
    std::string whyNot_;
    glm::vec4 colour_ = kDrawn;
};

class FlatRenderer : public Renderer {
  public:
    Engine::About about() const override {
        Engine::About about;
        about.device = "paint";
        about.measures = true;
        return about;
    }
    bool draw(const FrameTask& task, RenderResult& result, Image& added) override {
        result.image = Image(task.plan.view.imageSize);
        std::fill(result.image.pixels.begin(), result.image.pixels.end(), kDrawn);
        if (adds) {
            added = Image(result.image.size);
            std::fill(added.pixels.begin(), added.pixels.end(), glm::vec4(0.5f, -1, 0.25f, 0));
        }
        return false;
    }
    std::unique_ptr<PixelSource> pixels(const FrameTask&) override {
        return std::make_unique<FlatPixels>(whyNot);
    }
    void endFrame() override { ++ended; }
    std::string fault() override { return broken; }

    bool adds = false;
    std::string whyNot, broken;
    int ended = 0;
};

struct Renderers : ::testing::Test {
    Budgets budgets;
    StoreReader store{storePath("torso"), budgets.ram};
    RenderOptions options;
    FlatRenderer* renderer = nullptr;

    RenderResult draw(const std::function<void(FlatRenderer&)>& set = {}) {
        options.engine = EngineKind::mirror;
        options.verify = Verify::full;
        RendererInstance made(options, budgets.ram, budgets.gpu);
        auto flat = std::make_unique<FlatRenderer>();
        renderer = flat.get();
        if (set)
            set(*flat);
        made.renderer = std::move(flat);
        const FrameContext context(budgets.ram, budgets.gpu, 1);
        Planner p;
        RenderResult result =
            drawScene(sceneOn(store.info(), "bone-1", 0, {48, 40}), p, made, context, options, {},
                      [&](const Scene& scene, const auto& limits, auto levels, auto bytes) {
                          return planScene(scene, store, limits, context, levels, bytes);
                      });
        ended = renderer->ended;
        return result;
    }
    int ended = 0;
};

TEST_F(Renderers, ItsErrorIsTheDifferenceToItsTruth) {
    const RenderResult r = draw();
    ASSERT_TRUE(r.measured);
    ASSERT_EQ(r.measured->whyNot, "");
    ASSERT_TRUE(r.measured->all.rms);
    const glm::vec4 d = kDrawn - kTruth;
    EXPECT_NEAR(r.measured->all.rms->value, std::sqrt(glm::dot(d, d) / 4), 1e-6);
    EXPECT_EQ(r.device, "paint");
    EXPECT_EQ(ended, 1);
    for (const glm::vec4& pixel : r.image.pixels)
        EXPECT_EQ(pixel, kDrawn);
}

// The picture without it is measured.
TEST_F(Renderers, LightThatIsAddedComesAfterMeasuring) {
    const RenderResult r = draw([](FlatRenderer& f) { f.adds = true; });
    const glm::vec4 d = kDrawn - kTruth;
    ASSERT_TRUE(r.measured && r.measured->all.rms);
    EXPECT_NEAR(r.measured->all.rms->value, std::sqrt(glm::dot(d, d) / 4), 1e-6);
    for (const glm::vec4& pixel : r.image.pixels)
        EXPECT_EQ(pixel, glm::vec4(0.75f, 0, 0.375f, 1)); // nothing below zero
}

// Whatever the picture's fetches and steps are.
TEST_F(Renderers, TheTruthOfRaysIsExactAndFine) {
    options.engine = EngineKind::gpu;
    options.device.text = "software";
    const RendererInstance made(options, budgets.ram, budgets.gpu);
    const FrameContext context(budgets.ram, budgets.gpu, 1);
    Scene scene = sceneOn(store.info(), "bone-1", 0, {16, 12});
    scene.quality.fetch = Fetch::hardware;
    Planner p = planScene(scene, store, made.renderer->limits(), context);
    RenderResult result;
    Image added;
    const FrameTask task{scene, p, context, options};
    made.renderer->draw(task, result, added);
    const double step = p.view.quality.stepVoxels;
    {
        const auto pixels = made.renderer->pixels(task);
        EXPECT_EQ(p.view.quality.fetch, Fetch::hardware);
        ASSERT_EQ(pixels->toTruth(), "");
        EXPECT_EQ(p.view.quality.fetch, Fetch::exact);
        EXPECT_LT(p.view.quality.stepVoxels, step / 2);
    }
    made.renderer->endFrame();
    made.renderer->close();
}

TEST_F(Renderers, WhatCannotBeMeasuredOrDrawnIsSaid) {
    const RenderResult r = draw([](FlatRenderer& f) { f.whyNot = "the truth is not known"; });
    ASSERT_TRUE(r.measured);
    EXPECT_EQ(r.measured->whyNot, "the truth is not known");
    EXPECT_FALSE(r.measured->all.rms);
    try {
        draw([](FlatRenderer& f) { f.broken = "out of paint"; });
        FAIL() << "a renderer's fault was not told";
    } catch (const Error& e) {
        EXPECT_STREQ(e.what(), "out of paint");
    }
}

} // namespace
} // namespace tessera::test
