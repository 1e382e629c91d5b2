// Pictures by paths of light: engines' bits, what they have in common with other pictures, and what is
// refused.
#include "core/base/error.h"
#include "tests/support/path_scenes.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;
using namespace tessera::test::path_scenes;
using ::testing::HasSubstr;

TEST(PathPicture, NativeHasTheMirrorsBits) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    int number = 0;
    for (const Scene& scene : manyScenes(torso, labels)) {
        SCOPED_TRACE("scene " + std::to_string(number++));
        const RenderResult mirror = torso.draw(scene, EngineKind::mirror);
        EXPECT_FALSE(isBlank(mirror.image));
        EXPECT_GT(mirror.work.paths.paths, 0u);
        for (const int threads : {1, 2}) {
            const RenderResult native = torso.draw(scene, EngineKind::native, threads);
            EXPECT_EQ(native.bricksOfLevel, mirror.bricksOfLevel);
            EXPECT_EQ(differing(native.image, mirror.image), 0u);
            EXPECT_EQ(native.work.paths.lookUps, mirror.work.paths.lookUps);
            EXPECT_EQ(native.work.paths.paths, mirror.work.paths.paths);
            EXPECT_EQ(native.work.paths.alone, 0u) << "slow";
        }
    }
}

/// By lanes of every set of instructions that the processor has.
TEST(PathPicture, HasTheSameBitsWithEveryInstructionSet) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    const Scene scene = labelledScene(torso, labels, LabelLook::solid, true);
    const Image mirror = torso.draw(scene, EngineKind::mirror).image;
    for (const native::PacketTarget* target : nativeTargets()) {
        ASSERT_EQ(setenv("TESSERA_INSTRUCTIONS", target->name, 1), 0);
        EXPECT_EQ(differing(torso.draw(scene, EngineKind::native).image, mirror), 0u) << target->name;
    }
    unsetenv("TESSERA_INSTRUCTIONS");
}

/// What lanes do not know goes one by one, and is told.
TEST(PathPicture, TellsWhatGoesOneByOne) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    Scene linear = lit(torso.scene("bone-1")), analytic = linear, response = linear;
    linear.quality.integrator = Integrator::linear;
    analytic.shading.gradient = Gradient::analytic;
    response.lighting.transport = Transport{TransportResponse::contract};
    response.lighting.environment.reset();
    Scene cut = response;
    cut.cuts = cutScene(torso, labels, true).cuts;
    for (const Scene& scene : {linear, analytic, response, cut}) {
        const RenderResult native = torso.draw(scene, EngineKind::native);
        EXPECT_GT(native.work.paths.paths, 0u);
        EXPECT_EQ(native.work.paths.alone, native.work.paths.paths);
        EXPECT_EQ(differing(native.image, torso.draw(scene, EngineKind::mirror).image), 0u);
    }
}

/// Smooth normals are those that Sobel's operator gives shading; opacity by gradient keeps that of shading.
TEST(PathPicture, ScattersBySmoothNormals) {
    Torso torso;
    Scene own = lit(torso.scene("bone-1", 1, {16, 12}), 2);
    own.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
    Scene smooth = own, graded = own;
    own.shading.gradient = Gradient::sobel;
    smooth.lighting.transport->normals = ScatteringNormals::sobel;
    grade(graded);
    Scene gradedSmooth = graded;
    gradedSmooth.lighting.transport->normals = ScatteringNormals::sobel;
    for (const EngineKind engine : {EngineKind::mirror, EngineKind::native, EngineKind::reference}) {
        SCOPED_TRACE(static_cast<int>(engine));
        EXPECT_EQ(differing(torso.draw(smooth, engine).image, torso.draw(own, engine).image), 0u);
        const Image other = torso.draw(gradedSmooth, engine).image, plain = torso.draw(graded, engine).image;
        EXPECT_GT(differing(other, plain), 0u) << "nothing is tested";
        for (std::size_t n = 0; n < other.pixels.size(); ++n)
            ASSERT_EQ(other.pixels[n].a, plain.pixels[n].a);
    }
}

/// Tissue of all values scatters as a scene whose own phase function and finish are the tissue's: from the
/// first scattering on, which rays begin, to the last.
TEST(PathPicture, TissueOfAllValuesIsTheScenesOwn) {
    Torso torso;
    const Phase phase{PhaseKind::henyeyGreenstein, 0.8};
    const SurfaceFinish finish{0.6, 0.4};
    for (const int bounces : {1, 3}) {
        auto function = TransferFunction::fromExtinction({{-300, 0}, {200, 0.03}, {1500, 0.3}},
                                                         {{-300, {0.9, 0.3, 0.2}}, {800, {0.9, 0.9, 0.7}}});
        Scene without = lit(torso.scene("bone-1", 1, {16, 12}), bounces);
        without.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
        without.lighting.transport->colours = TransportColours::reflectance;
        without.volumes[0].transferFunction = function;
        Scene own = without, other = without;
        own.lighting.transport->phase = phase;
        own.lighting.transport->surface->finish = finish;
        function.setTissues({{-5000, 50000, phase, finish}});
        other.volumes[0].transferFunction = function;
        for (const EngineKind engine : {EngineKind::mirror, EngineKind::native, EngineKind::reference}) {
            SCOPED_TRACE(static_cast<int>(engine));
            const Image image = torso.draw(own, engine).image;
            EXPECT_EQ(differing(torso.draw(other, engine).image, image), 0u);
            EXPECT_GT(differing(torso.draw(without, engine).image, image), 0u) << "nothing is tested";
        }
    }
}

