// Bricks of any mix of levels: the shader's field equals the mirror's. Values and gradients are continuous
// across faces, edges, corners, empty bricks and the volume's border, and no value leaves the hull of the
// samples. The contract's rows hold on pictures of mixed levels, outside and inside the volume.
#include "core/image/image_metrics.h"
#include "render/backends/gpu/probe.h"
#include "tests/support/lights.h"
#include "tests/support/mixed_fixture.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

/// Points at which formulas change: on and beside brick faces, at the ends of blends, at the border and
/// beyond it.
std::vector<glm::vec3> tellingPositions(const glm::ivec3& extent, int count) {
    std::mt19937 random(17);
    std::vector<glm::vec3> out;
    const auto along = [&](int axis) {
        std::uniform_real_distribution<float> anywhere(-2, static_cast<float>(extent[axis]) + 2);
        std::uniform_int_distribution<int> kind(0, 3), brick(0, extent[axis] / 32), level(0, 5), side(0, 1);
        const float face = static_cast<float>(32 * brick(random));
        const float half = std::ldexp(0.5f, level(random)) * (side(random) ? 1.0f : -1.0f);
        switch (kind(random)) {
        case 0:
            return face;
        case 1:
            return std::nextafter(face, -1e9f);
        case 2:
            return face + half;
        default:
            return anywhere(random);
        }
    };
    for (int i = 0; i < count; ++i)
        out.emplace_back(along(0), along(1), along(2));
    return out;
}

class MixedField : public testing::TestWithParam<std::tuple<const char*, EdgeFunction>> {};
INSTANTIATE_TEST_SUITE_P(Volumes, MixedField,
                         testing::Combine(testing::Values("torso", "sphere", "marschner-lobb"),
                                          testing::ValuesIn(kEdgeFunctions)),
                         [](const auto& info) {
                             std::string name = std::get<0>(info.param);
                             std::erase(name, '-');
                             return name + "_" +
                                    edgeFunctionNames()[static_cast<std::size_t>(std::get<1>(info.param))];
                         });

TEST_P(MixedField, ShaderEqualsItsTwin) {
    const GlContext context({"software"});
    const auto [store, edge] = GetParam();
    MixedScene scene(store, "auto", 0, edge);
    scene.choose(randomLevels(scene.p().layer().selection, 5, true));
    Planner& p = scene.p();
    MemoryBudget& gpu = scene.prepared->budgets.gpu;
    ASSERT_TRUE(p.layer().mixed());
    Work work;
    Atlas atlas(p.info(), p.layer().selection, pagesFor(p.layer().selection.counts), TextureLimits{}, gpu,
                scene.prepared->budgets.ram);
    atlas.bricks.load(*p.layer().cache, work);
    const LevelTextures textures(p.layer().levels, gpu);
    const FieldSource source{&atlas, 0, &p.layer().levels, &textures};
    std::uint32_t features = kFeatureMixed;
    if (texelFormat(p.info().type).normalised)
        features |= kFeatureNormalised;
    const auto positions = tellingPositions(p.info().extentVoxels, 6000);
    const auto exact = probeField(positions, features, p.info(), source, gpu);
    const auto filtered = probeField(positions, features | kFeatureHardware, p.info(), source, gpu);
    MixedReader samples(*p.layer().cache, p.info(), p.layer().selection, p.layer().levels);
    const float range = p.layer().statistics.highest - p.layer().statistics.lowest;
    float worst = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        ASSERT_EQ(exact[i].w, interblockValue(samples, positions[i])) << i;
        ASSERT_EQ(glm::vec3(exact[i]), interblockGradient(samples, positions[i])) << i;
        worst = std::max(worst, std::abs(filtered[i].w - exact[i].w));
    }
    EXPECT_LE(worst, 4e-4f * range); // llvmpipe's filter: see render_field_test.cpp
    for (const Gradient kind :
         {Gradient::forward, Gradient::sobel, Gradient::analytic, Gradient::centralHalf, Gradient::cubic}) {
        const auto probed = probeField(positions, features | gradientFeature(kind), p.info(), source, gpu);
        for (std::size_t i = 0; i < positions.size(); ++i)
            ASSERT_EQ(glm::vec3(probed[i]), interblockGradient(samples, positions[i], kind))
                << gradientNames()[static_cast<std::size_t>(kind)] << " " << i;
    }
}

