// tests/render/backends/native_test.cpp: the native engine has the bits of the float mirror, whatever a scene
// asks for, whatever instruction set draws it, and however the work is cut.
#include "render/plan/visibility_rays.h"
#include "tests/support/lights.h"
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h" // Stored

#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(39, 43); // no packet's edges divide it

struct NativeCase {
    const char* store;
    const char* preset;
    int camera;
    Integrator integrator = Integrator::midpoint;
    Gradient gradient = Gradient::central;
    bool lights = false; // the scene's own, with materials
};
std::ostream& operator<<(std::ostream& out, const NativeCase& c) {
    return out << c.store << ", " << c.preset << ", camera " << c.camera << ", "
               << integratorNames()[static_cast<std::size_t>(c.integrator)] << ", "
               << gradientNames()[static_cast<std::size_t>(c.gradient)] << (c.lights ? ", lights" : "");
}
class Native : public testing::TestWithParam<NativeCase> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(storePath(GetParam().store)))
            GTEST_SKIP() << GetParam().store << " is absent: the real scans are not on this machine";
    }
    Scene scene() const {
        Scene s = sceneOn(infoOf(GetParam().store), GetParam().preset, GetParam().camera, kSize);
        s.quality.integrator = GetParam().integrator;
        s.shading.gradient = GetParam().gradient;
        if (GetParam().lights)
            lightWithAll(s, infoOf(GetParam().store),
                         GetParam().camera == 1 ? ShadingModel::blinnPhong : ShadingModel::phong,
                         GetParam().camera != 2);
        return s;
    }
};
INSTANTIATE_TEST_SUITE_P(
    Scenes, Native,
    testing::Values(NativeCase{"torso", "bone-1", 0}, NativeCase{"torso", "soft-tissue", 1},
                    NativeCase{"torso", "soft-tissue", 2}, NativeCase{"abdomen", "bone-1", 0},
                    NativeCase{"abdomen", "vessels-1", 1}, NativeCase{"abdomen", "soft-tissue", 2},
                    NativeCase{"head", "skin-1", 0}, NativeCase{"head", "bone-1", 1},
                    NativeCase{"head", "soft-tissue", 2}));
INSTANTIATE_TEST_SUITE_P(Integrators, Native,
                         testing::Values(NativeCase{"torso", "soft-tissue", 2, Integrator::linear},
                                         NativeCase{"torso", "bone-1", 1, Integrator::preintegrated},
                                         NativeCase{"torso", "soft-tissue", 0, Integrator::preintegrated2d},
                                         NativeCase{"abdomen", "vessels-1", 0, Integrator::linear},
                                         NativeCase{"abdomen", "soft-tissue", 2, Integrator::preintegrated},
                                         NativeCase{"head", "bone-1", 1, Integrator::preintegrated2d}));
INSTANTIATE_TEST_SUITE_P(
    Lights, Native,
    testing::Values(NativeCase{"torso", "bone-1", 0, Integrator::midpoint, Gradient::central, true},
                    NativeCase{"torso", "soft-tissue", 1, Integrator::linear, Gradient::sobel, true},
                    NativeCase{"torso", "soft-tissue", 2, Integrator::preintegrated, Gradient::central, true},
                    NativeCase{"torso", "soft-tissue", 0, Integrator::preintegrated2d, Gradient::analytic,
                               true}));
INSTANTIATE_TEST_SUITE_P(
    Gradients, Native,
    testing::Values(NativeCase{"torso", "soft-tissue", 0, Integrator::midpoint, Gradient::centralHalf},
                    NativeCase{"torso", "soft-tissue", 1, Integrator::midpoint, Gradient::forward},
                    NativeCase{"torso", "soft-tissue", 2, Integrator::midpoint, Gradient::sobel},
                    NativeCase{"torso", "bone-1", 0, Integrator::preintegrated, Gradient::analytic},
                    NativeCase{"torso", "soft-tissue", 1, Integrator::midpoint, Gradient::cubic, true},
                    NativeCase{"abdomen", "bone-1", 0, Integrator::linear, Gradient::cubic},
                    NativeCase{"torso", "soft-tissue", 0, Integrator::midpoint, Gradient::sobel2, true},
                    NativeCase{"torso", "skin-1", 2, Integrator::linear, Gradient::sobel4}));

