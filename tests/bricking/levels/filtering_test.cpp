// tests/bricking/levels/filtering_test.cpp: filtering before the transfer function must not lose thin
// structures. Tests how far it shifts a brick's mean colour (the biases), and that pixels then do not limit
// levels. Also bricks whose rays all missed their visible part.
#include "core/image/colour.h"
#include "tests/support/bricking_selection_tools.h"

#include <cmath>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using test::predictedOf;
using test::unitInfo;
using test::whiteAbove150;

constexpr double kOpaque = 10; // extinction per mm: nothing gets through a voxel

/// From so far that a pixel is as large as a brick.
ViewWeights fromFar(const VolumeInfo& info) {
    Camera camera;
    camera.projection = Projection::parallel;
    camera.parallelScale = 3200;
    ViewWeights w = viewWeights(camera, info, {200, 200});
    EXPECT_EQ(w.finest, std::vector<std::uint8_t>(w.finest.size(), kLevelCount - 1));
    return w;
}

// -- biases
// ------------------------------------------------------------------------------------------------------

/// A brick whose rays are dark at level 0 and bright at the coarser levels, or the other way round:
/// brighter(part, ray) tells.
template <typename Brighter> LevelErrors errorsOf(const Brighter& brighter) {
    const VolumeInfo info = unitInfo({32, 32, 32});
    BrickRays rays;
    rays.bricks = {1, 1, 1};
    rays.rowOf = {0};
    rays.rows = 1;
    rays.pages.emplace_back(BrickRays::kRowsPerPage * rays.rowBytes());
    for (int p = 0; p < kBrickRayParts; ++p) {
        BrickRayPart part;
        part.hi = 255;
        for (int ray = 0; ray < kRaysPerPart; ++ray)
            for (int j = 0; j < kSamplesPerRay; ++j)
                part.codes[static_cast<std::size_t>(kSamplesPerRay * ray + j)] =
                    brighter(p, ray) == (j >= kRaySamples[0]) ? 255 : 0;
        encode(part, std::span<std::uint8_t, kBrickRayBytes>(
                         rays.row(0).data() + static_cast<std::size_t>(p) * kBrickRayBytes, kBrickRayBytes));
    }
    const TransferTable table = makeTable(TransferFunction::fromExtinction(
        {{0, kOpaque}, {255, kOpaque}}, {{0, glm::dvec3(0.1)}, {255, glm::dvec3(0.9)}}));
    return rayErrors(rays, {1}, table, info);
}

TEST(LevelBiases, AreWhatIsLeftWhenAPixelAveragesTheRays) {
    const double step = luvFromLinear(glm::dvec3(0.9)).x - luvFromLinear(glm::dvec3(0.1)).x; // 58 of L*
    const auto expectBoth = [&](const LevelErrors& e, double bias) {
        for (std::size_t level = 1; level < kLevelCount; ++level) {
            EXPECT_NEAR(static_cast<double>(e.errors[0][level]), step, 0.01); // either way
            EXPECT_NEAR(static_cast<double>(e.biases[0][level]), bias, 0.01);
        }
        EXPECT_EQ(e.biases[0][0], 0);
    };
    expectBoth(errorsOf([](int, int) { return true; }), step);
    expectBoth(errorsOf([](int, int) { return false; }), step); // darker counts as brighter does
    expectBoth(errorsOf([](int part, int) { return part == 0; }), 0);
    // The extreme ray of one part against all others: a 32nd of the weight the other way, so 2/32 less.
    expectBoth(errorsOf([](int part, int ray) { return part == 0 && ray == kRayGroups; }), step * 30 / 32);
}

// -- what filtering loses
// ------------------------------------------------------------------------------------------------------

TEST(KeepWhatFilteringLoses, GoesDownToTheFirstLevelWithoutANoticeableShift) {
    const std::array<float, kLevelCount> biases = {0, 1, 2, 2.01f, 5, 9};
    const auto kept = [&](const std::array<float, kLevelCount>& b, std::uint8_t finest, float area = 1,
                          std::uint8_t shows = 1) {
        LevelErrors e;
        e.bricks = {1, 1, 1};
        e.shows = {shows};
        e.errors = {{0, 50, 50, 50, 50, 50}}; // errors that a pixel averages away count for nothing
        e.biases = {b};
        ViewWeights w;
        w.area = {area};
        w.finest = {finest};
        limitPrefilterLoss(e, w);
        return static_cast<int>(w.finest[0]);
    };
    EXPECT_EQ(kept(biases, 5), 2);
    EXPECT_EQ(kept(biases, 4), 2);
    EXPECT_EQ(kept(biases, 2), 2);
    EXPECT_EQ(kept(biases, 1), 1); // never coarser than a pixel shows
    EXPECT_EQ(kept(biases, 0), 0);
    EXPECT_EQ(kept({0, 9, 9, 9, 9, 9}, 5), 0);
    EXPECT_EQ(kept({0, 9, 1, 9, 9, 1}, 5), 5);
    EXPECT_EQ(kept({0, 9, 9, 9, 9, 9}, 5, 0), 5);    // out of sight
    EXPECT_EQ(kept({0, 9, 9, 9, 9, 9}, 5, 1, 0), 5); // shows nothing
    EXPECT_EQ(kept({}, 5), 5);
}