// Both sides of every face, edge and corner, of borders to empty bricks and to the outside: values agree to
// 1e-6 of the range, and so do gradients. The nearest brick's own value is the one that jumps, by design.
TEST(MixedLevels, ValuesAndGradientsAreContinuous) {
    std::mt19937 random(23);
    std::uniform_real_distribution<double> unit(0, 1);
    int borders = 0, facesLit = 0;
    for (const char* store : {"torso", "marschner-lobb"})
        for (const EdgeFunction edge : {EdgeFunction::minimum, EdgeFunction::split, EdgeFunction::maximum})
            for (unsigned seed = 0; seed < 6; ++seed) {
                MixedScene scene(store, "auto", 0, edge);
                scene.choose(randomLevels(scene.p().layer().selection, seed, true));
                Planner& p = scene.p();
                MixedReader samples(*p.layer().cache, p.info(), p.layer().selection, p.layer().levels);
                const double range =
                    static_cast<double>(p.layer().statistics.highest) - p.layer().statistics.lowest;
                const glm::dvec3 extent(p.info().extentVoxels);
                for (int i = 0; i < 3000; ++i, ++borders) {
                    glm::dvec3 at = extent * glm::dvec3(unit(random), unit(random), unit(random));
                    const int axes = 1 + i % 3;
                    for (int a = 0; a < axes; ++a) {
                        // On a border of bricks, or where the nearest corner changes, half a brick further.
                        const int axis = (i + a) % 3;
                        at[axis] = 16.0 * std::round(at[axis] / 16);
                    }
                    glm::dvec3 side;
                    for (int axis = 0; axis < 3; ++axis)
                        side[axis] = unit(random) < 0.5 ? -1 : 1;
                    const double h = 1e-9;
                    const double jump =
                        interblockValue(samples, at + h * side) - interblockValue(samples, at - h * side);
                    ASSERT_LE(std::abs(jump), 1e-6 * range) << store << " seed " << seed;
                    // Light is taken where something shows: never in an empty brick.
                    const auto shows = [&](const glm::dvec3& place) {
                        const glm::ivec3 brick(glm::clamp(place, glm::dvec3(0), extent - 1e-6) / 32.0);
                        return !samples.isEmpty(brick);
                    };
                    const bool lit = shows(at + h * side) && shows(at - h * side);
                    for (const Gradient kind : {Gradient::central, Gradient::cubic}) {
                        if (kind == Gradient::cubic && !lit)
                            continue;
                        facesLit += kind == Gradient::cubic;
                        const glm::dvec3 turn = interblockGradient(samples, at + h * side, kind) -
                                                interblockGradient(samples, at - h * side, kind);
                        for (int axis = 0; axis < 3; ++axis)
                            ASSERT_LE(std::abs(turn[axis]), 1e-6 * range)
                                << store << " seed " << seed << " "
                                << gradientNames()[static_cast<std::size_t>(kind)];
                    }
                }
            }
    EXPECT_GE(borders, 100000);
    EXPECT_GE(facesLit, 20000);
}

// A field that jumps must be caught by the test above: the nearest brick alone does.
TEST(MixedLevels, NearestBrickJumpsAtBorders) {
    MixedScene scene("marschner-lobb", "auto", 0, EdgeFunction::nearest);
    scene.choose(randomLevels(scene.p().layer().selection, 1, false));
    Planner& p = scene.p();
    MixedReader samples(*p.layer().cache, p.info(), p.layer().selection, p.layer().levels);
    const double range = static_cast<double>(p.layer().statistics.highest) - p.layer().statistics.lowest;
    double worst = 0;
    for (int y = 1; y < 60; ++y)
        for (int z = 1; z < 60; ++z) {
            const glm::dvec3 at(32, y, z), h(1e-9, 0, 0);
            worst = std::max(worst,
                             std::abs(interblockValue(samples, at + h) - interblockValue(samples, at - h)));
        }
    EXPECT_GT(worst, 0.01 * range);
}