/// Of themselves, they go side by side, whatever the transfer function.
TEST(PathPicture, TakesTheMidpointRuleWhereNoneIsNamed) {
    Torso torso;
    Scene scene = lit(torso.scene("bone-1"));
    scene.quality.integrator = Integrator::automatic;
    scene.volumes[0].transferFunction =
        TransferFunction::fromOpacity({{199, 0}, {200, 0.5}, {201, 0}}, {{0, glm::dvec3(0.8)}}, 0.01);
    const RenderResult paths = torso.draw(scene, EngineKind::native);
    EXPECT_EQ(paths.integrator, Integrator::midpoint);
    EXPECT_EQ(paths.work.paths.alone, 0u);
    scene.lighting = {};
    EXPECT_NE(torso.draw(scene, EngineKind::native).integrator, Integrator::midpoint) << "nothing is tested";
}

/// Behind a shell, tissue whose gradient opacity is nothing adds segments of no opacity.
TEST(PathPicture, EndsWhereOpacityIsNothing) {
    Torso torso;
    Scene scene = lit(torso.scene("soft-tissue"));
    TransferFunction function =
        TransferFunction::fromOpacity({{-800, 0.5}, {2000, 0.9}}, {{0, glm::dvec3(0.8)}}, 1);
    function.setGradientOpacity(GradientOpacity::fromPoints({{0, 0}, {200, 0}, {200.5, 1}}));
    scene.volumes[0].transferFunction = function;
    const Image native = torso.draw(scene, EngineKind::native).image;
    for (const glm::vec4& pixel : native.pixels)
        for (int c = 0; c < 4; ++c)
            ASSERT_TRUE(std::isfinite(pixel[c]));
    EXPECT_EQ(differing(native, torso.draw(scene, EngineKind::mirror).image), 0u);
}

TEST(PathPicture, NativeHasTheMirrorsBitsWhereLevelsMix) {
    Torso torso;
    const BallsOfLabels labels(torso.reader.info());
    const std::size_t small = std::size_t{3} << 20;
    Scene graded = lit(torso.scene("bone-1"));
    grade(graded);
    Scene smooth = graded;
    smooth.lighting.transport->surface = SurfaceScattering{{20, 150}, {}};
    smooth.lighting.transport->normals = ScatteringNormals::sobel;
    for (const Scene& scene : {lit(torso.scene("bone-1")), graded, cutScene(torso, labels, true), smooth}) {
        const RenderResult native = torso.draw(scene, EngineKind::native, 2, small);
        std::size_t levels = 0;
        for (const std::size_t bricks : native.bricksOfLevel)
            levels += bricks > 0;
        EXPECT_GT(levels, 2u) << "nothing is tested";
        EXPECT_EQ(native.work.paths.alone, 0u);
        EXPECT_EQ(differing(native.image, torso.draw(scene, EngineKind::mirror, 2, small).image), 0u);
    }
}

TEST(PathPicture, IsTheSameWithoutSkipping) {
    Torso torso;
    Scene scene = lit(torso.scene("bone-1"));
    const Image leaping = torso.draw(scene, EngineKind::native).image;
    scene.quality.skipping = false;
    EXPECT_EQ(differing(torso.draw(scene, EngineKind::native).image, leaping), 0u);
}

/// Rays see what they saw: alpha has no noise.
TEST(PathPicture, HasTheOpacityOfThePictureWithoutLight) {
    Torso torso;
    const Scene scene = lit(torso.scene("soft-tissue"));
    Scene plain = scene;
    plain.lighting = {};
    plain.shading.on = false;
    const Image paths = torso.draw(scene, EngineKind::native).image,
                unlit = torso.draw(plain, EngineKind::native).image;
    for (std::size_t n = 0; n < paths.pixels.size(); ++n)
        ASSERT_EQ(paths.pixels[n].a, unlit.pixels[n].a);
}

