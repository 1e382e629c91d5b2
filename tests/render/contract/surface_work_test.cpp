// Isosurfaces: cutting the work, skipping, levels and budgets change nothing, GPU ray caster and mirror
// agree, and nothing is sampled where there are none.
#include "core/base/error.h"
#include "render/picture/render_scene.h"
#include "tests/support/surface_fixture.h"

#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

// Skipping, blocks found on the device, the map of surfaces, tiles, splitting: no bit changes, of pictures
// and hits.
TEST(Isosurfaces, CuttingTheWorkAndSkippingChangeNoBit) {
    const GlContext context({"software"});
    struct Case {
        int camera;
        bool volume;
        Integrator integrator;
        bool mixed;
    };
    for (const Case& c :
         {Case{0, false, Integrator::preintegrated, false}, Case{1, true, Integrator::midpoint, false},
          Case{2, true, Integrator::preintegrated, false}, Case{0, false, Integrator::midpoint, true},
          Case{1, true, Integrator::preintegrated, true}}) {
        SCOPED_TRACE(std::to_string(c.camera) + (c.volume ? " volume" : "") + (c.mixed ? " mixed" : ""));
        Prepared prepared("torso", torsoScene(c.camera, c.volume, c.integrator));
        if (c.mixed) {
            std::mt19937 random(3);
            Selection s = prepared.p.layer().selection;
            s.counts = {};
            for (std::uint8_t& level : s.levels) {
                if (level != Selection::kEmpty)
                    level = static_cast<std::uint8_t>(random() % kLevelCount);
                ++s.counts[level];
            }
            prepared.p.setSelection(s);
        }
        EXPECT_EQ(prepared.p.layer().mapsSurfaces, c.volume);
        const Drawn all = draw(prepared, kFeatureSkipping);
        EXPECT_GT(hitCount(all.hits), 50u);
        const Drawn skipped = draw(prepared);
        EXPECT_TRUE(bitEqual(all.image, skipped.image));
        EXPECT_EQ(all.hits, skipped.hits);
        EXPECT_LE(skipped.work.segments, all.work.segments);
        const Drawn refined = draw(prepared, 0, {}, true);
        EXPECT_TRUE(bitEqual(all.image, refined.image));
        EXPECT_EQ(all.hits, refined.hits);
        EXPECT_LE(refined.work.segments, skipped.work.segments);
        Slicing shreds;
        shreds.fixedTile = 17;
        shreds.fixedIterations = 9;
        const Drawn cut = draw(prepared, 0, shreds, true);
        EXPECT_TRUE(bitEqual(all.image, cut.image));
        EXPECT_EQ(all.hits, cut.hits);
        EXPECT_GT(cut.work.dispatches, 4 * refined.work.dispatches);
    }
}

// GPU ray caster and float mirror on the same rays: as in the table of docs/sampling.md for the volume alone.
TEST(Isosurfaces, MarchEqualsTheMirror) {
    const GlContext context({"software"});
    for (const int camera : {0, 1, 2})
        for (const bool volume : {false, true}) {
            Prepared prepared("torso", torsoScene(camera, volume, Integrator::preintegrated));
            const auto rays = gpuRays(prepared.p.view.frame, prepared.budgets.gpu);
            const MirrorInput input = mirrorInput(prepared.p, true);
            const RaySource<float> source = [&](std::size_t i) { return rays[i]; };
            Work work;
            const auto single = mirrorRays<float>(input, rays.size(), source, 0, work);
            const auto singleHits = mirrorHits<float>(input, rays.size(), source, 0);
            const auto exact = mirrorRays<double>(
                input, rays.size(),
                [&](std::size_t i) {
                    SegmentedRay<double> d;
                    d.entry = rays[i].entry, d.step = rays[i].step, d.direction = rays[i].direction;
                    d.segmentMm = static_cast<double>(rays[i].segmentMm);
                    d.tail = static_cast<double>(rays[i].tail), d.count = rays[i].count;
                    return d;
                },
                0, work);
            const Drawn drawn = draw(prepared);
            double marchWorst = 0, floatWorst = 0;
            int unlike = 0;
            for (std::size_t i = 0; i < rays.size(); ++i) {
                for (int c = 0; c < 4; ++c) {
                    const double mirrored = static_cast<double>(single[i][c]);
                    marchWorst = std::max(marchWorst,
                                          std::abs(static_cast<double>(drawn.image.pixels[i][c]) - mirrored));
                    floatWorst = std::max(floatWorst, std::abs(mirrored - exact[i][c]));
                }
                unlike += drawn.hits[i] == singleHits[i] ? 0 : 1;
            }
            EXPECT_LE(marchWorst, 1e-5); // a ray that all but touches makes floatWorst any size
            EXPECT_EQ(unlike, 0);
            RecordProperty("camera" + std::to_string(camera) + (volume ? "volume" : ""),
                           std::to_string(marchWorst) + " against " + std::to_string(floatWorst));
        }
}