TEST_P(Native, HasTheMirrorsBits) {
    for (const bool light : {true, false}) {
        SCOPED_TRACE(light ? "lit" : "plain");
        Scene s = scene();
        s.shading.on = light;
        Prepared prepared(GetParam().store, s);
        expectTheMirrorsBits(prepared);
    }
}

TEST_P(Native, CuttingTheWorkChangesNoBit) {
    Prepared prepared(GetParam().store, scene());
    const NativePicture whole = nativePicture(prepared);
    NativeChoices choices;
    choices.slicing.fixedIterations = 7;
    EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole.image), 0u) << "seven turns at a time";
    choices = {};
    choices.shreds = true;
    const NativePicture shreds = nativePicture(prepared, choices);
    EXPECT_EQ(differing(shreds.image, whole.image), 0u) << "deadlines that have passed";
    EXPECT_GT(shreds.work.dispatches, whole.work.dispatches + 5);
    choices = {};
    choices.threads = 1;
    EXPECT_EQ(differing(nativePicture(prepared, choices).image, whole.image), 0u) << "one thread";
    choices = {};
    choices.blocks = true;
    const NativePicture refined = nativePicture(prepared, choices);
    EXPECT_GT(refined.refinedCells, 0u);
    EXPECT_EQ(differing(refined.image, whole.image), 0u) << "blocks";
    EXPECT_LE(refined.work.segments, whole.work.segments);
}

TEST_P(Native, TerminationAndSkippingAreTheMirrors) {
    Scene s = scene();
    s.quality.terminationTransmittance = 1.0 / 510;
    Prepared terminating(GetParam().store, s);
    expectTheMirrorsBits(terminating);
    s.quality.skipping = false;
    Prepared everywhere(GetParam().store, s, false);
    expectTheMirrorsBits(everywhere);
}

TEST(NativeLevels, EveryLevelForAllHasTheMirrorsBits) {
    for (int level = 0; level < kLevelCount; ++level) {
        SCOPED_TRACE(level);
        Prepared prepared("torso", sceneOn(infoOf("torso"), "soft-tissue", 0, kSize));
        Planner& p = prepared.p;
        Selection s = p.layer().selection;
        s.counts = {};
        for (std::uint8_t& mine : s.levels) {
            if (mine != Selection::kEmpty)
                mine = static_cast<std::uint8_t>(level);
            ++s.counts[mine];
        }
        p.setSelection(s);
        expectTheMirrorsBits(prepared);
    }
}

/// A formula, stored as floats; and one of bytes.
TEST(NativeTypes, FloatsHaveTheMirrorsBits) {
    const Stored stored([](const glm::dvec3& p) {
        return 300 * std::sin(0.3 * p.x) * std::cos(0.23 * p.y) + 200 * std::sin(0.41 * p.z + 0.1 * p.x);
    });
    for (int camera = 0; camera < 3; ++camera) {
        Scene s = stored.scene({}, camera, 41);
        s.volumes[0].transferFunction = "auto";
        const auto prepared = stored.prepare(s);
        expectTheMirrorsBits(*prepared);
    }
}

/// All of a volume shows, out to its faces, whether bricks end there or not.
TEST(NativeBorders, HaveTheMirrorsBits) {
    for (const glm::ivec3& extent : {glm::ivec3(64, 32, 64), glm::ivec3(61, 35, 44)})
        for (const ValueType type : {ValueType::f32, ValueType::i16}) {
            const Stored stored(
                [](const glm::dvec3& p) {
                    return 500 + 300 * std::sin(0.7 * p.x) * std::cos(0.53 * p.y) +
                           200 * std::sin(0.61 * p.z);
                },
                extent, true, 1, type);
            Scene s = stored.scene({}, 1, 41);
            s.volumes[0].transferFunction =
                TransferFunction::fromOpacity({{-100, 0.1}, {1200, 0.4}}, {{0, {1, 0.5, 0.2}}}, 1);
            const auto prepared = stored.prepare(s);
            EXPECT_EQ(prepared->p.layer().selection.counts[Selection::kEmpty], 0u);
            expectTheMirrorsBits(*prepared);
        }
}

