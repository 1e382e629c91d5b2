// tests/bricking/statistics/coarse_statistics_test.cpp: bounds of a coarser level are those of the bricks
// that its samples come from, along every axis.
#include "bricking/statistics/coarse_statistics.h"

#include "core/base/brick.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace tessera {
namespace {

TEST(CoarseStatistics, BoundALevelByTheBricksBelow) {
    std::mt19937 random(1);
    for (const glm::ivec3 extent : {glm::ivec3(300, 90, 140), {70, 330, 65}, {64, 129, 400}, {20, 30, 10}}) {
        VolumeInfo info;
        info.extentVoxels = extent;
        Statistics all;
        all.bricks = brickGrid(extent);
        all.brickMin.resize(cellCount(all.bricks));
        all.brickMax.resize(all.brickMin.size());
        for (std::size_t n = 0; n < all.brickMin.size(); ++n) {
            all.brickMin[n] = static_cast<float>(random() % 1000);
            all.brickMax[n] = all.brickMin[n] + static_cast<float>(random() % 1000);
        }
        all.lowest = -7, all.highest = 5000;
        for (int level = 0; level < kLevelCount; ++level) {
            MemoryBudget ram("RAM", "--ram", std::size_t{1} << 26);
            const Statistics bounds = boundsOfLevel(all, info, level, ram, 2);
            const glm::ivec3 samples = levelExtent(extent, level);
            ASSERT_EQ(bounds.cells, cellGrid(samples));
            ASSERT_EQ(bounds.bricks, brickGrid(samples));
            EXPECT_EQ(bounds.lowest, all.lowest);
            EXPECT_EQ(bounds.highest, all.highest);
            constexpr float kFar = std::numeric_limits<float>::infinity();
            std::vector<float> least(bounds.brickMin.size(), kFar), most(bounds.brickMin.size(), -kFar);
            for (std::size_t n = 0; n < cellCount(bounds.cells); ++n) {
                const glm::ivec3 cell = gridPosition(n, bounds.cells);
                float low = kFar, high = -kFar;
                for (std::size_t b = 0; b < all.brickMin.size(); ++b) {
                    // Does a sample of the cell, or one beside it, have a voxel of the brick?
                    const glm::ivec3 brick = gridPosition(b, all.bricks);
                    bool meets = true;
                    for (int axis = 0; axis < 3; ++axis) {
                        const int first = std::max(cell[axis] * kCellExtent - 1, 0) << level,
                                  last =
                                      std::min(((cell[axis] + 1) * kCellExtent + 1) << level, extent[axis]) -
                                      1;
                        meets = meets && first < (brick[axis] + 1) * kBrickExtent &&
                                last >= brick[axis] * kBrickExtent;
                    }
                    if (meets)
                        low = std::min(low, all.brickMin[b]), high = std::max(high, all.brickMax[b]);
                }
                EXPECT_EQ(bounds.cellMin[n], low) << level;
                EXPECT_EQ(bounds.cellMax[n], high) << level;
                const glm::ivec3 of = cell * kCellExtent / kBrickExtent;
                const std::size_t at = linearIndex(of, bounds.bricks);
                least[at] = std::min(least[at], low), most[at] = std::max(most[at], high);
            }
            EXPECT_EQ(bounds.brickMin, least);
            EXPECT_EQ(bounds.brickMax, most);
            EXPECT_EQ(bounds.wideMin, least);
            EXPECT_EQ(bounds.wideMax, most);
        }
    }
}

} // namespace
} // namespace tessera
