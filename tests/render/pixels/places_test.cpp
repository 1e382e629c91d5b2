// tests/render/pixels/places_test.cpp: rays through any places of a picture, by every engine. Places are
// exact (a picture of twice the size has the same rays), whatever the array's shape and order, however the
// work is cut, and while rays wait for bricks.
#include "core/image/image_metrics.h"
#include "render/backends/mirror/mirror_engine.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/reference_engine.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/places.h"
#include "tests/support/surface_fixture.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kWhole(24, 18), kPlaces(37, 23); // no packet's edges divide the array

VolumeInfo infoOf(const std::string& store) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    return StoreReader(storePath(store), ram).info();
}

/// An engine with all bricks of a scene that was prepared, and a caster of it.
struct Drawer {
    Drawer(Engine& e, Prepared& prepared, bool hits = false) : engine(e), p(prepared.p) {
        p.chosen.chooser.reset();
        p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
        loadBricks(engine, p, prepared.budgets.gpu, work);
        caster = engine.caster({true, hits, false}, prepared.budgets.gpu);
    }
    ~Drawer() {
        caster.reset();
        engine.close();
    }
    Image operator()(const Rays& rays) {
        caster->begin(rays);
        drawToTheEnd(*caster, engine, p, Slicing{}, work);
        return caster->image();
    }
    /// Every deadline has passed.
    Image inShreds(const Rays& rays) {
        caster->begin(rays);
        Slicing slicing;
        slicing.fixedTile = 16;
        while (!caster->draw(slicing, RayCaster::Clock::time_point::min(), work)) {
        }
        return caster->image();
    }
    Engine& engine;
    Planner& p;
    Work work;
    std::unique_ptr<RayCaster> caster;
};

RayFrame<double> twiceAsLarge(RayFrame<double> frame) {
    frame.imageSize *= 2;
    return frame;
}

/// Properties that every engine must have, on the scene as it was prepared.
void expectPlaces(Engine& engine, Prepared& prepared, bool picturesOfAnySize) {
    Drawer draw(engine, prepared);
    const FramePlan& p = prepared.p;
    const RayFrame<double>& frame = p.view.frame;
    const Image today = draw(raysOf(p));
    EXPECT_FALSE(isBlank(today));
    const Places middle = middles(kWhole, 1);
    EXPECT_TRUE(bitEqual(draw(middle.of(frame, p.strides())), today));
    if (picturesOfAnySize) {
        const Places quarters = middles(kWhole, 2);
        EXPECT_TRUE(
            bitEqual(draw(quarters.of(frame, p.strides())), draw({twiceAsLarge(frame), p.strides()})));
    }
    // The same middles in another order, in an array of another shape with some of them twice.
    std::vector<std::size_t> order(rayCount(kWhole));
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(5));
    Places shuffled{{}, kPlaces};
    for (std::size_t i = 0; i < rayCount(kPlaces); ++i)
        shuffled.all.push_back(middle.all[order[i % order.size()]]);
    const Rays rays = shuffled.of(frame, p.strides());
    const Image drawn = draw(rays);
    ASSERT_EQ(drawn.size, kPlaces);
    std::size_t different = 0;
    for (std::size_t i = 0; i < drawn.pixels.size(); ++i)
        different += drawn.pixels[i] != today.pixels[order[i % order.size()]];
    EXPECT_EQ(different, 0u);
    EXPECT_TRUE(bitEqual(draw.inShreds(rays), drawn));
    EXPECT_TRUE(bitEqual(draw(raysOf(p)), today)) << "afterwards, without places";
}

