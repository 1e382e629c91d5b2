// tests/core/base/sums_test.cpp: numbers of bricks, cells and samples by level, and sums of work.
#include "core/base/brick.h"
#include "core/base/volume.h"
#include "core/base/work.h"

#include <cstdint>
#include <gtest/gtest.h>
#include <vector>

namespace tessera {
namespace {

// A brick is four cells of eight voxels, and one sample at the coarsest level; chunks are as many samples.
TEST(Levels, HalveABrickToOneSample) {
    EXPECT_EQ(kBrickExtent, 32);
    EXPECT_EQ(kChunkExtent, 32);
    EXPECT_EQ(kCellExtent * kCellsPerBrick, kBrickExtent);
    EXPECT_EQ(kCellsPerBrick, 4);
    EXPECT_EQ(kBrickExtent >> (kLevelCount - 1), 1);
    const glm::ivec3 extent(67, 33, 1);
    EXPECT_EQ(brickGrid(extent), glm::ivec3(3, 2, 1));
    EXPECT_EQ(cellGrid(extent), glm::ivec3(9, 5, 1));
    const glm::ivec3 levels[] = {{67, 33, 1}, {34, 17, 1}, {17, 9, 1}, {9, 5, 1}, {5, 3, 1}, {3, 2, 1}};
    for (int level = 0; level < kLevelCount; ++level) {
        EXPECT_EQ(levelExtent(extent, level), levels[level]) << level;
        EXPECT_EQ(chunkGrid(extent, level), (levels[level] + glm::ivec3(31)) / glm::ivec3(32)) << level;
    }
    const glm::ivec3 grid(3, 5, 7);
    std::size_t n = 0;
    for (int z = 0; z < 7; ++z)
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 3; ++x, ++n) {
                EXPECT_EQ(linearIndex({x, y, z}, grid), n);
                EXPECT_EQ(gridPosition(n, grid), glm::ivec3(x, y, z));
            }
    EXPECT_EQ(cellCount(grid), n);
    const glm::ivec3 far(2000000, 2000000, 2000000); // beyond 32 bits
    EXPECT_EQ(linearIndex({1, 2, 3}, far), (3ull * 2000000 + 2) * 2000000 + 1);
}

/// Every count of a work, those of paths last.
std::vector<std::uint64_t> countsOf(const Work& w) {
    return {w.iterations,    w.segments,       w.samples,
            w.fetches,       w.blended,        w.paths.paths,
            w.paths.bounces, w.paths.lookUps,  w.paths.nullCollisions,
            w.paths.cells,   w.paths.exceeded, w.paths.alone};
}

TEST(Work, IsNothingAndAddsUp) {
    EXPECT_EQ(countsOf(Work()), std::vector<std::uint64_t>(12, 0));
    EXPECT_EQ(Work().dispatches + Work().bricksUploaded + Work().bytesUploaded, 0u);
    EXPECT_EQ(Work().longestDispatchMs, 0);
    EXPECT_EQ(Work().marchMs, 0);
    Work a, b;
    a.iterations = 1, a.segments = 2, a.samples = 3, a.fetches = 4, a.blended = 5;
    a.paths = {6, 7, 8, 9, 10, 11, 12};
    b.iterations = 100, b.segments = 200, b.samples = 300, b.fetches = 400, b.blended = 500;
    b.paths = {600, 700, 800, 900, 1000, 1100, 1200};
    a += b;
    for (std::size_t n = 0; n < 12; ++n)
        EXPECT_EQ(countsOf(a)[n], 101 * (n + 1)) << n;
}

} // namespace
} // namespace tessera
