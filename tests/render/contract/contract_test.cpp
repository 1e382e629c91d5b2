// The table at the end of docs/sampling.md, row by row, on a phantom and on real scans, three cameras each,
// one of them inside the volume. Pictures come from the software device, which every machine has.
#include "core/image/image_metrics.h"
#include "tests/support/lights.h"
#include "tests/support/scene_fixture.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr glm::ivec2 kSize(40, 40); // small: exact mode on a software device takes microseconds a sample
constexpr std::uint32_t kExact = kFeatureSkipping;

struct Case {
    const char* store;
    const char* preset;
    int camera;
    Integrator integrator = Integrator::midpoint;
    bool lights = false; // the scene's own, with materials
};
std::ostream& operator<<(std::ostream& out, const Case& c) {
    return out << c.store << ", " << c.preset << ", camera " << c.camera << ", "
               << integratorNames()[static_cast<std::size_t>(c.integrator)] << (c.lights ? ", lights" : "");
}

class Contract : public testing::TestWithParam<Case> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(storePath(GetParam().store)))
            GTEST_SKIP() << GetParam().store << " is absent: the real scans are not on this machine";
    }
    Scene scene(bool shading) const {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        const StoreReader reader(storePath(GetParam().store), ram);
        Scene s = sceneOn(reader.info(), GetParam().preset, GetParam().camera, kSize);
        s.shading.on = shading;
        s.quality.integrator = GetParam().integrator;
        if (GetParam().lights)
            lightWithAll(s, reader.info(),
                         GetParam().camera == 1 ? ShadingModel::blinnPhong : ShadingModel::phong, true);
        return s;
    }
};

INSTANTIATE_TEST_SUITE_P(Scenes, Contract,
                         testing::Values(Case{"torso", "bone-1", 0}, Case{"torso", "soft-tissue", 1},
                                         Case{"torso", "soft-tissue", 2}, Case{"abdomen", "bone-1", 0},
                                         Case{"abdomen", "vessels-1", 1}, Case{"abdomen", "soft-tissue", 2},
                                         Case{"head", "skin-1", 0}, Case{"head", "bone-1", 1},
                                         Case{"head", "soft-tissue", 2}));
INSTANTIATE_TEST_SUITE_P(Integrators, Contract,
                         testing::Values(Case{"torso", "soft-tissue", 2, Integrator::linear},
                                         Case{"torso", "bone-1", 1, Integrator::preintegrated},
                                         Case{"torso", "soft-tissue", 0, Integrator::preintegrated2d},
                                         Case{"abdomen", "vessels-1", 0, Integrator::linear},
                                         Case{"abdomen", "soft-tissue", 2, Integrator::preintegrated},
                                         Case{"head", "bone-1", 1, Integrator::preintegrated2d}));
INSTANTIATE_TEST_SUITE_P(Lights, Contract,
                         testing::Values(Case{"torso", "soft-tissue", 0, Integrator::midpoint, true},
                                         Case{"torso", "soft-tissue", 2, Integrator::linear, true},
                                         Case{"torso", "bone-1", 1, Integrator::preintegrated, true},
                                         Case{"abdomen", "bone-1", 1, Integrator::preintegrated2d, true}));

// Row: skipping on and off; tile size; dispatch splitting; resume: bit-equal, exact mode, termination off.
TEST_P(Contract, CuttingTheWorkAndSkippingChangeNoBit) {
    const GlContext context({"software"});
    Prepared prepared(GetParam().store, scene(true));
    const std::uint32_t features = kExact | kFeatureShading;
    const GpuPicture whole = marchOn(prepared, features);
    EXPECT_FALSE(isBlank(whole.image));
    const GpuPicture everySegment = marchOn(prepared, features & ~kFeatureSkipping);
    EXPECT_TRUE(bitEqual(whole.image, everySegment.image)) << "skipping changed the picture";
    EXPECT_LT(whole.work.segments, everySegment.work.segments) << "nothing was skipped";
    Slicing shreds;
    shreds.fixedTile = 24; // not a divisor of the picture's size
    shreds.fixedIterations = 7;
    const GpuPicture resumed = marchOn(prepared, features, shreds);
    EXPECT_TRUE(bitEqual(whole.image, resumed.image)) << "tiles or resuming changed the picture";
    EXPECT_GT(resumed.work.dispatches, 4 * whole.work.dispatches);
}