// A ray that ends early leaves out no more than it may, as rays without surfaces do; and some do end early.
TEST(Isosurfaces, TerminationLeavesOutNoMoreThanItSays) {
    const GlContext context({"software"});
    Scene scene = torsoScene(0, true, Integrator::midpoint);
    scene.surfaces[1].opacity = 0.6;
    scene.shading.on = false; // no component above 1
    Prepared full("torso", scene);
    scene.quality.terminationTransmittance = 1.0 / 510;
    Prepared ended("torso", scene);
    const auto mirrored = [](Prepared& prepared) {
        Work work;
        const FramePlan& p = prepared.p;
        return mirrorRays<float>(mirrorInput(p, true), rayCount(p.view.imageSize),
                                 frameRays(cast<float>(p.view.frame)), 0, work);
    };
    const std::vector<glm::vec4> pictures[2][2] = {{draw(full).image.pixels, draw(ended).image.pixels},
                                                   {mirrored(full), mirrored(ended)}};
    for (const auto& [all, some] : pictures) {
        float most = 0;
        for (std::size_t i = 0; i < all.size(); ++i)
            for (int c = 0; c < 4; ++c) {
                ASSERT_GE(all[i][c] - some[i][c], 0);
                most = std::max(most, all[i][c] - some[i][c]);
            }
        EXPECT_LE(most, 1.0 / 510 + 1e-6);
        EXPECT_GT(most, 0) << "no ray ended early";
    }
}

// Nothing of the volume is sampled away from surfaces when the function shows nothing; bricks that no surface
// crosses are not even there.
TEST(Isosurfaces, NothingIsSampledFarFromThem) {
    const GlContext context({"software"});
    const Stored stored([](const glm::dvec3& p) { return p.z; }, {64, 64, 128}, true);
    Scene scene = stored.scene({{40.2, glm::dvec3(1), 0.5}}, 1, 8);
    scene.camera = fitCamera(stored.info, View::inferior, Projection::parallel, {8, 8});
    const auto prepared = stored.prepare(scene);
    EXPECT_EQ(prepared->p.layer().selection.shownBricks(), 2u * 2u);
    const Drawn drawn = draw(*prepared, kFeatureShading);
    std::size_t entered = 0;
    for (const auto& ray : gpuRays(prepared->p.view.frame, prepared->budgets.gpu))
        entered += ray.count > 0 ? 1 : 0;
    ASSERT_GT(entered, 10u);
    // Two cells of 8 voxels along the ray, because the lower one knows the first voxel of the other, in
    // segments of half a voxel.
    EXPECT_LE(drawn.work.segments, 34 * entered);
    EXPECT_EQ(hitCount(drawn.hits), entered);
    // With blocks of two voxels found: two blocks and what they touch.
    EXPECT_LE(draw(*prepared, kFeatureShading, {}, true).work.segments, 8 * entered);
}