/// No point has an extinction beyond its bounds, whatever levels meet there.
TEST(ExtinctionBoundsOfScenes, HoldEveryPoint) {
    for (const EdgeFunction edge : kEdgeFunctions)
        for (const std::string preset : {"bone-1", "soft-tissue"}) {
            MixedScene mixed("torso", preset, 0, edge);
            Planner& p = mixed.p();
            for (const bool mixes : {false, true}) {
                if (mixes)
                    mixed.choose(randomLevels(p.layer().selection, 7, true));
                const Layer& layer = p.layer();
                MemoryBudget& ram = mixed.prepared->budgets.ram;
                const OccupancyInput volume{layer.statistics, layer.table, p.info(), layer.selection, edge};
                ExtinctionBounds bounds(volume, layer.optics, 1e6f, ram);
                bounds.refine(volume, layer.optics, *layer.cache, ram);
                EXPECT_LE(bounds.usedBytes(),
                          ExtinctionBounds::bytes(p.info().extentVoxels, layer.optics.table.size()));
                std::mt19937 random(11);
                const MirrorInput input = mirrorInput(p, false);
                std::size_t outside = 0, positive = 0;
                withCacheField<float>(
                    *input.cache, *input.info, *input.selection, input.levels, Gradient::central,
                    [&](auto& field) {
                        for (int n = 0; n < 40000; ++n) {
                            glm::vec3 at;
                            for (int axis = 0; axis < 3; ++axis)
                                at[axis] = std::uniform_real_distribution<float>(
                                    0, static_cast<float>(p.info().extentVoxels[axis]))(random);
                            const float extinction = lookUp(layer.optics, field.value(at)).a;
                            const ExtinctionRange range = bounds.at(glm::ivec3(at)).range;
                            outside += extinction > range.most || extinction < range.least;
                            positive += extinction > 0;
                        }
                    });
                EXPECT_EQ(outside, 0u) << preset << " " << static_cast<int>(edge) << mixes;
                EXPECT_GT(positive, 100u);
            }
        }
}

/// White tissue that light hardly leaves, a lamp inside it, much forward scattering, a glow everywhere.
TEST(PathPicture, EndsInBadScenes) {
    Torso torso;
    const glm::dvec3 inside(torso.reader.info().patientFromVoxel *
                            glm::dvec4(0.5 * glm::dvec3(torso.reader.info().extentVoxels), 1));
    for (const double opacity : {1e-6, 0.5, 0.9999999}) {
        Scene scene = lit(torso.scene("bone-1", 0, {16, 12}), 256);
        TransferFunction function =
            TransferFunction::fromOpacity({{-2000, opacity}, {3000, opacity}}, {{0, glm::dvec3(1)}}, 1);
        Material glow;
        glow.from = -3000, glow.to = 30000;
        glow.emission = {1, 1, 1};
        function.setMaterials({glow});
        scene.volumes[0].transferFunction = function;
        Light lamp;
        lamp.kind = LightKind::point;
        lamp.frame = LightFrame::patient;
        lamp.position = inside;
        scene.lighting.lights = {lamp};
        scene.lighting.transport->phase.g = 0.99;
        scene.lighting.transport->surface = SurfaceScattering{{1, 2}, 1, 0.05};
        const RenderResult result = torso.draw(scene, EngineKind::native);
        EXPECT_GT(result.work.paths.paths, 0u);
        EXPECT_LT(result.work.paths.lookUps, 20000 * result.work.paths.paths);
        for (const glm::vec4& pixel : result.image.pixels)
            for (int c = 0; c < 4; ++c)
                ASSERT_TRUE(std::isfinite(pixel[c]) && pixel[c] >= 0);
    }
}

TEST(PathPicture, CostsNothingWithoutATransport) {
    Torso torso;
    const RenderResult plain = torso.draw(torso.scene("bone-1"), EngineKind::native);
    EXPECT_EQ(plain.work.paths.paths, 0u);
    MemoryBudget ram("RAM", "--ram", std::size_t{256} << 20),
        gpu("GPU memory", "--gpu-memory", std::size_t{64} << 20);
    const Planner p = planScene(torso.scene("bone-1"), torso.reader, {}, {ram, gpu, 0});
    EXPECT_FALSE(p.layer().extinction.exists());
}

TEST(PathPicture, RefusesWhatIsNotThere) {
    Torso torso;
    const Scene scene = lit(torso.scene("bone-1"));
    Scene other = scene;
    other.mode = Mode::maximum; // has no light
    EXPECT_EQ(torso.draw(other, EngineKind::native).work.paths.paths, 0u);
    other = scene;
    other.quality.maxError = 3;
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected no error bound"));
    other = scene;
    other.quality.pixels.samples = PixelSampling::kAutomatic;
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected a number of samples"));
    other = scene;
    other.lighting.environment.reset();
    other.lighting.transport->response = TransportResponse::contract;
    other.lighting.occlusion = Occlusion{OcclusionMethod::rejecting};
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected occlusion of method local"));
    other.lighting.occlusion = Occlusion{.directions = OcclusionDirections::hemisphere};
    EXPECT_THAT(refused(other), HasSubstr("directions sphere"));
    other.lighting.occlusion.reset();
    other.shading.on = false;
    EXPECT_THAT(refused(other), HasSubstr("lighting.transport: expected shading"));
    other = scene;
    other.lighting.environment->file.path = "unread.exr"; // as a path's keyframes have it
    EXPECT_THAT(refused(other), HasSubstr("unread.exr: expected a file of the scene's own lighting"));
}

} // namespace
} // namespace tessera
