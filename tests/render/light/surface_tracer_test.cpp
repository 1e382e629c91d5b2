// tests/render/light/surface_tracer_test.cpp: ways of light among isosurfaces, and in a volume that shows:
// every engine follows them alike, to what the reference finds.
#include "render/backends/mirror/mirror_surfaces.h"
#include "render/backends/native/native_tracer.h"
#include "render/backends/reference/surface_rays.h"
#include "render/picture/render_scene.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/occluded_surfaces.h"
#include "tests/support/reference_light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

/// In all directions from places on the first surfaces that a picture meets, some of a length beside the
/// volume.
std::vector<LightWay> waysFrom(Prepared& prepared, unsigned seed, std::size_t count) {
    const FramePlan& p = prepared.p;
    const auto hits = mirrorHits<float>(mirrorInput(p, true), rayCount(p.view.imageSize),
                                        frameRays(cast<float>(p.view.frame)), 0);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1), length(0.1, 40);
    std::vector<LightWay> ways;
    for (std::size_t n = 0; ways.size() < count && n < 100 * count; ++n) {
        const SurfaceHit& hit = hits[random() % hits.size()];
        const glm::dvec3 d(unit(random), unit(random), unit(random));
        if (hit.surface == 0 || glm::length(d) > 1 || glm::length(d) < 0.1)
            continue;
        const glm::dvec3 extent(p.info().extentVoxels),
            direction = glm::normalize(d),
            from = glm::clamp(glm::dvec3(hit.position) + 1.5 * direction, glm::dvec3(0), extent);
        double voxels = length(random);
        for (int axis = 0; axis < 3; ++axis)
            if (direction[axis] != 0)
                voxels = std::min(voxels,
                                  ((direction[axis] > 0 ? extent[axis] : 0) - from[axis]) / direction[axis]);
        ways.push_back({from, direction, std::max(voxels, 0.0),
                        glm::length(glm::dmat3(p.info().patientFromVoxel) * direction)});
    }
    return ways;
}
std::size_t unlike(const std::vector<LightTaken>& a, const std::vector<LightTaken>& b) {
    std::size_t count = 0;
    for (std::size_t n = 0; n < a.size(); ++n)
        count += std::memcmp(&a[n], &b[n], sizeof a[n]) != 0;
    return count;
}

/// Gradients that packets do not take are the mirror's.
TEST(SurfaceTracer, GradedVolumesTakeAnyGradient) {
    for (const Gradient kind : {Gradient::analytic, Gradient::cubic, Gradient::sobel4}) {
        Scene scene = inVolume(occludedScene(0, {24, 24}, {.rays = 4}), true);
        scene.shading.gradient = kind;
        Budgets budgets;
        const StoreReader store(storePath("torso"), budgets.ram);
        Image pictures[2];
        for (const EngineKind engine : {EngineKind::native, EngineKind::mirror}) {
            RenderOptions options;
            options.engine = engine;
            pictures[engine == EngineKind::mirror] =
                renderScene(scene, store, budgets.ram, budgets.gpu, options).image;
        }
        EXPECT_EQ(differing(pictures[0], pictures[1]), 0u) << nameOf(kind);
    }
}

TEST(SurfaceTracer, NativeIsTheMirror) {
    for (const int volume : {0, 1, 2}) // none; tissue; graded tissue
        for (const bool mixed : {false, true})
            for (const bool refine : {false, true})
                for (const bool skipping : {true, false}) {
                    Scene scene = occludedScene(mixed ? 1 : 0, {40, 40});
                    if (volume > 0)
                        scene = inVolume(scene, volume > 1);
                    scene.quality.skipping = skipping;
                    scene.quality.integrator = refine ? Integrator::linear : Integrator::preintegrated;
                    Prepared prepared("torso", scene);
                    Planner& p = prepared.p;
                    if (mixed)
                        p.setSelection(randomShownLevels(p.layer().selection, 3));
                    const auto ways = waysFrom(prepared, 7, 1500);
                    ASSERT_EQ(ways.size(), 1500u);
                    const auto mirror = traced(MirrorTracer(p, 1), ways);
                    std::size_t met = 0;
                    for (const LightTaken& t : mirror)
                        met += t.taken > 0;
                    EXPECT_GT(met, 200u);
                    EXPECT_TRUE(met < 1400 || volume > 0);
                    for (const native::PacketTarget* target : nativeTargets()) {
                        NativeEngine engine(0, prepared.budgets.gpu, prepared.budgets.ram);
                        p.chosen.chooser.reset();
                        p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
                        Work work;
                        loadBricks(engine, p, prepared.budgets.gpu, work);
                        NativeCaster caster(p, engine, {}, prepared.budgets.gpu, target);
                        if (refine)
                            caster.refine();
                        caster.begin(raysOf(p));
                        EXPECT_EQ(unlike(traced(*caster.surfaceTracer(1), ways), mirror), 0u)
                            << target->name << (mixed ? " mixed" : "") << (refine ? " refined" : "")
                            << (skipping ? "" : " without skipping");
                    }
                }
}

/// Along the same ways, to 1e-4 of their length: but for those that all but touch a surface, which one of the
/// two may miss.
TEST(SurfaceTracer, IsTheReference) {
    Scene scene = occludedScene(0, {40, 40});
    Prepared prepared("torso", scene);
    ASSERT_TRUE(prepared.p.layer().selection.uniform());
    ASSERT_EQ(prepared.p.layer().selection.finest(), 0);
    const auto ways = waysFrom(prepared, 9, 6000);
    const ReferenceInput input = referenceInput(prepared, scene);
    const auto truth = traced(ReferenceSurfaces(input), ways),
               found = traced(MirrorTracer(prepared.p, 1), ways);
    std::size_t off = 0, met = 0;
    for (std::size_t n = 0; n < ways.size(); ++n) {
        const double mm = ways[n].voxels * ways[n].mmPerVoxel;
        met += truth[n].taken > 0;
        off += std::abs(truth[n].taken - found[n].taken) > 1e-4f ||
               std::abs(static_cast<double>(truth[n].mm - found[n].mm)) > 1e-4 * std::max(mm, 1.0);
    }
    EXPECT_GT(met, 1000u);
    EXPECT_LE(off, ways.size() / 500);
}

TEST(SurfaceTracer, InAVolumeComesToTheReference) {
    for (const bool graded : {false, true}) {
        Scene scene = inVolume(occludedScene(0, {40, 40}), graded);
        Prepared prepared("torso", scene);
        const auto ways = waysFrom(prepared, 11, 300);
        const ReferenceInput input = referenceInput(prepared, scene);
        const auto truth = traced(ReferenceSurfaces(input), ways);
        std::vector<double> errors;
        for (const double segment : {1.0, 0.25}) {
            const auto found = traced(MirrorTracer(prepared.p, segment), ways);
            double squares = 0, between = 0;
            for (std::size_t n = 0; n < ways.size(); ++n) {
                const double taken = double{found[n].taken} - double{truth[n].taken},
                             mm = (double{found[n].mm} - double{truth[n].mm}) /
                                  std::max(1.0, ways[n].voxels * ways[n].mmPerVoxel);
                squares += taken * taken + mm * mm;
                between += truth[n].taken > 0.02f && truth[n].taken < 0.98f;
            }
            EXPECT_GT(between, 100);
            errors.push_back(std::sqrt(squares / static_cast<double>(ways.size())));
        }
        EXPECT_LT(errors[0], 0.02) << graded;
        EXPECT_LT(errors[1], 0.2 * errors[0]) << graded;
    }
}

} // namespace
} // namespace tessera::test
