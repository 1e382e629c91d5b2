// tests/render/plan/planned_numbers_test.cpp: numbers of a plan that follow from its inputs: lattices and
// memory of several volumes, summaries, thresholds of integrators and levels, cameras of turntables.
#include "core/base/error.h"
#include "render/contract/ray_state.h"
#include "render/plan/choose_integrator.h"
#include "render/plan/framing.h"
#include "render/plan/fusion.h"
#include "render/plan/layer_labels.h"
#include "tests/support/surface_fixture.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <utility>
#include <vector>

namespace tessera::test {
namespace {

VolumeInfo lying(const glm::ivec3& extent, const glm::dvec3& corner, const glm::dvec3& spacing) {
    VolumeInfo info;
    info.extentVoxels = extent;
    info.patientFromVoxel = glm::dmat4(spacing.x, 0, 0, 0, 0, spacing.y, 0, 0, 0, 0, spacing.z, 0, corner.x,
                                       corner.y, corner.z, 1);
    return info;
}

// Whole voxels of the finest volume around all; of equally fine ones the first's.
TEST(FusedLattices, HoldAllVolumesInVoxelsOfTheFinest) {
    const VolumeInfo fine = lying({10, 20, 30}, {5, -7, 11}, {1, 1, 0.5});
    const VolumeInfo coarse = lying({4, 5, 6}, {1.5, -4, 20}, {2, 3, 1.5});
    const auto of = [](const VolumeInfo& a, const VolumeInfo& b) {
        const VolumeInfo* const both[] = {&a, &b};
        return fusedLattice(both);
    };
    // In voxels of the fine one, the other goes from (-3.5, 3, 18) to (4.5, 18, 36).
    for (const VolumeInfo& lattice : {of(fine, coarse), of(coarse, fine)}) {
        EXPECT_EQ(lattice.extentVoxels, glm::ivec3(14, 20, 36));
        EXPECT_EQ(glm::dvec3(lattice.patientFromVoxel[3]), glm::dvec3(1, -7, 11));
        EXPECT_EQ(glm::dmat3(lattice.patientFromVoxel), glm::dmat3(fine.patientFromVoxel));
    }
    // What lies within counts for nothing, nor does rounding of equal grids.
    const VolumeInfo within = lying({2, 2, 2}, {7, -3, 13}, {2, 3, 1.5});
    EXPECT_EQ(of(fine, within).extentVoxels, fine.extentVoxels);
    VolumeInfo nearly = fine;
    nearly.patientFromVoxel[3] += glm::dvec4(4e-7, -4e-7, 4e-8, 0);
    EXPECT_EQ(of(fine, nearly).extentVoxels, fine.extentVoxels);
    EXPECT_EQ(of(fine, nearly).patientFromVoxel, fine.patientFromVoxel);
    nearly.patientFromVoxel[3].x += 1e-3;
    EXPECT_EQ(of(fine, nearly).extentVoxels, glm::ivec3(11, 20, 30));
    // A reflected one of equal voxels: the first's axes.
    const VolumeInfo mirrored = lying({10, 20, 30}, {15, -7, 11}, {-1, 1, 0.5});
    EXPECT_EQ(of(fine, mirrored).patientFromVoxel, fine.patientFromVoxel);
    EXPECT_EQ(of(mirrored, fine).patientFromVoxel, mirrored.patientFromVoxel);
    EXPECT_EQ(of(mirrored, fine).extentVoxels, fine.extentVoxels);
    // 2^24 voxels along an axis are too many, one less is not.
    const double most = 1 << 24;
    const VolumeInfo far = lying({1, 1, 1}, {5 + most - 2, -7, 11}, {1, 1, 1});
    EXPECT_EQ(of(fine, far).extentVoxels.x, (1 << 24) - 1);
    EXPECT_THROW(of(fine, lying({1, 1, 1}, {5 + most - 1, -7, 11}, {1, 1, 1})), InputError);
    EXPECT_THROW(of(fine, lying({1, 1, 1}, {5, -7, 11 + most / 2}, {1, 1, 1})), InputError);
}

TEST(FusedPlans, ShareBudgetsByNeedsAndSizes) {
    // Of what the least needs leave, a quarter is shared evenly, the rest by size.
    const Stored small([](const glm::dvec3&p) { return p.x; }, {40, 33, 20}, true, 1, ValueType::i16),
        large([](const glm::dvec3&p) { return p.y; }, {50, 44, 70}, true);
    Scene scene = small.scene({}, 0, 20);
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0, 0.01}, {100, 0.1}}, {});
    scene.volumes.push_back(scene.volumes[0]);
    const double sizes[] = {40.0 * 33 * 20 * 2, 50.0 * 44 * 70 * 4};
    for (const bool turned : {false, true}) {
        Budgets budgets;
        const StoreReader a(turned ? large.folder / "v.zarr" : small.folder / "v.zarr", budgets.ram);
        const StoreReader b(turned ? small.folder / "v.zarr" : large.folder / "v.zarr", budgets.ram);
        const StoreReader* const both[] = {&a, &b};
        const std::size_t ram = budgets.ram.freeBytes(), gpu = budgets.gpu.freeBytes();
        const Planner p = planScene(scene, both, TextureLimits{}, {budgets.ram, budgets.gpu, 1},
                                    LevelChoice::oneForAll, kPictureBytesPerPixel);
        ASSERT_EQ(p.further.size(), 1u);
        const double part = 0.25 / 2 + 0.75 * sizes[turned ? 0 : 1] / (sizes[0] + sizes[1]);
        const std::size_t first = renderFloorBytes(a.info(), scene.imageSize, kPictureBytesPerPixel, 1,
                                                   scene.quality.integrator),
                          second =
                              renderFloorBytes(b.info(), scene.imageSize, 0, 1, scene.quality.integrator),
                          rays = placedRaysBytes(scene.imageSize);
        EXPECT_NEAR(static_cast<double>(p.further[0].ram.limitBytes()),
                    static_cast<double>(second) + part * static_cast<double>(ram - first - second), 1);
        EXPECT_NEAR(static_cast<double>(p.further[0].gpu.limitBytes()),
                    static_cast<double>(rays) + part * static_cast<double>(gpu - 2 * rays), 1);
    }
}

