// tests/render/empty_space/value_bounds_test.cpp: bounds of values are those of a search through all samples
// that a point in a cell or a brick can reach: no lower, and not higher than that.
#include "render/empty_space/value_bounds.h"

#include "render/contract/optics.h"
#include "tests/support/surface_fixture.h" // Stored

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

constexpr glm::ivec3 kVoxels(75, 41, 50); // 3 x 2 x 2 bricks

double peaks(const glm::dvec3& p) {
    const glm::ivec3 at(p);
    return (at.x * 7919 + at.y * 104729 + at.z * 1299709) % 1009 - (at.x % 16 > 7 ? 900 : 0);
}

/// The outermost place of the table among voxels of a box, one layer around it included.
float searched(const Layer& layer, const glm::ivec3& first, int extent, int reach) {
    const bool least = layer.optics.reduction == Reduction::minimum;
    const float last = static_cast<float>(layer.optics.table.size() - 1);
    float most = least ? last : 0;
    const glm::ivec3 low = glm::max(first - reach, glm::ivec3(0));
    const glm::ivec3 high = glm::min(first + extent + reach, kVoxels);
    for (int z = low.z; z < high.z; ++z)
        for (int y = low.y; y < high.y; ++y)
            for (int x = low.x; x < high.x; ++x) {
                const auto stored = static_cast<float>(std::lround(peaks(glm::dvec3(x, y, z) + 0.5)));
                const float place = std::clamp(placeOf(layer.optics, stored), 0.0f, last);
                most = least ? std::min(most, place) : std::max(most, place);
            }
    return most;
}

/// Every cell and brick against the search; a bound may be off by the rounding that it allows for.
void checkBounds(const Layer& layer, int reachOfCells, int reachOfBricks) {
    const ValueBounds& b = layer.bounds;
    ASSERT_TRUE(b.exists());
    EXPECT_EQ(b.extentVoxels(), kVoxels);
    ASSERT_EQ(b.bricks(), glm::ivec3(3, 2, 2));
    ASSERT_EQ(b.cells(), glm::ivec3(10, 6, 7));
    for (std::size_t n = 0; n < cellCount(b.cells()); ++n)
        ASSERT_NEAR(b.cell()[n],
                    searched(layer, gridPosition(n, b.cells()) * kCellExtent, kCellExtent, reachOfCells),
                    0.02)
            << "cell " << n;
    for (std::size_t n = 0; n < cellCount(b.bricks()); ++n)
        ASSERT_NEAR(b.brick()[n],
                    searched(layer, gridPosition(n, b.bricks()) * kBrickExtent, kBrickExtent, reachOfBricks),
                    0.02)
            << "brick " << n;
}

TEST(ValueBounds, AreThoseOfASearch) {
    const Stored stored(peaks, kVoxels, true, 1, ValueType::i16);
    for (const Mode mode : {Mode::maximum, Mode::minimum}) {
        Scene scene = stored.scene({}, 0, 8);
        scene.mode = mode;
        scene.volumes[0].transferFunction = "auto";
        const auto prepared = stored.prepare(scene);
        Planner& p = prepared->p;
        Layer& layer = p.layer();
        EXPECT_EQ(layer.bounds.least(), mode == Mode::minimum);
        ASSERT_EQ(layer.selection.counts[0], 12u);
        checkBounds(layer, 1, 1);
        // Coarser samples reach the cells around, and at last all bricks around.
        const auto setAll = [&](std::uint8_t level) {
            const std::uint64_t version = layer.bounds.version();
            Selection s = layer.selection;
            s.counts = {};
            s.levels.assign(12, level);
            s.counts[level] = 12;
            p.setSelection(s);
            EXPECT_GT(layer.bounds.version(), version) << "copies of it are older";
        };
        setAll(2);
        checkBounds(layer, 9, 33);
        setAll(0);
        checkBounds(layer, 1, 1);
        setAll(3);
        const ValueBounds& b = layer.bounds;
        for (std::size_t n = 0; n < b.cell().size(); ++n) {
            const glm::ivec3 brick = gridPosition(n, b.cells()) / kCellsPerBrick;
            ASSERT_EQ(b.cell()[n], b.brick()[linearIndex(brick, b.bricks())]) << "cells say no more";
        }
        EXPECT_EQ(ValueBounds::bytes(kVoxels, MapScale::cells), 4u * (10 * 6 * 7 + 12));
        EXPECT_EQ(ValueBounds::bytes(kVoxels, MapScale::bricks), 4u * 12);
    }
}

// The box that a ray leaps over is the largest of brick, cell and nothing whose bound does not reach further.
TEST(ValueBounds, BoxesHoldNothingThatCouldChangeAValue) {
    const Stored stored([](const glm::dvec3& p) { return p.x + 2 * p.y + 3 * p.z; }, kVoxels, true, 1,
                        ValueType::i16);
    for (const Mode mode : {Mode::maximum, Mode::minimum}) {
        Scene scene = stored.scene({}, 0, 8);
        scene.mode = mode;
        scene.volumes[0].transferFunction = "auto";
        const auto prepared = stored.prepare(scene);
        const ValueBounds& b = prepared->p.layer().bounds;
        int bricks = 0, cells = 0, none = 0;
        const float last = static_cast<float>(prepared->p.layer().optics.table.size() - 1);
        for (int n = 0; n < 4000; ++n) {
            const glm::vec3 p = 0.1f * glm::vec3(n * 37 % 750, n * 53 % 410, n * 71 % 500);
            const float kept = static_cast<float>(n % 101) / 100 * last;
            const auto further = [&](float bound) { return b.least() ? bound < kept : bound > kept; };
            const glm::ivec3 brick = glm::ivec3(p) / 32, cell = glm::ivec3(p) / 8;
            const auto box = boundedBoxAt(b, p, kept);
            if (!further(b.brick()[linearIndex(brick, b.bricks())])) {
                ASSERT_TRUE(box);
                EXPECT_EQ(box->low, brick * 32);
                EXPECT_EQ(box->high, brick * 32 + 32);
                ++bricks;
            } else if (!further(b.cell()[linearIndex(cell, b.cells())])) {
                ASSERT_TRUE(box);
                EXPECT_EQ(box->low, cell * 8);
                EXPECT_EQ(box->high, cell * 8 + 8);
                ++cells;
            } else {
                EXPECT_FALSE(box);
                ++none;
            }
        }
        EXPECT_GT(std::min({bricks, cells, none}), 5);
    }
}

} // namespace
} // namespace tessera::test
