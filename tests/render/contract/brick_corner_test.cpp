// tests/render/contract/brick_corner_test.cpp: the blend of bricks of two levels, against the table of
// docs/sampling.md ("Value") written down once more. Also the lengths of strides beside finer bricks.
#include "render/contract/level_map.h"
#include "render/contract/strides.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <vector>

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

// The texels of a level map say what the eight bricks around a corner and the four corners of a face say.
TEST(LevelMaps, FactsAreThoseOfTheirBricks) {
    std::mt19937 random(7);
    MemoryBudget ram("RAM", "--ram", std::size_t{16} << 20);
    int agreeing = 0, mixed = 0, finer = 0;
    for (int round = 0; round < 40; ++round)
        for (const EdgeFunction function :
             {EdgeFunction::nearest, EdgeFunction::minimum, EdgeFunction::split, EdgeFunction::maximum}) {
            Selection selection;
            selection.bricks = {3, 4, 2};
            // Few levels, so that corners agree; rounds without any, and of empty bricks alone.
            const unsigned kinds = 1 + static_cast<unsigned>(round) % 3;
            for (int b = 0; b < 24; ++b) {
                const unsigned any =
                    static_cast<unsigned>(round) / 5 + static_cast<unsigned>(random()) % kinds;
                const bool empty = round == 3 || random() % 3 == 0;
                selection.levels.push_back(
                    static_cast<std::uint8_t>(empty ? kEmpty : any % static_cast<unsigned>(kLevelCount)));
                ++selection.counts[selection.levels.back()];
            }
            Quality quality;
            quality.edgeFunction = function;
            const LevelMap map = makeLevelMap(selection, selection.bricks * kBrickExtent - 5, quality, ram);
            std::uint32_t finest = kLevelCount - 1;
            for (const std::uint8_t level : selection.levels)
                finest = std::min<std::uint32_t>(finest, level);
            EXPECT_EQ(map.finest, finest);
            EXPECT_EQ(map.extentVoxels, selection.bricks * kBrickExtent - 5);
            const auto codeOf = [&](const glm::ivec3& brick) {
                const bool inside = glm::all(glm::greaterThanEqual(brick, glm::ivec3(0))) &&
                                    glm::all(glm::lessThan(brick, selection.bricks));
                return inside ? std::uint32_t{selection.levels[linearIndex(brick, selection.bricks)]}
                              : BrickCorner::kOutside;
            };
            for (std::size_t c = 0; c < map.corners.size(); ++c) {
                const glm::ivec3 at = gridPosition(c, map.cornerGrid());
                const BrickCorner& corner = map.at(at);
                std::vector<std::uint32_t> shown;
                bool anyEmpty = false;
                double widest[3] = {0, 0, 0};
                for (int n = 0; n < 8; ++n) {
                    const glm::ivec3 brick = at - 1 + glm::ivec3(n & 1, n >> 1 & 1, n >> 2);
                    const std::uint32_t code = codeOf(brick);
                    ASSERT_EQ(corner.code(n), code);
                    anyEmpty = anyEmpty || code == kEmpty;
                    if (code < kEmpty)
                        shown.push_back(code);
                    for (int axis = 0; axis < 3; ++axis) {
                        const std::uint32_t other =
                            codeOf(brick + glm::ivec3(axis == 0, axis == 1, axis == 2));
                        if ((n >> axis & 1) != 0 || code == BrickCorner::kOutside ||
                            other == BrickCorner::kOutside)
                            continue;
                        const EdgeReach<double> reach = edgeReach<double>(code, other, function, finest);
                        widest[axis] = std::max({widest[axis], reach.own, reach.other});
                    }
                }
                for (int axis = 0; axis < 3; ++axis) {
                    const std::uint32_t code = corner.reachCode(axis);
                    ASSERT_EQ(code == BrickCorner::kNoReach ? 0 : delta(code), widest[axis])
                        << "axis " << axis;
                }
                const std::uint32_t least =
                    shown.empty() ? finest : *std::min_element(shown.begin(), shown.end());
                const bool alike =
                    std::all_of(shown.begin(), shown.end(), [&](auto l) { return l == least; });
                const bool agrees =
                    alike && (!anyEmpty || least == finest) && function != EdgeFunction::nearest;
                ASSERT_EQ(corner.agree(), agrees);
                if (agrees) {
                    ASSERT_EQ(corner.commonLevel(), static_cast<int>(least));
                }
                ASSERT_EQ(corner.finestLevel(), shown.empty() ? kLevelCount : static_cast<int>(least));
                agreeing += agrees, mixed += !agrees;
            }
            for (std::size_t b = 0; b < map.facts.size(); ++b) {
                const glm::ivec3 brick = gridPosition(b, selection.bricks);
                const std::uint32_t facts = map.facts[b], own = codeOf(brick);
                ASSERT_EQ(facts & 7u, own);
                for (int face = 0; face < 6; ++face) {
                    const int axis = face % 3;
                    double widest = 0;
                    bool isFiner = false;
                    for (int n = 0; n < 8; ++n) {
                        const glm::ivec3 corner = brick + glm::ivec3(n & 1, n >> 1 & 1, n >> 2);
                        if (corner[axis] != brick[axis] + face / 3)
                            continue;
                        const BrickCorner& at = map.at(corner);
                        if (at.reachCode(axis) != BrickCorner::kNoReach)
                            widest = std::max(widest, delta(at.reachCode(axis)));
                        isFiner = isFiner || at.finestLevel() < static_cast<int>(own);
                    }
                    glm::ivec3 beyond = brick;
                    beyond[axis] += face < 3 ? -1 : 1;
                    const std::uint32_t code = facts >> (3 + 3 * face) & 7u;
                    if (widest > 0)
                        ASSERT_EQ(delta(code), widest) << "face " << face;
                    else
                        ASSERT_EQ(code, codeOf(beyond) == BrickCorner::kOutside ? 7u : 6u) << "face " << face;
                    ASSERT_EQ(facts >> (21 + face) & 1u, isFiner ? 1u : 0u) << "face " << face;
                    finer += isFiner;
                }
                ASSERT_EQ(facts >> 27, 0u);
            }
        }
    EXPECT_GT(agreeing, 1000);
    EXPECT_GT(mixed, 1000);
    EXPECT_GT(finer, 300);
}

// No stride is longer than half a brick, or than a sample of the coarsest level; none of full sampling is.
TEST(LevelMaps, TellTheLongestStride) {
    Selection selection;
    selection.bricks = {1, 1, 2};
    const auto longest = [&](int coarsest, double step, Sampling sampling = Sampling::limited) {
        selection.levels = {0, static_cast<std::uint8_t>(coarsest)};
        selection.counts = {};
        for (const std::uint8_t level : selection.levels)
            ++selection.counts[level];
        Quality quality;
        quality.stepVoxels = step;
        quality.sampling = sampling;
        return mostStride(selection, quality);
    };
    EXPECT_EQ(longest(0, 1), 0);
    EXPECT_EQ(longest(3, 1), 3);
    EXPECT_EQ(longest(4, 1), 4);
    EXPECT_EQ(longest(5, 1), 4);
    EXPECT_EQ(longest(5, 0.5), 5);
    EXPECT_EQ(longest(5, 2), 3);
    EXPECT_EQ(longest(5, 2.01), 2);
    EXPECT_EQ(longest(5, 16), 0);
    EXPECT_EQ(longest(5, 1, Sampling::naive), 4);
    EXPECT_EQ(longest(5, 0.5, Sampling::full), 0);
    EXPECT_EQ(longest(int{Selection::kEmpty}, 1), 0);
}

} // namespace
} // namespace tessera