// Within the hull of the samples of the eight bricks around, everywhere.
TEST(MixedLevels, ValuesStayInTheHullOfTheirSamples) {
    std::mt19937 random(29);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const EdgeFunction edge : kEdgeFunctions) {
        MixedScene scene("marschner-lobb", "auto", 0, edge);
        scene.choose(randomLevels(scene.p().layer().selection, 3, true));
        Planner& p = scene.p();
        MixedReader samples(*p.layer().cache, p.info(), p.layer().selection, p.layer().levels);
        const glm::dvec3 extent(p.info().extentVoxels);
        const double range = static_cast<double>(p.layer().statistics.highest) - p.layer().statistics.lowest;
        for (int i = 0; i < 4000; ++i) {
            const glm::dvec3 at = extent * glm::dvec3(unit(random), unit(random), unit(random));
            const auto place = cornerPlace(at, extent, p.layer().levels.bricks);
            double lo = INFINITY, hi = -INFINITY;
            for (int n = 0; n < 8; ++n) {
                const glm::ivec3 brick = place.corner - 1 + glm::ivec3(n & 1, (n >> 1) & 1, n >> 2);
                const std::uint32_t code = p.layer().levels.at(place.corner).code(n);
                if (code == BrickCorner::kOutside)
                    continue;
                // The brick's samples around its nearest point; testing all of it is too slow.
                const double value = brickValue(samples, brick, code, at);
                lo = std::min(lo, value);
                hi = std::max(hi, value);
            }
            const double value = interblockValue(samples, at);
            if (p.layer().levels.at(place.corner).agree())
                continue; // plain trilinear: its eight samples, tested elsewhere
            ASSERT_GE(value, lo - 1e-9 * range);
            ASSERT_LE(value, hi + 1e-9 * range);
        }
    }
}

// One level for all: the general path gives what the plain one gives.
TEST(MixedLevels, OneLevelIsPlainTrilinear) {
    std::mt19937 random(31);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int level = 0; level < kLevelCount - 1; ++level)
        for (const EdgeFunction edge : {EdgeFunction::minimum, EdgeFunction::split, EdgeFunction::maximum}) {
            MixedScene scene("torso", "bone-1", 0, edge);
            Planner& p = scene.p();
            Selection s = p.layer().selection; // some empty
            for (std::uint8_t& mine : s.levels)
                if (mine != Selection::kEmpty)
                    mine = static_cast<std::uint8_t>(level);
            std::swap(s.counts[0], s.counts[static_cast<std::size_t>(level)]);
            const LevelMap map =
                makeLevelMap(s, p.info().extentVoxels, p.view.quality, scene.prepared->budgets.ram);
            MixedReader mixed(*p.layer().cache, p.info(), s, map);
            LatticeReader plain(*p.layer().cache, p.info(), level, &s);
            for (int i = 0; i < 2000; ++i) {
                const glm::dvec3 at =
                    glm::dvec3(p.info().extentVoxels) * glm::dvec3(unit(random), unit(random), unit(random));
                ASSERT_EQ(interblockValue(mixed, at), fieldValue(plain, at, 1.0 / (1 << level)));
            }
        }
}

// Skipping's proof: wherever the map says empty, the table's extinction is zero.
TEST(MixedLevels, EmptyCellsShowNothing) {
    std::mt19937 random(37);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const char* store : {"torso", "abdomen"}) {
        if (!std::filesystem::exists(storePath(store)))
            continue;
        for (const EdgeFunction edge : kEdgeFunctions) {
            MixedScene scene(store, "bone-1", 0, edge);
            scene.choose(randomShownLevels(scene.p().layer().selection, 7));
            Planner& p = scene.p();
            MixedReader samples(*p.layer().cache, p.info(), p.layer().selection, p.layer().levels);
            int checked = 0;
            for (int i = 0; i < 100000; ++i) {
                const glm::dvec3 at =
                    glm::dvec3(p.info().extentVoxels) * glm::dvec3(unit(random), unit(random), unit(random));
                if (!p.layer().occupancy.isEmpty(
                        glm::min(glm::ivec3(at) / kCellExtent, p.layer().statistics.cells - 1)))
                    continue;
                ++checked;
                ASSERT_EQ(lookUp(p.layer().optics, interblockValue(samples, at)).a, 0)
                    << store << " " << at.x << " " << at.y << " " << at.z;
            }
            EXPECT_GT(checked, 1000);
        }
    }
}