// A stride of several volumes is as long as a sample of the finest level of any, and at most half a brick.
TEST(FusedPlans, StridesAreSamplesOfTheFinest) {
    const Stored stored([](const glm::dvec3& p) { return p.x; }, {64, 64, 64}, true);
    Scene scene = stored.scene({}, 0, 20);
    scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{-1, 0.01}, {100, 0.1}}, {});
    scene.volumes.push_back(scene.volumes[0]);
    Budgets budgets;
    const StoreReader store(stored.folder / "v.zarr", budgets.ram);
    const StoreReader* const both[] = {&store, &store};
    Planner p = planScene(scene, both, TextureLimits{}, {budgets.ram, budgets.gpu, 1}, LevelChoice::oneForAll,
                          kPictureBytesPerPixel);
    const auto at = [&](int first, int second, double step) {
        const auto levels = [](Planner& plan, int level) {
            Selection s = plan.layer().selection;
            s.counts = {};
            for (std::uint8_t& mine : s.levels)
                mine = static_cast<std::uint8_t>(level);
            s.counts[static_cast<std::size_t>(level)] = s.levels.size();
            plan.setSelection(std::move(s));
        };
        levels(p, first);
        levels(p.further[0].plan, second);
        p.view.quality.stepVoxels = step;
        return fusedSegments(p);
    };
    EXPECT_EQ(at(0, 0, 1), 1);
    EXPECT_EQ(at(1, 0, 1), 1);
    EXPECT_EQ(at(1, 2, 1), 2);
    EXPECT_EQ(at(3, 2, 1), 4);
    EXPECT_EQ(at(5, 4, 1), 16);
    EXPECT_EQ(at(5, 5, 1), 16);
    EXPECT_EQ(at(5, 5, 0.5), 32);
    EXPECT_EQ(at(5, 5, 4), 4);
    EXPECT_EQ(at(5, 5, 4.01), 2);
}

