// Visibility of bricks. The GPU ray caster's counts equal the mirror's, and an opaque wall hides everything
// behind it. Levels chosen by visibility are better than those chosen without.
#include "core/image/image_metrics.h"
#include "render/backends/gpu/visibility_pass.h"
#include "render/picture/render_scene.h"
#include "tests/support/scene_fixture.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

/// Counts on the device and on the CPU.
struct Counted {
    std::vector<SeenBrick> march, mirror;
};
Counted count(Prepared& prepared) {
    Planner& p = prepared.p;
    const GlContext context({"software"});
    const VisibilityRays rays = visibilityRays(p.view.camera, p.info(), p.view.imageSize, p.strides());
    OnDevice device(prepared);
    const auto counter = device.engine.counter(prepared.budgets.gpu);
    counter->begin();
    EXPECT_TRUE(counter->count(Slicing{}, RayCaster::Clock::time_point::max()));
    Counted counted;
    counted.march = counter->seen();
    MirrorInput input = mirrorInput(p, false);
    input.strides = rays.strides;
    const glm::ivec2 size(rays.frame.imageSize);
    counted.mirror =
        mirrorSeen(input, static_cast<std::size_t>(size.x * size.y), frameRays(cast<float>(rays.frame)), 2);
    EXPECT_TRUE(context.errors().empty());
    return counted;
}

Scene torso(const std::string& preset, int camera) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    return sceneOn(StoreReader(storePath("torso"), ram).info(), preset, camera, {160, 120});
}

TEST(Visibility, MarchCountsWhatItsMirrorCounts) {
    for (const bool mixed : {false, true}) {
        Prepared prepared("torso", torso("soft-tissue", 0));
        Planner& p = prepared.p;
        if (mixed) {
            Selection levels = p.layer().selection;
            levels.counts = {};
            for (std::size_t b = 0; b < levels.levels.size(); ++b) {
                if (levels.levels[b] != Selection::kEmpty)
                    levels.levels[b] = static_cast<std::uint8_t>(b % kLevelCount);
                ++levels.counts[levels.levels[b]];
            }
            p.setSelection(std::move(levels));
        }
        const Counted counted = count(prepared);
        std::uint64_t rays = 0, raysOff = 0, hidden = 0;
        for (std::size_t b = 0; b < counted.march.size(); ++b) {
            const SeenBrick &a = counted.march[b], &m = counted.mirror[b];
            rays += m.rays;
            raysOff += a.rays > m.rays ? a.rays - m.rays : m.rays - a.rays;
            hidden += m.rays > 0 && m.light < m.rays * 8;
            // A stride on a face may fall to either side, and light is rounded to 1/256 of a ray's. One ray
            // in a thousand has a filtered fetch that the mirror's arithmetic places elsewhere in the
            // function.
            EXPECT_NEAR(a.light, m.light, 16 + 0.02 * m.light + 256.0 * std::abs(int(a.rays) - int(m.rays)))
                << b;
        }
        EXPECT_GT(rays, 4000u);
        EXPECT_LE(raysOff, rays / 500);
        EXPECT_GT(hidden, 5u) << "soft tissue is opaque: something must be hidden";
    }
}

// With a budget that is short, what is hidden gives its memory to what is seen.
TEST(Visibility, LevelsChosenBySightAreBetter) {
    Scene scene = torso("soft-tissue", 1);
    scene.imageSize = {128, 128};
    MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{4} << 20),
        large("GPU memory", "--gpu-memory", std::size_t{1} << 30);
    const StoreReader reader(storePath("torso"), ram);
    RenderOptions options;
    options.device.text = "software";
    const Image finest = renderScene(scene, reader, ram, large, options).image;
    const RenderResult chosen = renderScene(scene, reader, ram, gpu, options);
    EXPECT_LE(gpu.peakBytes(), gpu.limitBytes());
    // As many pages, every brick taken as wholly visible.
    Prepared blind("torso", scene);
    LevelChooser chooser(blind.reader, blind.budgets.ram, 2);
    chooser.setFunction(blind.p.layer().statistics, blind.p.layer().table, cullingFor(scene.shading));
    chooser.setCamera(blind.p.view.camera, scene.imageSize);
    blind.p.setSelection(chooser.best(blind.p.layer().statistics.brickMean, chosen.atlasPages));
    const GlContext context({"software"});
    const Image without = marchOn(blind, marchFeatures(blind.p, false)).image;
    EXPECT_LT(compare(chosen.image, finest).luvMean, 0.6 * compare(without, finest).luvMean);
    // The mirror chooses by the same counts.
    options.engine = EngineKind::mirror;
    EXPECT_EQ(renderScene(scene, reader, ram, gpu, options).bricksOfLevel, chosen.bricksOfLevel);
}

} // namespace
} // namespace tessera