TEST(Places, AreWhatTheySayOnEveryEngine) {
    const GlContext context({"software"});
    for (const int camera : {0, 1, 2}) {
        const Scene scene = sceneOn(infoOf("torso"), "soft-tissue", camera, kWhole);
        Prepared prepared("torso", scene);
        MemoryBudget& gpu = prepared.budgets.gpu;
        MemoryBudget& ram = prepared.budgets.ram;
        GpuEngine march(context, gpu, ram);
        NativeEngine native(2, gpu, ram);
        MirrorEngine mirror(2);
        ReferenceEngine reference(2);
        for (Engine* engine : {static_cast<Engine*>(&march), static_cast<Engine*>(&native),
                               static_cast<Engine*>(&mirror), static_cast<Engine*>(&reference)}) {
            SCOPED_TRACE(testing::Message() << "camera " << camera << ", "
                                            << (engine == &march    ? "gpu"
                                                : engine == &native ? "native"
                                                : engine == &mirror ? "mirror"
                                                                    : "reference"));
            expectPlaces(*engine, prepared, engine != &reference);
        }
    }
}

TEST(Places, OfTheReferenceAreThoseOfLargerPictures) {
    MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
    const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
    for (const int camera : {0, 1, 2}) {
        const Camera c = cameraNumber(camera, info, kWhole);
        const auto rays = referenceRays(c, info, kWhole, middles(kWhole, 2).all);
        const auto larger = referenceRays(c, info, 2 * kWhole);
        ASSERT_EQ(rays.size(), larger.size());
        for (std::size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(rays[i].base, larger[i].base);
            ASSERT_EQ(rays[i].direction, larger[i].direction);
            ASSERT_EQ(rays[i].tMin, larger[i].tMin);
        }
    }
}

/// By the float mirror, which takes rays one by one.
Image mirrored(const FramePlan& p, const Places& places) {
    Image image(places.size);
    Work work;
    image.pixels = mirrorRays<float>(mirrorInput(p, p.view.quality.skipping), places.all.size(),
                                     frameRays(cast<float>(p.view.frame), places.all), 0, work);
    return image;
}

// With each instruction set, one level and mixed ones.
TEST(Places, NativePicturesHaveTheMirrorsBits) {
    for (const bool isMixed : {false, true}) {
        MixedScene scene("torso", "soft-tissue", 0, EdgeFunction::split, Sampling::limited, kWhole);
        if (isMixed)
            scene.choose(randomShownLevels(scene.p().layer().selection, 3));
        Planner& p = scene.p();
        const Places places = randomPlaces(kWhole, kPlaces, 11);
        const Image mirror = mirrored(p, places);
        EXPECT_FALSE(isBlank(mirror));
        for (const native::PacketTarget* target : nativeTargets()) {
            NativeChoices choices;
            choices.target = target;
            choices.rays = places.of(p.view.frame, p.strides());
            for (const bool shreds : {false, true}) {
                choices.shreds = shreds;
                EXPECT_TRUE(bitEqual(nativePicture(*scene.prepared, choices).image, mirror))
                    << target->name << (isMixed ? ", mixed" : "") << (shreds ? ", cut" : "");
            }
        }
    }
}

TEST(Places, NativeSurfacesAndHitsAreTheMirrors) {
    Prepared prepared("torso", torsoScene(0, true, Integrator::midpoint, kWhole));
    const FramePlan& p = prepared.p;
    const Places places = randomPlaces(kWhole, kPlaces, 12);
    NativeChoices choices;
    choices.hits = true;
    choices.rays = places.of(p.view.frame, p.strides());
    const NativePicture picture = nativePicture(prepared, choices);
    EXPECT_TRUE(bitEqual(picture.image, mirrored(p, places)));
    EXPECT_TRUE(picture.hits == mirrorHits<float>(mirrorInput(p, true), places.all.size(),
                                                  frameRays(cast<float>(p.view.frame), places.all), 0));
    MirrorEngine mirror(2);
    Drawer draw(mirror, prepared, true);
    EXPECT_TRUE(bitEqual(draw(*choices.rays), picture.image));
    EXPECT_TRUE(draw.caster->hits() == picture.hits);
}