TEST(Summaries, AreInPhysicalValues) {
    Statistics statistics;
    statistics.lowest = -20, statistics.highest = 300;
    for (std::uint64_t n = 0; n < kHistogramBins; ++n)
        statistics.histogram.push_back(n * n);
    VolumeInfo info = lying({4, 4, 4}, {0, 0, 0}, {2, 4, 1});
    info.rescaleSlope = 2, info.rescaleIntercept = -5;
    ValueSummary s = summarise(statistics, info, "");
    EXPECT_EQ(s.lowest, -45);
    EXPECT_EQ(s.highest, 595);
    EXPECT_FALSE(s.isHu);
    EXPECT_NEAR(s.spacingMm, 2, 1e-12);
    ASSERT_EQ(s.histogram.size(), static_cast<std::size_t>(kHistogramBins));
    EXPECT_EQ(s.histogram[3], 9);
    EXPECT_TRUE(summarise(statistics, info, "HU").isHu);
    EXPECT_FALSE(summarise(statistics, info, "SUVbw").isHu);
    info.unit = "HU";
    EXPECT_TRUE(summarise(statistics, info, "").isHu);
    info.rescaleSlope = -2;
    s = summarise(statistics, info, "");
    EXPECT_EQ(s.lowest, -605);
    EXPECT_EQ(s.highest, 35);
    EXPECT_EQ(s.histogram[kHistogramBins - 1 - 3], 9);
    EXPECT_TRUE(s.fills.empty());
    statistics.fills = {{{-20, 16}, {300, 4}}, 10, 90, statistics.histogram}; // 64 voxels
    s = summarise(statistics, info, "");
    ASSERT_EQ(s.fills.size(), 2u);
    EXPECT_EQ(s.fills[0].value, 35);
    EXPECT_EQ(s.fills[0].share, 0.25);
    EXPECT_EQ(s.fills[1].value, -605);
    EXPECT_EQ(s.fills[1].share, 0.0625);
    EXPECT_EQ(s.measured.lowest, -185);
    EXPECT_EQ(s.measured.highest, -25);
    EXPECT_EQ(s.measured.histogram[kHistogramBins - 1 - 3], 9);
}

// What is hidden reads as -1000 HU, held to the volume's range; without a unit as what is least.
TEST(StoredAir, IsAThousandBelowWaterOrTheLeast) {
    Statistics statistics;
    statistics.lowest = -1500, statistics.highest = 3000;
    VolumeInfo info;
    info.rescaleSlope = 1, info.rescaleIntercept = 24;
    EXPECT_EQ(storedAir(statistics, info, true), -1024);
    EXPECT_EQ(storedAir(statistics, info, false), -1500);
    info.rescaleSlope = 0.75;
    EXPECT_EQ(storedAir(statistics, info, true), -1365) << "-1365.3, rounded";
    info.rescaleSlope = -1;
    EXPECT_EQ(storedAir(statistics, info, true), 1024);
    EXPECT_EQ(storedAir(statistics, info, false), 3000);
    statistics.highest = 500;
    EXPECT_EQ(storedAir(statistics, info, true), 500);
    info.rescaleSlope = 1, statistics.lowest = -200;
    EXPECT_EQ(storedAir(statistics, info, true), -200);
}

// Functions are sharp where the midpoint rule's error on a rise is at least a half, and smooth up to 0.05.
TEST(ChooseIntegrator, SharpAndSmoothAreByTheErrorOnARise) {
    const TransferTable table = makeTable(
        TransferFunction::fromExtinction({{0, 0}, {500, 0}, {500, 2}, {560, 2}, {560, 0}, {1000, 0}}, {}));
    Statistics s;
    s.cells = s.bricks = {1, 1, 1};
    for (const double slope : {2.0, -2.0}) {
        VolumeInfo info;
        info.rescaleSlope = slope;
        info.rescaleIntercept = slope > 0 ? 0 : 1000;
        s.lowest = 0, s.highest = 500;
        s.cellMin = s.brickMin = {200};
        s.cellMax = s.brickMax = {260}; // a range of 120: 40 a voxel
        ASSERT_NEAR(typicalChangePerVoxel(s, table, info), 40, 1e-9);
        int sharp = 0, smooth = 0, between = 0;
        double nearHalf = 1, nearSmooth = 1;
        for (double step = 0.01; step < 8; step *= 1.02) {
            const double error = midpointRampError(table, 40 * step, 0, 1000);
            EXPECT_EQ(isSharp(s, table, info, step), error >= 0.5) << step << ": " << error;
            EXPECT_EQ(isSmooth(s, table, info, step), error <= 0.05) << step << ": " << error;
            (error >= 0.5 ? sharp : error <= 0.05 ? smooth : between) += 1;
            nearHalf = std::min(nearHalf, std::abs(error - 0.5));
            nearSmooth = std::min(nearSmooth, std::abs(error - 0.05));
        }
        EXPECT_GT(sharp, 10);
        EXPECT_GT(smooth, 10);
        EXPECT_GT(between, 10);
        EXPECT_LT(nearHalf, 0.05) << "errors on both sides, near";
        EXPECT_LT(nearSmooth, 0.005);
    }
}