struct PictureCase {
    const char* store;
    const char* preset;
    int camera;
    EdgeFunction edge;
    Sampling sampling;
    Integrator integrator = Integrator::midpoint;
};
class MixedPicture : public testing::TestWithParam<PictureCase> {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(storePath(GetParam().store)))
            GTEST_SKIP() << GetParam().store << " is absent: the real scans are not on this machine";
    }
};
INSTANTIATE_TEST_SUITE_P(
    Scenes, MixedPicture,
    testing::Values(
        PictureCase{"torso", "bone-1", 0, EdgeFunction::minimum, Sampling::limited},
        PictureCase{"torso", "soft-tissue", 2, EdgeFunction::maximum, Sampling::limited},
        PictureCase{"torso", "soft-tissue", 1, EdgeFunction::split, Sampling::naive},
        PictureCase{"abdomen", "bone-1", 0, EdgeFunction::maximum, Sampling::full},
        PictureCase{"abdomen", "soft-tissue", 2, EdgeFunction::minimum, Sampling::limited},
        PictureCase{"head", "skin-1", 1, EdgeFunction::nearest, Sampling::limited},
        PictureCase{"torso", "soft-tissue", 2, EdgeFunction::split, Sampling::limited, Integrator::linear},
        PictureCase{"torso", "bone-1", 0, EdgeFunction::split, Sampling::limited, Integrator::preintegrated},
        PictureCase{"abdomen", "soft-tissue", 1, EdgeFunction::maximum, Sampling::naive,
                    Integrator::preintegrated},
        PictureCase{"head", "skin-1", 0, EdgeFunction::minimum, Sampling::full, Integrator::preintegrated2d},
        PictureCase{"abdomen", "bone-1", 2, EdgeFunction::split, Sampling::limited,
                    Integrator::preintegrated2d}));

