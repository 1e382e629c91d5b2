// tests/render/contract/brick_corner_test.cpp: the blend of bricks of two levels, against the table of
// docs/sampling.md ("Value") written down once more. Also the lengths of strides beside finer bricks.
#include "render/contract/level_map.h"
#include "render/contract/strides.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

constexpr std::uint32_t kEmpty = BrickCorner::kEmpty;

/// Half a sample of a level, voxels.
double delta(std::uint32_t level) {
    return 0.5 * (1 << level);
}

TEST(BrickCorners, EdgesReachAsFarAsTheTableSays) {
    const std::uint32_t finest = 1;
    for (const std::uint32_t own : {0u, 1u, 2u, 3u, 4u, 5u, kEmpty})
        for (const std::uint32_t other : {0u, 1u, 2u, 3u, 4u, 5u, kEmpty})
            for (const EdgeFunction function :
                 {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::split, EdgeFunction::maximum}) {
                double mine = 0, theirs = 0;
                if (own == kEmpty || other == kEmpty)
                    mine = theirs = own != kEmpty     ? delta(own)
                                    : other != kEmpty ? delta(other)
                                                      : delta(finest);
                else if (function == EdgeFunction::minimum)
                    mine = theirs = std::min(delta(own), delta(other));
                else if (function == EdgeFunction::maximum)
                    mine = theirs = std::max(delta(own), delta(other));
                else if (function == EdgeFunction::split)
                    mine = delta(own), theirs = delta(other);
                const EdgeReach<double> reach = edgeReach<double>(own, other, function, finest);
                ASSERT_EQ(reach.own, mine) << own << " " << other << " " << static_cast<int>(function);
                ASSERT_EQ(reach.other, theirs) << own << " " << other << " " << static_cast<int>(function);
                // From 0 in the other's side over a half at the boundary to 1 in its own.
                for (const bool upper : {false, true}) {
                    EXPECT_EQ(edgeWeight(reach, mine + 1e-9, upper), 1);
                    EXPECT_EQ(edgeWeight(reach, -theirs - 1e-9, upper), 0);
                    EXPECT_EQ(edgeWeight(reach, 0.0, upper), mine > 0 ? 0.5 : upper ? 1 : 0);
                    if (mine > 0) {
                        EXPECT_DOUBLE_EQ(edgeWeight(reach, 0.25 * mine, upper), 0.625);
                        EXPECT_DOUBLE_EQ(edgeWeight(reach, -0.5 * theirs, upper), 0.25);
                    }
                }
            }
}

// Rays through bricks of random levels. The strides that cut them follow the docs, by looking at every place
// of a stride instead of at a corner's eight bricks.
TEST(Strides, KeepOutOfFinerBricksAndStartAtMultiplesOfTheirLength) {
    std::mt19937 random(41);
    Selection selection;
    selection.bricks = {4, 3, 4};
    const glm::ivec3 extent = selection.bricks * kBrickExtent;
    for (int b = 0; b < 48; ++b) {
        selection.levels.push_back(static_cast<std::uint8_t>(random() % (kLevelCount + 1)));
        ++selection.counts[selection.levels.back()];
    }
    MemoryBudget ram("RAM", "--ram", std::size_t{16} << 20);
    std::uniform_real_distribution<double> unit(-1, 1);
    int longer = 0, cut = 0;
    for (const Sampling sampling : {Sampling::limited, Sampling::naive, Sampling::full}) {
        Quality quality;
        quality.stepVoxels = 0.5;
        quality.sampling = sampling;
        const LevelMap map = makeLevelMap(selection, extent, quality, ram);
        const Strides strides{&map, 1, sampling, quality.stepVoxels};
        const auto levelAt = [&](const glm::dvec3& p) {
            const glm::ivec3 brick =
                glm::clamp(glm::ivec3(glm::floor(p)) / kBrickExtent, glm::ivec3(0), selection.bricks - 1);
            return static_cast<int>(selection.levels[linearIndex(brick, selection.bricks)]);
        };
        for (int n = 0; n < 60; ++n) {
            SegmentedRay<double> ray;
            ray.direction = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
            ray.step = quality.stepVoxels * ray.direction;
            ray.entry =
                glm::dvec3(extent) * (0.5 + 0.2 * glm::dvec3(unit(random), unit(random), unit(random)));
            ray.count = 90;
            for (int i = 0, length = 1; i < ray.count; i += length) {
                length = strideAt(strides, ray, i);
                ASSERT_EQ(i % length, 0);
                ASSERT_LE(length * quality.stepVoxels, kBrickExtent / 2);
                const int level = levelAt(segmentStart(ray, i));
                ASSERT_LE(length, 1 << level);
                longer += length > 1;
                if (sampling == Sampling::full) {
                    ASSERT_EQ(length, 1);
                }
                for (double at = 0; sampling == Sampling::limited && at <= length; at += 0.25)
                    ASSERT_LE(length, 1 << levelAt(strideEnd(ray, i, at))) << "into a finer brick";
                cut += sampling == Sampling::limited && length < 1 << std::min(level, map.mostStride);
            }
        }
    }
    EXPECT_GT(longer, 500);
    EXPECT_GT(cut, 100);
}

} // namespace
} // namespace tessera