// Row: GPU ray caster and float mirror on the GPU's own float rays. They differ by at most 4 times the
// difference of float and double mirror on that scene; a half-voxel shift must fail.
TEST_P(Contract, MarchEqualsTheMirrorOnItsOwnRays) {
    const GlContext context({"software"});
    for (const bool shading : {false, true}) {
        Prepared prepared(GetParam().store, scene(shading));
        Planner& p = prepared.p;
        const std::vector<SegmentedRay<float>> rays = gpuRays(p.view.frame, prepared.budgets.gpu);
        const MirrorInput input = mirrorInput(p, true);
        const auto mirrored = [&](glm::vec3 shift) {
            Work work;
            return std::pair(mirrorRays<float>(
                                 input, rays.size(),
                                 [&](std::size_t i) {
                                     SegmentedRay<float> r = rays[i];
                                     r.entry += shift;
                                     return r;
                                 },
                                 0, work),
                             work);
        };
        const auto [single, work] = mirrored(glm::vec3(0));
        Work doubleWork;
        const auto exact = mirrorRays<double>(
            input, rays.size(),
            [&](std::size_t i) {
                const SegmentedRay<float>& r = rays[i];
                SegmentedRay<double> d;
                d.entry = r.entry, d.step = r.step, d.direction = r.direction;
                d.segmentMm = static_cast<double>(r.segmentMm), d.tail = static_cast<double>(r.tail);
                d.count = r.count;
                return d;
            },
            0, doubleWork);
        const GpuPicture gpu = marchOn(prepared, kExact | (shading ? kFeatureShading : 0u));
        const auto [shifted, unused] = mirrored(glm::vec3(0.5f));
        // Per picture: largest and rms difference over all components.
        struct Distance {
            double largest = 0, squares = 0;
            void add(double e) {
                largest = std::max(largest, std::abs(e));
                squares += e * e;
            }
        } floatError, marchError, shiftError;
        for (std::size_t i = 0; i < rays.size(); ++i)
            for (int c = 0; c < 4; ++c) {
                const double s = static_cast<double>(single[i][c]);
                floatError.add(s - exact[i][c]);
                marchError.add(static_cast<double>(gpu.image.pixels[i][c]) - s);
                shiftError.add(static_cast<double>(shifted[i][c]) - s);
            }
        RecordProperty(shading ? "marchMaxShaded" : "marchMax", std::to_string(marchError.largest));
        RecordProperty(shading ? "floatMaxShaded" : "floatMax", std::to_string(floatError.largest));
        EXPECT_LE(marchError.largest, 4 * floatError.largest) << "shading " << shading;
        EXPECT_LE(marchError.largest, 1e-5) << "whatever the scene's own rounding";
        EXPECT_LE(marchError.squares, 16 * floatError.squares) << "shading " << shading;
        EXPECT_GT(shiftError.largest, 4 * floatError.largest) << "the test has no teeth";
        EXPECT_GT(shiftError.squares, 16 * floatError.squares);
        EXPECT_EQ(work.segments, gpu.work.segments) << "march and mirror took different segments";
    }
}

// Threads change no bit on the CPU either.
TEST_P(Contract, MirrorIsTheSameAtAnyNumberOfThreads) {
    Prepared prepared(GetParam().store, scene(false));
    Planner& p = prepared.p;
    const MirrorInput input = mirrorInput(p, true);
    const std::size_t count = static_cast<std::size_t>(kSize.x) * kSize.y;
    Work work;
    const auto rays = frameRays(cast<float>(p.view.frame));
    const auto one = mirrorRays<float>(input, count, rays, 1, work);
    EXPECT_EQ(one, mirrorRays<float>(input, count, rays, 2, work));
    EXPECT_EQ(one, mirrorRays<float>(input, count, rays, 5, work));
}

// Hardware fetch against mirror (OpenImageIO's gate): at most 0.02 % of values differ by more than 0.004,
// none by more than 0.012.
TEST_P(Contract, HardwareFetchStaysInsideTheGate) {
    const GlContext context({"software"});
    Prepared prepared(GetParam().store, scene(true));
    Planner& p = prepared.p;
    const MirrorInput input = mirrorInput(p, true);
    Work work;
    const auto pixels = mirrorRays<float>(input, static_cast<std::size_t>(kSize.x) * kSize.y,
                                          frameRays(cast<float>(p.view.frame)), 0, work);
    Image mirror(kSize);
    mirror.pixels = pixels;
    const ImageDifference d =
        compare(marchOn(prepared, kExact | kFeatureShading | kFeatureHardware).image, mirror);
    EXPECT_EQ(d.nonFinite, 0u);
    EXPECT_LE(static_cast<double>(d.valuesAbove004), 0.0002 * static_cast<double>(d.values));
    EXPECT_EQ(d.valuesAbove012, 0u) << "largest " << d.maxAbs;
}

// Early termination is one-sided and bounded by its threshold.
TEST_P(Contract, TerminationLeavesOutNoMoreThanItSays) {
    const GlContext context({"software"});
    Scene s = scene(true);
    Prepared full(GetParam().store, s);
    s.quality.terminationTransmittance = 1.0 / 510;
    Prepared ended(GetParam().store, s);
    const Image a = marchOn(full, kExact | kFeatureShading).image;
    const Image b = marchOn(ended, kExact | kFeatureShading | kFeatureTermination).image;
    // Shaded colour can exceed 1 by the specular part; alpha's bound is the threshold itself.
    const double most = brightest(s.shading, s.lighting, full.p.layer().function.materials());
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            const double left = static_cast<double>(a.pixels[i][c]) - static_cast<double>(b.pixels[i][c]);
            ASSERT_GE(left, 0);
            ASSERT_LE(left, (c == 3 ? 1 : most) / 510 + 1e-6);
        }
}

} // namespace
} // namespace tessera