// The contract's rows on one mixed selection: skipping, tiles and resuming change no bit; the GPU ray caster
// equals the mirror.
TEST_P(MixedPicture, ContractHolds) {
    const GlContext context({"software"});
    const PictureCase c = GetParam();
    MixedScene scene(c.store, c.preset, c.camera, c.edge, c.sampling, {32, 32}, c.integrator);
    scene.choose(randomShownLevels(scene.p().layer().selection, 7));
    Planner& p = scene.p();
    ASSERT_TRUE(p.layer().mixed());
    if (c.camera == 2)
        lightPlanWithAll(p);
    const std::uint32_t features = kFeatureSkipping | kFeatureShading;
    const GpuPicture whole = marchOn(*scene.prepared, features);
    EXPECT_FALSE(isBlank(whole.image));
    const GpuPicture everyStride = marchOn(*scene.prepared, features & ~kFeatureSkipping);
    EXPECT_TRUE(bitEqual(whole.image, everyStride.image)) << "skipping changed the picture";
    EXPECT_LE(whole.work.segments, everyStride.work.segments);
    Slicing shreds;
    shreds.fixedTile = 24;
    shreds.fixedIterations = 7;
    EXPECT_TRUE(bitEqual(whole.image, marchOn(*scene.prepared, features, shreds).image));
    // As long as a dispatch can be: the device's own limit on loops must not show.
    Slicing endless;
    endless.fixedTile = 32;
    endless.fixedIterations = 1 << 20;
    EXPECT_TRUE(bitEqual(whole.image, marchOn(*scene.prepared, features & ~kFeatureSkipping, endless).image));

    const std::vector<SegmentedRay<float>> rays = gpuRays(p.view.frame, scene.prepared->budgets.gpu);
    Work work;
    const auto mirror = mirrorRays<float>(
        mirrorInput(p, true), rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
    EXPECT_EQ(work.segments, whole.work.segments) << "march and mirror took different strides";
    double worst = 0;
    for (std::size_t i = 0; i < rays.size(); ++i)
        for (int channel = 0; channel < 4; ++channel)
            worst = std::max(worst, std::abs(static_cast<double>(whole.image.pixels[i][channel]) -
                                             static_cast<double>(mirror[i][channel])));
    EXPECT_LE(worst, 1e-5) << "same operations in the same order: what remains is the driver's square root";
}

// A step that is set when levels are there is walked as one that was planned: rays, strides, and the tables
// of their colours.
TEST(MixedLevels, AStepThatIsSetIsAsIfItWerePlanned) {
    const double before = 0.5, after = 4;
    std::vector<glm::vec4> pictures[2];
    Work works[2];
    for (const bool set : {false, true}) {
        MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
        Scene scene = sceneOn(StoreReader(storePath("torso"), ram).info(), "soft-tissue", 0, {16, 16});
        scene.quality.integrator = Integrator::preintegrated2d;
        scene.quality.stepVoxels = set ? before : after;
        Prepared prepared("torso", scene);
        Planner& p = prepared.p;
        p.setSelection(randomShownLevels(p.layer().selection, 7));
        if (set)
            p.setStep(after);
        pictures[set] =
            mirrorRays<float>(mirrorInput(p, true), 256, frameRays(cast<float>(p.view.frame)), 0, works[set]);
    }
    EXPECT_EQ(pictures[0], pictures[1]);
    EXPECT_EQ(works[0].segments, works[1].segments);
}

// A camera inside at 130 degrees, exactly on a face, an edge and a corner of bricks, looking along an axis
// and obliquely. The same rows hold across borders of levels.
TEST(MixedLevels, CamerasOnFacesEdgesAndCorners) {
    const GlContext context({"software"});
    for (const glm::dvec3& at :
         {glm::dvec3(64, 50.3, 47.9), glm::dvec3(64, 32, 47.9), glm::dvec3(64, 32, 96)})
        for (const glm::dvec3& along : {glm::dvec3(0, 1, 0), glm::dvec3(0.3, 0.8, -0.5)}) {
            SCOPED_TRACE(testing::Message() << at.x << " " << at.y << " " << at.z << ", " << along.x);
            MemoryBudget ram("RAM", "--ram", std::size_t{64} << 20);
            const VolumeInfo info = StoreReader(storePath("torso"), ram).info();
            Scene scene = sceneOn(info, "soft-tissue", 0, {24, 24});
            Camera camera;
            camera.position = glm::dvec3(info.patientFromVoxel * glm::dvec4(at, 1));
            camera.focalPoint = glm::dvec3(info.patientFromVoxel * glm::dvec4(at + 40.0 * along, 1));
            camera.viewAngle = 130;
            scene.camera = camera;
            Prepared prepared("torso", scene);
            Planner& p = prepared.p;
            p.setSelection(randomShownLevels(p.layer().selection, 11));
            const std::uint32_t features = kFeatureSkipping | kFeatureShading;
            const GpuPicture picture = marchOn(prepared, features);
            EXPECT_FALSE(isBlank(picture.image));
            EXPECT_TRUE(bitEqual(picture.image, marchOn(prepared, features & ~kFeatureSkipping).image));
            const std::vector<SegmentedRay<float>> rays = gpuRays(p.view.frame, prepared.budgets.gpu);
            Work work;
            const auto mirror = mirrorRays<float>(
                mirrorInput(p, true), rays.size(), [&](std::size_t i) { return rays[i]; }, 0, work);
            EXPECT_EQ(work.segments, picture.work.segments);
            for (std::size_t i = 0; i < rays.size(); ++i)
                for (int channel = 0; channel < 4; ++channel)
                    ASSERT_NEAR(picture.image.pixels[i][channel], mirror[i][channel], 1e-5f) << i;
        }
}

} // namespace
} // namespace tessera