// On the GPU's own rays, as pictures are compared; and those at pixels' middles have the bits of a picture's.
TEST(Places, MarchEqualsTheMirrorOnItsOwnRays) {
    const GlContext context({"software"});
    for (const bool surfaces : {false, true}) {
        Prepared prepared("torso", surfaces ? torsoScene(0, true, Integrator::midpoint, kWhole)
                                            : sceneOn(infoOf("torso"), "soft-tissue", 0, kWhole));
        const FramePlan& p = prepared.p;
        MemoryBudget& gpu = prepared.budgets.gpu;
        const Places places = randomPlaces(kWhole, kPlaces, 13);
        const Rays rays = places.of(p.view.frame, p.strides());
        const auto own = gpuRays(rays, gpu);
        ASSERT_EQ(own.size(), places.all.size());
        Work work;
        Image mirror(kPlaces);
        const auto source = [&](std::size_t i) { return own[i]; };
        mirror.pixels = mirrorRays<float>(mirrorInput(p, true), own.size(), source, 0, work);
        GpuEngine engine(context, gpu, prepared.budgets.ram);
        Drawer draw(engine, prepared, surfaces);
        EXPECT_LE(compare(draw(rays), mirror).maxAbs, 1e-5);
        EXPECT_FALSE(isBlank(mirror));
        if (surfaces) {
            EXPECT_TRUE(draw.caster->hits() ==
                        mirrorHits<float>(mirrorInput(p, true), own.size(), source, 0));
        }
        const Places middle = middles(kWhole, 1);
        const auto through = gpuRays(middle.of(p.view.frame, p.strides()), gpu);
        const auto pixels = gpuRays(p.view.frame, gpu);
        ASSERT_EQ(through.size(), pixels.size());
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            ASSERT_EQ(through[i].entry, pixels[i].entry);
            ASSERT_EQ(through[i].direction, pixels[i].direction);
            ASSERT_EQ(through[i].count, pixels[i].count);
        }
    }
}

// Few pages: rays wait for bricks, and go on where they were.
TEST(Places, WaitingRaysGoOnThroughTheirPlaces) {
    const GlContext context({"software"});
    Scene scene = sceneOn(infoOf("torso"), "bone-1", 0, kWhole);
    for (const bool onGpu : {true, false}) {
        Prepared prepared("torso", scene);
        Planner& p = prepared.p;
        MemoryBudget& gpu = prepared.budgets.gpu;
        const Places places = randomPlaces(kWhole, kPlaces, 14);
        const Rays rays = places.of(p.view.frame, p.strides());
        const auto drawn = [&](std::size_t pages, int& passes) {
            std::unique_ptr<Engine> engine;
            if (onGpu)
                engine = std::make_unique<GpuEngine>(context, gpu, prepared.budgets.ram);
            else
                engine = std::make_unique<NativeEngine>(2, gpu, prepared.budgets.ram);
            p.chosen.chooser.reset();
            p.chosen.atlasPages = pages;
            Work work;
            const bool waits = loadBricks(*engine, p, gpu, work);
            const auto caster = engine->caster({true, false, waits}, gpu);
            caster->begin(rays);
            passes = drawToTheEnd(*caster, *engine, p, Slicing{}, work);
            return caster->image();
        };
        const std::size_t all = pagesFor(p.layer().selection.counts);
        ASSERT_GT(all, 9u);
        int one = 0, many = 0;
        const Image ample = drawn(all, one), scarce = drawn(9, many);
        EXPECT_EQ(one, 1);
        EXPECT_GT(many, 2);
        EXPECT_TRUE(bitEqual(ample, scarce)) << (onGpu ? "gpu" : "native");
    }
}

TEST(Places, AreChargedWhereTheyAreKept) {
    const GlContext context({"software"});
    Prepared prepared("torso", sceneOn(infoOf("torso"), "bone-1", 0, kWhole));
    const FramePlan& p = prepared.p;
    MemoryBudget& gpu = prepared.budgets.gpu;
    GpuEngine engine(context, gpu, prepared.budgets.ram);
    Drawer draw(engine, prepared);
    draw(raysOf(p));
    const std::size_t before = gpu.usedBytes();
    const Places places = randomPlaces(kWhole, kWhole, 15);
    draw(places.of(p.view.frame, p.strides()));
    EXPECT_EQ(gpu.usedBytes() - before, kRayPlaceBytes * rayCount(kWhole));
    draw(raysOf(p));
    EXPECT_EQ(gpu.usedBytes(), before);
}

} // namespace
} // namespace tessera