TEST(KeepWhatFilteringLoses, KeepsAThinBrightSheet) {
    // One voxel thick: half its value at level 1, and that shows nothing. The rays across it sample other
    // voxels (raySampleAt), so that the ray through the largest voxel alone meets it: a 32nd of the weight,
    // all white.
    const glm::ivec3 extent(32, 32, 32);
    const LevelErrors e = predictedOf(
        extent, [](int, int y, int) { return y == 18 ? 200 : 0; }, whiteAbove150(kOpaque));
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        EXPECT_NEAR(static_cast<double>(e.errors[0][level]), 100.0 / 32, 0.01);
        EXPECT_NEAR(static_cast<double>(e.biases[0][level]), 100.0 / 32, 0.01);
    }
    ViewWeights w = fromFar(unitInfo(extent));
    limitPrefilterLoss(e, w);
    EXPECT_EQ(w.finest[0], 0);
    const std::vector<float> mean(1);
    EXPECT_EQ(selectLevels(e, w, mean, 1).levels[0], 0);

    // One voxel on, rays across it meet it too: a third of all rays run across.
    const LevelErrors met = predictedOf(
        extent, [](int, int y, int) { return y == 19 ? 200 : 0; }, whiteAbove150(kOpaque));
    for (std::size_t level = 1; level < kLevelCount; ++level) {
        EXPECT_GT(met.biases[0][level], 25);
        EXPECT_LT(met.biases[0][level], 45);
    }
}

TEST(KeepWhatFilteringLoses, LeavesWhatFilteringKeeps) {
    // Homogeneous: every level is the same. The pixel's size decides.
    const glm::ivec3 extent(32, 32, 32);
    const LevelErrors e = predictedOf(
        extent, [](int, int, int) { return 200; }, whiteAbove150(kOpaque));
    EXPECT_EQ(e.biases[0], (std::array<float, kLevelCount>{}));
    ViewWeights w = fromFar(unitInfo(extent));
    limitPrefilterLoss(e, w);
    EXPECT_EQ(w.finest[0], kLevelCount - 1);
}

// -- rays that all missed
// ------------------------------------------------------------------------------------------------------

TEST(MissedByAllRays, ABrickThatShowsSomethingIsNotTakenForNothing) {
    // The first brick shows something by the layer around it alone; none of its own voxels does.
    const glm::ivec3 extent(96, 32, 32);
    const auto value = [](int x, int, int) { return x >= 32 && x < 64 ? 200 : 0; };
    for (const int parts : {1, 2}) {
        const LevelErrors e = predictedOf(extent, value, whiteAbove150(kOpaque), parts);
        EXPECT_EQ(e.shows, (std::vector<std::uint8_t>{1, 1, 1}));
        for (const std::size_t brick : {std::size_t{0}, std::size_t{2}}) {
            for (int level = 0; level < kLevelCount; ++level) {
                // One white ray of 12 or 24, at the coarsest level.
                const double expected = 100.0 / (12 * parts) * level / 5;
                const auto at = static_cast<std::size_t>(level);
                EXPECT_NEAR(static_cast<double>(e.errors[brick][at]), expected, 1e-5) << level;
                EXPECT_NEAR(static_cast<double>(e.biases[brick][at]), expected, 1e-5) << level;
            }
            EXPECT_NEAR(static_cast<double>(e.transmittances[brick]), 1, 1e-6);
        }
        EXPECT_NEAR(static_cast<double>(e.transmittances[1]), 0, 1e-6);
        ViewWeights w = fromFar(unitInfo(extent));
        limitPrefilterLoss(e, w);
        // 24 rays: 1.67 at level 2 is not noticeable, 2.5 at level 3 is; 12 rays: 1.67 at level 1 is not.
        EXPECT_EQ(w.finest[0], parts == 2 ? 2 : 1);
        const std::vector<float> means(3);
        EXPECT_EQ(selectLevels(e, w, means, 10).levels[0], w.finest[0]) << "it must be bought";
    }
}

TEST(MissedByAllRays, AreOnlyThoseThatShow) {
    const LevelErrors e = predictedOf(
        {64, 32, 32}, [](int x, int, int) { return x < 30 ? 200 : 0; }, whiteAbove150(kOpaque));
    EXPECT_EQ(e.shows, (std::vector<std::uint8_t>{1, 0}));
    EXPECT_EQ(e.errors[1], (std::array<float, kLevelCount>{}));
    EXPECT_EQ(e.biases[1], (std::array<float, kLevelCount>{}));
    EXPECT_EQ(e.transmittances[1], 1);
}

} // namespace
} // namespace tessera
