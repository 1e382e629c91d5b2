// tests/render/backends/native_surfaces_test.cpp: rays among isosurfaces in packets have the bits of the
// float mirror, and meet first what its rays meet, whatever draws them and however the work is cut.
#include "tests/support/mixed_fixture.h"
#include "tests/support/native_fixture.h"
#include "tests/support/surface_fixture.h"

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

constexpr glm::ivec2 kSize(39, 43); // no packet's edges divide it

std::vector<SurfaceHit> hitsOfMirror(const FramePlan& p) {
    return mirrorHits<float>(mirrorInput(p, p.view.quality.skipping), rayCount(p.view.imageSize),
                             frameRays(cast<float>(p.view.frame)), 0);
}

void expectTheMirrorsBitsAndHits(Prepared& prepared) {
    const Image mirror = mirrorPicture(prepared);
    const std::vector<SurfaceHit> met = hitsOfMirror(prepared.p);
    EXPECT_FALSE(isBlank(mirror));
    EXPECT_GT(hitCount(met), 100u);
    const auto expectSame = [&](const NativeChoices& choices, const std::string& how) {
        const NativePicture picture = nativePicture(prepared, choices);
        EXPECT_EQ(differing(picture.image, mirror), 0u) << how;
        EXPECT_EQ(picture.hits == met, choices.hits) << how;
        return picture;
    };
    for (const native::PacketTarget* target : nativeTargets())
        for (const bool ghostLayers : {true, false}) {
            NativeChoices choices;
            choices.target = target;
            choices.ghostLayers = ghostLayers;
            choices.hits = true;
            expectSame(choices,
                       std::string(target->name) + (ghostLayers ? ", ghost layers" : ", no ghost layers"));
        }
    const NativePicture whole = expectSame({}, "no hits asked for");
    NativeChoices choices;
    choices.hits = true;
    choices.slicing.fixedIterations = 3;
    expectSame(choices, "three turns at a time");
    choices = {};
    choices.hits = choices.shreds = true;
    EXPECT_GT(expectSame(choices, "deadlines that have passed").work.dispatches, whole.work.dispatches + 5);
}

struct SurfaceCase {
    int camera;
    bool volume;
    Integrator integrator;
    bool lit = true;
    Gradient gradient = Gradient::central;
    bool skipping = true;
    double termination = 0;
};
class NativeSurfaces : public testing::TestWithParam<SurfaceCase> {
  protected:
    Scene scene() const {
        const SurfaceCase c = GetParam();
        Scene s = torsoScene(c.camera, c.volume, c.integrator, kSize);
        s.shading.on = c.lit;
        s.shading.gradient = c.gradient;
        s.quality.skipping = c.skipping;
        s.quality.terminationTransmittance = c.termination;
        return s;
    }
};
INSTANTIATE_TEST_SUITE_P(
    Scenes, NativeSurfaces,
    testing::Values(SurfaceCase{0, false, Integrator::midpoint}, SurfaceCase{1, true, Integrator::midpoint},
                    SurfaceCase{2, true, Integrator::preintegrated},
                    SurfaceCase{0, true, Integrator::linear, true, Gradient::sobel},
                    SurfaceCase{1, true, Integrator::preintegrated2d, true, Gradient::analytic},
                    SurfaceCase{2, true, Integrator::midpoint, false},
                    SurfaceCase{0, false, Integrator::preintegrated, false, Gradient::forward, false},
                    SurfaceCase{0, true, Integrator::midpoint, true, Gradient::centralHalf, true, 0.05},
                    SurfaceCase{1, true, Integrator::midpoint, true, Gradient::cubic},
                    SurfaceCase{0, true, Integrator::midpoint, true, Gradient::sobel2}));

TEST_P(NativeSurfaces, PicturesAndHitsAreTheMirrors) {
    Prepared prepared("torso", scene());
    EXPECT_EQ(prepared.p.layer().mapsSurfaces, GetParam().volume && GetParam().skipping);
    expectTheMirrorsBitsAndHits(prepared);
}

TEST_P(NativeSurfaces, OfMixedLevelsAreTheMirrors) {
    for (const EdgeFunction edge : {EdgeFunction::split, EdgeFunction::nearest}) {
        if (edge == EdgeFunction::nearest && GetParam().integrator != Integrator::midpoint)
            continue; // needs a continuous field
        Scene s = scene();
        s.quality.edgeFunction = edge;
        s.quality.sampling = edge == EdgeFunction::nearest ? Sampling::naive : Sampling::limited;
        Prepared prepared("torso", s);
        prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 3));
        ASSERT_TRUE(prepared.p.layer().mixed());
        expectTheMirrorsBitsAndHits(prepared);
    }
}

/// Lights and materials of the scene: of the volume by its values, of surfaces by theirs.
TEST(NativeSurfaceLights, PicturesAreTheMirrors) {
    const VolumeInfo info = infoOf("torso");
    Light point;
    point.kind = LightKind::point;
    point.frame = LightFrame::patient;
    point.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(glm::dvec3(info.extentVoxels) * 0.4, 1));
    point.colour = {1, 0.8, 0.5};
    for (const Integrator integrator : {Integrator::midpoint, Integrator::preintegrated}) {
        Scene s = torsoScene(0, true, integrator, kSize);
        s.lighting.lights = {Light{}, point};
        s.lighting.lights[0].intensity = 0.4;
        TransferFunction function =
            TransferFunction::fromOpacity({{-200, 0}, {400, 0.05}}, {{0, {1, 0.5, 0.2}}}, 1);
        function.setMaterials(
            {{.from = -400, .to = 100, .diffuse = 0.3}, {.from = 100, .to = 900, .specular = 0.9}});
        s.volumes[0].transferFunction = function;
        Prepared prepared("torso", s);
        expectTheMirrorsBitsAndHits(prepared);
    }
}