// Values beyond a table read as its ends: surfaces at the ends of a function's range make nothing else
// occupied, and bricks around them get the levels that they need.
TEST(Isosurfaces, OccupyOnlyWhereTheyAre) {
    for (const double isovalue : {-300.0, 250.0}) {
        Scene scene = torsoScene(0, false, Integrator::midpoint, {200, 200});
        scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0, 0}}, {});
        scene.surfaces = {{isovalue, glm::dvec3(1), 0.5}};
        MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30),
            gpu("GPU memory", "--gpu-memory", std::size_t{1} << 30);
        const StoreReader reader(storePath("torso"), ram);
        const Planner p = planScene(scene, reader, TextureLimits{}, {ram, gpu, 0});
        EXPECT_LT(p.layer().occupancy.occupiedCells(), p.layer().occupancy.map().size() / 2) << isovalue;
        EXPECT_GT(p.layer().selection.counts[0], 10u) << isovalue;
    }
}

TEST(Isosurfaces, CostNothingWhereThereAreNone) {
    const GlContext context({"software"});
    Scene scene = torsoScene(0, true, Integrator::preintegrated);
    Prepared with("torso", scene);
    EXPECT_NE(marchFeatures(with.p, false) & kFeatureSurfaces, 0u);
    for (Isosurface& s : scene.surfaces)
        s.opacity = 0;
    Prepared without("torso", scene);
    EXPECT_EQ(marchFeatures(without.p, false) & kFeatureSurfaces, 0u);
    EXPECT_FALSE(without.p.layer().mapsSurfaces);
    EXPECT_TRUE(without.p.layer().optics.surfaces.empty());
    scene.surfaces.clear();
    Prepared plain("torso", scene);
    EXPECT_EQ(without.p.layer().table.entries.size(), plain.p.layer().table.entries.size());
    const GlProgram program = marchComposition(marchFeatures(plain.p, true)).program("march.comp");
    EXPECT_FALSE(program.hasUniform("uIsovalues"));
    EXPECT_TRUE(marchComposition(marchFeatures(with.p, true)).program("march.comp").hasUniform("uIsovalues"));
    EXPECT_TRUE(bitEqual(marchOn(without, marchFeatures(without.p, true)).image,
                         marchOn(plain, marchFeatures(plain.p, true)).image));
}

// Several passes with an atlas far too small for the scene give the same picture. So does one turn per ray
// and dispatch, which must then suffice to request the missing bricks.
TEST(Isosurfaces, AnyBudgetDrawsTheSame) {
    struct Case {
        Integrator integrator;
        bool volume, lit;
        Gradient gradient;
    };
    for (const Case& c : {Case{Integrator::preintegrated, true, true, Gradient::central},
                          Case{Integrator::midpoint, true, true, Gradient::sobel},
                          Case{Integrator::midpoint, false, false, Gradient::central}}) {
        SCOPED_TRACE(integratorNames()[static_cast<std::size_t>(c.integrator)] + (c.lit ? " lit" : ""));
        Scene scene = torsoScene(0, c.volume, c.integrator, {24, 24});
        scene.volumes[0].path = storePath("torso");
        scene.shading.on = c.lit;
        scene.shading.gradient = c.gradient;
        scene.quality.maxError = 0;
        std::vector<RenderResult> results;
        for (const std::size_t kilobytes : {262144, 1024, 1536, 2048, 2560, 3072, 4096, 5120}) {
            MemoryBudget ram("RAM", "--ram", std::size_t{512} << 20),
                gpu("GPU memory", "--gpu-memory", kilobytes << 10);
            const StoreReader reader(storePath("torso"), ram);
            RenderOptions options;
            options.device.text = "software";
            options.checking = false;
            try {
                results.push_back(renderScene(scene, reader, ram, gpu, options));
            } catch (const InputError&) {
                continue; // below the scene's floor
            }
            if (results.size() < 2)
                continue;
            options.slicing.fixedIterations = 1;
            results.push_back(renderScene(scene, reader, ram, gpu, options));
            break;
        }
        ASSERT_EQ(results.size(), 3u);
        EXPECT_EQ(results[0].passes, 1);
        EXPECT_GT(results[1].passes, 1);
        EXPECT_GT(results[2].passes, 1);
        EXPECT_TRUE(bitEqual(results[0].image, results[1].image));
        EXPECT_TRUE(bitEqual(results[0].image, results[2].image));
    }
}

} // namespace
} // namespace tessera
