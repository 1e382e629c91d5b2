// tests/render/plan/shown_cells_test.cpp: what a fitted camera looks at: the cells that could show something,
// how strongly each voxel of them does, and places along a view's axes. Beside a look at every voxel.
#include "bricking/import/importer.h"
#include "render/plan/shown_rays.h"
#include "tests/support/folders.h"
#include "tests/support/formula_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <memory>

namespace tessera::test {
namespace {

const glm::ivec3 kSlanted(70, 45, 52);

struct Slope {
    Slope() {
        VolumeInfo info;
        info.extentVoxels = kSlanted;
        info.type = ValueType::f32;
        info.rescaleSlope = -2, info.rescaleIntercept = 300;
        info.patientFromVoxel = patientFromVoxelOf({3, -8, 20}, {0.8, 0, 0}, {0, 0.9, 0.2}, {0, 0, 1.7});
        FormulaSource source(info, [](const glm::dvec3& p) { return p.x + 0.5 * p.y + 0.25 * p.z; });
        importToStore(source, folder / "slope.zarr", ram, {});
        store = std::make_unique<StoreReader>(folder / "slope.zarr", ram);
    }
    /// Physical, of a voxel.
    static double valueAt(const glm::ivec3& i) {
        const glm::dvec3 p = glm::dvec3(i) + 0.5;
        return 300 - 2 * (p.x + 0.5 * p.y + 0.25 * p.z);
    }
    MemoryBudget ram{"RAM", "--ram", std::size_t{256} << 20};
    ScratchFolder folder;
    std::unique_ptr<StoreReader> store;
};

TEST(ShownCells, AreThoseWhoseValuesShow) {
    Slope slope;
    const VolumeInfo& info = slope.store->info();
    const Statistics statistics = loadStatistics(*slope.store, slope.ram, 1);
    const TransferFunction function = TransferFunction::fromExtinction({{180, 0}, {200, 0.3}, {230, 0}}, {});
    const TransferTable table = makeTable(function, {{.value = 250, .opacity = 0.4}});
    const ViewSpace space(info, viewAxes(View::left));
    BrickCache cache(*slope.store, slope.ram, std::size_t{16} << 20, 1);
    DrawnPart part; // from y = 10 to 30 voxels
    part.slabs.push_back({glm::dvec3(0, 1, 0), 10, 30});
    for (const bool isCut : {false, true}) {
        const ShownRays rays(cache, info, statistics, table, space, isCut ? &part : nullptr, nullptr, 0.02,
                             2);
        LatticeReader samples = rays.reader();
        std::size_t shown = 0, strong = 0, surfaces = 0;
        std::array<double, ShownRays::kCellVoxels> strengths;
        const glm::ivec3 cells = cellGrid(kSlanted);
        for (std::size_t c = 0; c < cellCount(cells); ++c) {
            const glm::ivec3 cell = gridPosition(c, cells), in = cell % kCellsPerBrick;
            const std::size_t brick = linearIndex(cell / kCellsPerBrick, brickGrid(kSlanted));
            const bool isShown = (rays.shownCells(brick) >> (in.x + 4 * in.y + 16 * in.z) & 1) != 0;
            // Voxels of the cell and one around it, in the volume.
            const glm::ivec3 low = glm::max(cell * kCellExtent - 1, glm::ivec3(0)),
                             high = glm::min((cell + 1) * kCellExtent, kSlanted - 1);
            const double most = Slope::valueAt(low),
                         least = Slope::valueAt(high); // values fall along all axes
            const bool isKept = !isCut || (cell.y * kCellExtent <= 30 && (cell.y + 1) * kCellExtent >= 10);
            EXPECT_EQ(isShown, isKept && !table.emptyOver(least, most))
                << cell.x << "," << cell.y << "," << cell.z;
            shown += isShown;
            if (c % 5 != 0)
                continue;
            rays.strengths(samples, cell * kCellExtent, strengths);
            for (std::size_t n = 0; n < strengths.size(); ++n) {
                const glm::ivec3 voxel = cell * kCellExtent + gridPosition(n, glm::ivec3(kCellExtent));
                const bool isIn = glm::all(glm::lessThan(voxel, kSlanted)) &&
                                  (!isCut || (voxel.y + 0.5 >= 10 && voxel.y + 0.5 <= 30));
                if (!isIn) {
                    ASSERT_EQ(strengths[n], 0);
                    continue;
                }
                const double value = Slope::valueAt(voxel);
                double expected = function.extinction(value);
                bool crosses = false;
                for (int axis = 0; axis < 3; ++axis)
                    for (const int step : {-1, 1}) {
                        glm::ivec3 next = voxel;
                        next[axis] = std::clamp(next[axis] + step, 0, kSlanted[axis] - 1);
                        crosses = crosses || (value < 250) != (Slope::valueAt(next) < 250);
                    }
                if (crosses)
                    expected = std::max(expected, -std::log(1 - 0.4));
                surfaces += crosses;
                ASSERT_NEAR(strengths[n], expected, 0.3 * table.relativeError + 1e-4);
                strong += expected > 0;
            }
        }
        EXPECT_GT(shown, 20u);
        EXPECT_LT(shown, cellCount(cells));
        EXPECT_GT(strong, 1000u);
        EXPECT_GT(surfaces, 100u);
    }
}

TEST(ViewSpaces, AreAlongTheViewsAxes) {
    const Slope slope;
    const VolumeInfo& info = slope.store->info();
    for (const View view : {View::anterior, View::left, View::superior}) {
        const ViewAxes axes = viewAxes(view);
        const ViewSpace space(info, axes);
        glm::dvec3 low(1e9), high(-1e9);
        const glm::dvec3 middle(20.5, 11, 30), size(7, 3, 5);
        for (int n = 0; n < 8; ++n) {
            const glm::dvec3 voxel = middle + size * (glm::dvec3(n & 1, n >> 1 & 1, n >> 2) - 0.5);
            const glm::dvec3 p(info.patientFromVoxel * glm::dvec4(voxel, 1));
            const glm::dvec3 at(glm::dot(p, axes.right), glm::dot(p, axes.up), glm::dot(p, axes.towards));
            EXPECT_LT(glm::distance(space.at(voxel), at), 1e-9);
            low = glm::min(low, at), high = glm::max(high, at);
        }
        EXPECT_LT(glm::distance(space.halfOf(size), 0.5 * (high - low)), 1e-9);
    }
}

} // namespace
} // namespace tessera::test