// Rays wait for bricks in the middle of strides, and go on as if they had not.
TEST_P(NativeSurfaces, ScarceBricksChangeNothing) {
    Prepared prepared("torso", scene());
    Planner& p = prepared.p;
    const auto drawn = [&](std::size_t pages, int turns, int& passes) {
        NativeEngine engine(2, prepared.budgets.gpu, prepared.budgets.ram);
        p.chosen.chooser.reset();
        p.chosen.atlasPages = pages;
        Work work;
        const bool waits = loadBricks(engine, p, prepared.budgets.gpu, work);
        const auto caster = engine.caster({true, true, waits}, prepared.budgets.gpu);
        caster->begin(raysOf(p));
        Slicing slicing;
        slicing.fixedIterations = turns;
        passes = drawToTheEnd(*caster, engine, p, slicing, work);
        return std::pair(caster->image(), caster->hits());
    };
    const std::size_t all = pagesFor(p.layer().selection.counts);
    ASSERT_GT(all, 9u);
    int one = 0, many = 0;
    const auto ample = drawn(all, 0, one);
    EXPECT_EQ(one, 1);
    for (const int turns : {0, 1}) {
        const auto scarce = drawn(9, turns, many);
        EXPECT_GT(many, 1);
        EXPECT_EQ(differing(scarce.first, ample.first), 0u);
        EXPECT_TRUE(scarce.second == ample.second);
    }
}

/// Both distance maps, and one for all that shows.
TEST(NativeSurfaceBlocks, ChangeNoBit) {
    for (const bool volume : {false, true})
        for (const bool mixed : {false, true}) {
            SCOPED_TRACE(std::string(volume ? "volume" : "alone") + (mixed ? ", mixed levels" : ""));
            Prepared prepared("torso", torsoScene(0, volume, Integrator::midpoint, {150, 150}));
            if (mixed)
                prepared.p.setSelection(randomShownLevels(prepared.p.layer().selection, 3));
            NativeChoices choices;
            choices.hits = true;
            const NativePicture cells = nativePicture(prepared, choices);
            choices.blocks = true;
            const NativePicture blocks = nativePicture(prepared, choices);
            EXPECT_GT(blocks.refinedCells, 100u);
            EXPECT_LT(blocks.work.samples, cells.work.samples);
            EXPECT_EQ(differing(blocks.image, cells.image), 0u);
            EXPECT_TRUE(blocks.hits == cells.hits);
        }
}

/// White noise: cubics that turn, several crossings a piece, up to eight surfaces, two of one value. First
/// hits are kept for every pixel, and charged.
TEST(NativeSurfaceHits, AreCharged) {
    Prepared prepared("torso", torsoScene(0, false, Integrator::midpoint, kSize));
    Planner& p = prepared.p;
    NativeEngine engine(1, prepared.budgets.gpu, prepared.budgets.ram);
    p.chosen.chooser.reset();
    p.chosen.atlasPages = std::max<std::size_t>(1, pagesFor(p.layer().selection.counts));
    Work work;
    loadBricks(engine, p, prepared.budgets.gpu, work);
    const auto chargedWith = [&](bool hits) {
        const std::size_t before = prepared.budgets.gpu.usedBytes();
        NativeCaster caster(p, engine, {true, hits, false}, prepared.budgets.gpu, nullptr);
        caster.begin(raysOf(p));
        return prepared.budgets.gpu.usedBytes() - before;
    };
    EXPECT_EQ(chargedWith(true), chargedWith(false) + sizeof(SurfaceHit) * rayCount(kSize));
}

TEST(NativeSurfacesOfNoise, PicturesAndHitsAreTheMirrors) {
    for (const bool volume : {false, true})
        for (const double step : {0.5, 3.0}) {
            const Stored stored([](const glm::dvec3& p) {
                const double x = std::sin(12.9898 * p.x + 78.233 * p.y + 37.719 * p.z) * 43758.5453;
                return 100 * (x - std::floor(x));
            });
            std::vector<Isosurface> surfaces;
            for (const double value : {10.0, 30.0, 31.0, 50.0, 50.0, 70.0, 90.0, 99.0})
                surfaces.push_back({value, {0.01 * value, 0.5, 1 - 0.01 * value}, 0.1});
            Scene s = stored.scene(surfaces, 0, 41);
            s.quality.stepVoxels = step;
            if (volume)
                s.volumes[0].transferFunction =
                    TransferFunction::fromOpacity({{20, 0}, {100, 0.2}}, {{0, {1, 0.5, 0.2}}}, 1);
            const auto prepared = stored.prepare(s);
            NativeChoices choices;
            choices.hits = true;
            for (const native::PacketTarget* target : nativeTargets()) {
                choices.target = target;
                const NativePicture picture = nativePicture(*prepared, choices);
                EXPECT_EQ(differing(picture.image, mirrorPicture(*prepared)), 0u) << target->name;
                EXPECT_TRUE(picture.hits == hitsOfMirror(prepared->p)) << target->name;
            }
        }
}

} // namespace
} // namespace tessera::test