// Quick levels have at most 128 samples along every axis.
TEST(QuickLevels, HaveAtMost128Samples) {
    for (const auto& [along, level] : {std::pair(128, 0), {129, 1}, {256, 1}, {257, 2}, {513, 3}})
        for (int axis = 0; axis < 3; axis += along == 129 ? 1 : 2) {
            glm::ivec3 extent(4);
            extent[axis] = along;
            const Stored stored([](const glm::dvec3&) { return 1.0; }, extent, true);
            Scene scene = stored.scene({});
            scene.volumes[0].transferFunction = TransferFunction::fromExtinction({{0, 1}, {2, 1}}, {});
            Budgets budgets;
            const StoreReader store(stored.folder / "v.zarr", budgets.ram);
            const Planner p =
                planScene(scene, store, TextureLimits{}, {budgets.ram, budgets.gpu, 1}, LevelChoice::quick);
            EXPECT_EQ(p.layer().selection.finest(), level) << along;
            EXPECT_TRUE(p.layer().selection.uniform());
        }
}

// A turntable's camera holds the narrowest upright cylinder around all silhouettes.
TEST(TurningCameras, HoldTheCylinderAroundAll) {
    struct Ball {
        glm::dvec3 at;
        double radius;
    };
    const glm::ivec2 size(40, 30);
    const auto fitsOf = [&](const std::vector<Ball>& balls) {
        std::vector<ViewFit> fits;
        for (int n = 0; n < 12; ++n) {
            ViewFit fit(viewAxes(ViewAngles{n * 15.0, 0}), Projection::parallel, size);
            for (const Ball& ball : balls) {
                const ViewAxes& a = fit.axes();
                fit.add({glm::dot(ball.at, a.right), glm::dot(ball.at, a.up), glm::dot(ball.at, a.towards)},
                        glm::dvec3(ball.radius));
            }
            fits.push_back(fit);
        }
        return fits;
    };
    struct Cylinder {
        glm::dvec3 centre;
        double radius, half;
    };
    const std::pair<std::vector<Ball>, Cylinder> cases[] = {
        {{{{3, -8, 20}, 5}}, {{3, -8, 20}, 5, 5}},
        {{{{13, 2, 20}, 5}, {{-3, 2, 40}, 5}}, {{5, 2, 30}, 13, 15}},    // along x
        {{{{4, 12, 20}, 3}, {{4, -8, 21}, 3}}, {{4, 2, 20.5}, 13, 3.5}}, // along y
    };
    for (const auto& [balls, cylinder] : cases)
        for (const Projection projection : {Projection::parallel, Projection::perspective})
            for (const double rise : {0.0, 30.0, 90.0}) {
                FittedView view;
                view.projection = projection;
                view.angles = ViewAngles{20, rise};
                const Camera found = turningCamera(view, fitsOf(balls), {}, size);
                const ViewAxes axes = axesOf(view);
                ViewFit fit(axes, projection, size);
                const auto reach = [&](const glm::dvec3& d) {
                    return cylinder.radius * std::hypot(d.x, d.y) + cylinder.half * std::abs(d.z);
                };
                const glm::dvec3& c = cylinder.centre;
                fit.add({glm::dot(c, axes.right), glm::dot(c, axes.up), glm::dot(c, axes.towards)},
                        {reach(axes.right), reach(axes.up), reach(axes.towards)});
                const Camera expected = fit.camera();
                EXPECT_LT(glm::distance(found.position, expected.position), 1e-9);
                EXPECT_LT(glm::distance(found.focalPoint, expected.focalPoint), 1e-9);
                EXPECT_NEAR(found.parallelScale, expected.parallelScale, 1e-9);
            }
    // Nothing is visible: the volumes' boxes.
    const VolumeInfo box = lying({10, 10, 40}, {-2, 4, 6}, {1, 1, 0.5});
    const VolumeInfo* const boxes[] = {&box};
    FittedView view;
    view.projection = Projection::parallel;
    const Camera found = turningCamera(view, fitsOf({}), boxes, size);
    EXPECT_LT(glm::distance(found.focalPoint, {3, 9, 16}), 1e-9);
    // Half of it is 10 mm high, and 5 sqrt(2) mm wide at most: of 40 by 30 pixels the height decides.
    EXPECT_NEAR(found.parallelScale, 10 * 1.03, 0.01);
}

} // namespace
} // namespace tessera::test
