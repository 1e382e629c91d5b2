// tests/render/parts/part_tree_test.cpp: whatever the bricks, the number of parts and the camera: every brick
// is in one part, the segments of a ray are one part's each, in the parts' order, and near the part's box.
#include "render/parts/part_tree.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

using Random = std::mt19937;

double between(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}
int oneOf(Random& random, int count) {
    return std::uniform_int_distribution<int>(0, count - 1)(random);
}

Selection someBricks(Random& random) {
    Selection selection;
    selection.bricks = {1 + oneOf(random, 7), 1 + oneOf(random, 7), 1 + oneOf(random, 7)};
    const bool mixed = oneOf(random, 2) == 0;
    for (std::size_t n = 0; n < cellCount(selection.bricks); ++n) {
        const bool shows = oneOf(random, 3) > 0;
        selection.levels.push_back(!shows  ? Selection::kEmpty
                                   : mixed ? static_cast<std::uint8_t>(oneOf(random, kLevelCount))
                                           : std::uint8_t{0});
        ++selection.counts[selection.levels.back()];
    }
    return selection;
}

/// Eyes outside, inside, and in planes between bricks; directions along axes and in faces.
RayFrame<double> someCamera(Random& random, const glm::ivec3& bricks) {
    RayFrame<double> frame;
    frame.extent = glm::dvec3(bricks * kBrickExtent - oneOf(random, kBrickExtent));
    frame.perspective = oneOf(random, 2) == 0;
    frame.imageSize = {16, 16};
    frame.segmentVoxels = between(random, 0.2, 2);
    frame.centre =
        frame.extent * glm::dvec3(between(random, 0, 1), between(random, 0, 1), between(random, 0, 1));
    if (oneOf(random, 3) == 0)
        frame.centre = glm::round(frame.centre / 32.0) * 32.0;
    glm::dvec3 forward(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    if (oneOf(random, 3) == 0) {
        forward = glm::dvec3(0);
        forward[oneOf(random, 3)] = oneOf(random, 2) == 0 ? 1 : -1;
    }
    forward = glm::normalize(forward);
    frame.toCentre = forward * (frame.perspective ? 32.0 * (1 + oneOf(random, 12)) : 1.0);
    const glm::dvec3 other = std::abs(forward.x) > 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const double half = between(random, 10, 200);
    frame.right = half * glm::normalize(glm::cross(forward, other));
    frame.up = half * glm::normalize(glm::cross(frame.right, forward));
    return frame;
}

TEST(PartTree, HasEveryBrickOnceAndSharesSamples) {
    Random random(5);
    for (int round = 0; round < 200; ++round) {
        const Selection selection = someBricks(random);
        const int count = 1 + oneOf(random, 9);
        const PartTree tree(selection, count);
        ASSERT_EQ(tree.count(), count);
        std::vector<int> holders(selection.levels.size(), 0);
        for (int part = 0; part < count; ++part) {
            const PartTree::Box& box = tree.box(part);
            const auto around = tree.bricksAround(part, selection);
            for (std::size_t brick = 0; brick < holders.size(); ++brick) {
                const glm::ivec3 at = gridPosition(brick, selection.bricks);
                const bool inside =
                    glm::all(glm::greaterThanEqual(at, box.low)) && glm::all(glm::lessThan(at, box.high));
                holders[brick] += inside ? 1 : 0;
                const bool near = box.low != box.high && glm::all(glm::greaterThanEqual(at, box.low - 1)) &&
                                  glm::all(glm::lessThan(at, box.high + 1));
                EXPECT_EQ(std::count(around.begin(), around.end(), brick),
                          near && selection.levels[brick] + 1 < kLevelCount ? 1 : 0);
            }
        }
        EXPECT_EQ(std::count(holders.begin(), holders.end(), 1), std::ssize(holders));
    }
    Selection even;
    even.bricks = {8, 8, 8};
    even.levels.assign(512, 0);
    const PartTree tree(even, 6);
    for (int part = 0; part < 6; ++part) {
        const glm::ivec3 extent = tree.box(part).high - tree.box(part).low;
        EXPECT_NEAR(extent.x * extent.y * extent.z, 512 / 6.0, 12) << part;
    }
}

TEST(PartTree, RaysAreCutOnceAndInOrder) {
    Random random(7);
    std::size_t shared = 0;
    for (int round = 0; round < 400; ++round) {
        const Selection selection = someBricks(random);
        const PartTree tree(selection, 1 + oneOf(random, 9));
        const RayFrame<double> frame = someCamera(random, selection.bricks);
        const CutUnit unit{1 << oneOf(random, 5), frame.segmentVoxels};
        const std::vector<int> order = tree.order(frame);
        ASSERT_EQ(std::ssize(order), tree.count());
        for (int n = 0; n < 40; ++n) {
            const glm::dvec2 place =
                n == 0 ? glm::dvec2(8, 8) : glm::dvec2(between(random, 0, 16), between(random, 0, 16));
            const RayLine<double> line = pixelLine(frame, place);
            double from = 0, to = 0;
            if (!drawnPartOf(frame, line, from, to))
                continue;
            std::int32_t next = 0;
            int holders = 0;
            for (const int part : order) {
                const SegmentRange range = tree.segments(part, frame, line, from, unit);
                if (range.first >= range.end)
                    continue;
                EXPECT_EQ(range.first, next) << "round " << round;
                EXPECT_EQ(range.first % unit.segments, 0);
                next = range.end;
                ++holders;
                // Their middles lie in the part's box, or no further than half of the unit from it.
                const double length = unit.segmentVoxels, half = 0.5 * length * unit.segments + 1e-6;
                for (std::int32_t i = range.first; i < range.end && from + (i + 0.5) * length < to; ++i) {
                    const glm::dvec3 p = line.base + (from + (i + 0.5) * length) * line.direction;
                    const glm::dvec3 low(kBrickExtent * tree.box(part).low),
                        high(kBrickExtent * tree.box(part).high);
                    const glm::dvec3 beyond = glm::max(glm::max(low - p, p - high), glm::dvec3(0));
                    ASSERT_LE(glm::length(beyond), half) << "round " << round;
                }
            }
            EXPECT_EQ(next, INT32_MAX) << "round " << round;
            shared += holders > 1 ? 1 : 0;
        }
    }
    EXPECT_GT(shared, 2000u);
}

} // namespace
} // namespace tessera::test