struct MixedCase {
    EdgeFunction edge;
    Sampling sampling;
    Integrator integrator;
    Gradient gradient;
    int camera;
};
class NativeMixed : public testing::TestWithParam<MixedCase> {};
INSTANTIATE_TEST_SUITE_P(
    Levels, NativeMixed,
    testing::Values(
        MixedCase{EdgeFunction::split, Sampling::limited, Integrator::midpoint, Gradient::central, 0},
        MixedCase{EdgeFunction::minimum, Sampling::naive, Integrator::midpoint, Gradient::central, 2},
        MixedCase{EdgeFunction::maximum, Sampling::full, Integrator::midpoint, Gradient::sobel, 1},
        MixedCase{EdgeFunction::nearest, Sampling::limited, Integrator::midpoint, Gradient::forward, 0},
        MixedCase{EdgeFunction::split, Sampling::limited, Integrator::linear, Gradient::centralHalf, 2},
        MixedCase{EdgeFunction::split, Sampling::naive, Integrator::preintegrated, Gradient::analytic, 0},
        MixedCase{EdgeFunction::maximum, Sampling::limited, Integrator::preintegrated2d, Gradient::central,
                  1},
        MixedCase{EdgeFunction::split, Sampling::limited, Integrator::midpoint, Gradient::cubic, 0},
        MixedCase{EdgeFunction::maximum, Sampling::full, Integrator::midpoint, Gradient::cubic, 1},
        MixedCase{EdgeFunction::split, Sampling::limited, Integrator::midpoint, Gradient::sobel2, 2},
        MixedCase{EdgeFunction::split, Sampling::limited, Integrator::preintegrated, Gradient::sobel4, 0}));

TEST_P(NativeMixed, HasTheMirrorsBits) {
    const MixedCase c = GetParam();
    for (const unsigned seed : {1u, 2u}) {
        MixedScene mixed("torso", "soft-tissue", c.camera, c.edge, c.sampling, kSize, c.integrator);
        setGradient(mixed.p().layer().optics, c.gradient);
        if (seed == 2)
            lightPlanWithAll(mixed.p());
        mixed.choose(seed == 1 ? randomShownLevels(mixed.p().layer().selection, seed)
                               : randomLevels(mixed.p().layer().selection, seed, true));
        ASSERT_TRUE(mixed.p().layer().mixed());
        expectTheMirrorsBits(*mixed.prepared);
        NativeChoices choices;
        choices.slicing.fixedIterations = 5;
        EXPECT_EQ(differing(nativePicture(*mixed.prepared, choices).image, mirrorPicture(*mixed.prepared)),
                  0u)
            << "five turns at a time";
    }
}

TEST(NativeVisibility, CountsWhatTheMirrorCounts) {
    for (const bool isMixed : {false, true}) {
        MixedScene scene("torso", "soft-tissue", 0, EdgeFunction::split, Sampling::limited, {96, 96});
        if (isMixed)
            scene.choose(randomShownLevels(scene.p().layer().selection, 3));
        Planner& p = scene.p();
        NativeEngine engine(0, scene.prepared->budgets.gpu, scene.prepared->budgets.ram);
        p.chosen.chooser.reset();
        p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
        Work work;
        loadBricks(engine, p, scene.prepared->budgets.gpu, work);
        const auto counter = engine.counter(scene.prepared->budgets.gpu);
        counter->begin();
        while (!counter->count(Slicing{}, RayCaster::Clock::time_point::min())) {
        }
        const VisibilityRays rays = visibilityRays(p.view.camera, p.info(), p.view.imageSize, p.strides());
        MirrorInput input = mirrorInput(p, false);
        input.strides = rays.strides;
        const auto seen = mirrorSeen(input, rayCount(glm::ivec2(rays.frame.imageSize)),
                                     frameRays(cast<float>(rays.frame)), 0);
        const std::vector<SeenBrick> mine = counter->seen();
        ASSERT_EQ(mine.size(), seen.size());
        std::size_t different = 0, met = 0;
        for (std::size_t b = 0; b < seen.size(); ++b) {
            different += mine[b].light != seen[b].light || mine[b].rays != seen[b].rays;
            met += seen[b].rays > 0;
        }
        EXPECT_EQ(different, 0u);
        EXPECT_GT(met, 3u);
    }
}

} // namespace
} // namespace tessera
