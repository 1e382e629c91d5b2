// tests/render/backends/native_work_test.cpp: the native engine counts the work that the mirror does, with
// every instruction set, and the lanes that are used of its packets.
#include "tests/support/graded.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h" // Stored

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

struct Counted {
    Work work;
    NativeCaster::Lanes lanes;
};

Counted counted(Prepared& prepared, const native::PacketTarget& target, const Slicing& slicing = {}) {
    Planner& p = prepared.p;
    NativeEngine engine(2, prepared.budgets.gpu, prepared.budgets.ram);
    p.layer().pageEdge = kGhostedEdge;
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    Counted out;
    loadBricks(engine, p, prepared.budgets.gpu, out.work);
    out.work = {};
    NativeCaster caster(p, engine, {true, false, false}, prepared.budgets.gpu, &target);
    caster.begin(raysOf(p));
    drawToTheEnd(caster, engine, p, slicing, out.work);
    out.lanes = caster.lanes();
    return out;
}
Work ofTheMirror(const Prepared& prepared) {
    const FramePlan& p = prepared.p;
    Work work;
    MirrorInput input = mirrorInput(p, p.view.quality.skipping);
    input.segmentVoxels = p.view.frame.segmentVoxels;
    mirrorRays<float>(input, rayCount(p.view.imageSize), frameRays(cast<float>(p.view.frame)), 2, work);
    return work;
}

/// Waves of 0 to 1000 in a cube, and nothing around it.
Stored waves() {
    return Stored(
        [](const glm::dvec3& p) {
            const bool inside = p.x > 9 && p.x < 35 && p.y > 11 && p.y < 30 && p.z > 13 && p.z < 40;
            return inside
                       ? 500 + 300 * std::sin(0.7 * p.x) * std::cos(0.53 * p.y) + 200 * std::sin(0.61 * p.z)
                       : -500;
        },
        {44, 40, 48}, true);
}
TransferFunction thin() {
    return TransferFunction::fromOpacity({{300, 0}, {900, 0.2}}, {{0, {1, 0.5, 0.2}}}, 1);
}

class NativeWork : public testing::Test {
  protected:
    /// @param leaps  over empty space come a little later than the mirror's: then more segments are taken
    void check(const Scene& scene, bool leaps = false) {
        const auto prepared = stored_.prepare(scene);
        const Work mirror = ofTheMirror(*prepared);
        ASSERT_GT(mirror.segments, 1000u);
        for (const native::PacketTarget* target : nativeTargets()) {
            SCOPED_TRACE(target->name);
            const Counted mine = counted(*prepared, *target);
            const auto more = static_cast<double>(mine.work.segments) / static_cast<double>(mirror.segments);
            EXPECT_GE(more, 1);
            EXPECT_LE(more, leaps ? 1.05 : 1);
            EXPECT_EQ(mine.work.samples - mine.work.segments, mirror.samples - mirror.segments);
            EXPECT_GE(mine.work.iterations, mine.work.segments);
            EXPECT_NEAR(static_cast<double>(mine.work.iterations) / static_cast<double>(mirror.iterations), 1,
                        0.08);
            const auto width = static_cast<std::uint64_t>(target->lanes());
            EXPECT_EQ(mine.lanes.width, target->lanes());
            EXPECT_LE(mine.lanes.turns, mine.lanes.used);
            EXPECT_LE(mine.lanes.used, mine.lanes.turns * width);
            EXPECT_GE(mine.lanes.used, mine.work.segments);
            // All other samples are those of gradients.
            ASSERT_LE(mine.lanes.used, mine.work.samples);
            if (scene.shading.on) {
                EXPECT_EQ((mine.work.samples - mine.lanes.used) % 6, 0u);
            } else {
                EXPECT_EQ(mine.lanes.used, mine.work.samples);
            }
            EXPECT_GE(static_cast<double>(mine.lanes.used),
                      0.5 * static_cast<double>(mine.lanes.turns * width))
                << "most lanes of a packet have something to do";
            Slicing cut;
            cut.fixedIterations = 7;
            const Counted parts = counted(*prepared, *target, cut);
            EXPECT_LE(static_cast<double>(parts.work.segments), 1.05 * static_cast<double>(mirror.segments));
            EXPECT_GE(parts.work.segments, mirror.segments);
            EXPECT_GE(parts.work.samples - parts.work.segments, mirror.samples - mirror.segments);
        }
    }
    Stored stored_ = waves();
};

TEST_F(NativeWork, OfAVolumeIsTheMirrors) {
    for (const bool skipping : {true, false})
        for (const bool lit : {false, true}) {
            SCOPED_TRACE(lit ? "lit" : "unlit");
            Scene scene = stored_.scene({}, 1, 37);
            scene.volumes[0].transferFunction = thin();
            scene.quality.skipping = skipping;
            scene.shading.on = lit;
            check(scene, skipping);
        }
}

TEST_F(NativeWork, OfSegmentsByTheirEndsIsTheMirrors) {
    for (const Integrator integrator :
         {Integrator::linear, Integrator::preintegrated, Integrator::preintegrated2d}) {
        Scene scene = stored_.scene({}, 1, 37);
        scene.volumes[0].transferFunction = thin();
        scene.quality.integrator = integrator;
        check(scene);
    }
}

TEST_F(NativeWork, OfIsosurfacesIsTheMirrors) {
    for (const bool volume : {false, true}) {
        Scene scene = stored_.scene({{600, {1, 1, 1}, 0.4}}, 1, 37);
        if (volume)
            scene.volumes[0].transferFunction = thin();
        check(scene);
    }
}

TEST_F(NativeWork, OfSingleValuesIsTheMirrors) {
    for (const Mode mode : {Mode::maximum, Mode::average}) {
        Scene scene = stored_.scene({}, 1, 37);
        scene.volumes[0].transferFunction = "auto";
        scene.mode = mode;
        check(scene);
    }
}

} // namespace
} // namespace tessera
