// tests/bricking/analysis/marks_test.cpp: sets of voxels as bits against the words of their headers and
// against the plain way (plain_body.h), on random sets.
#include "bricking/analysis/body/body_marks.h"
#include "bricking/analysis/body/mark_distance.h"
#include "bricking/analysis/body/mark_parts.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/plain_body.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace tessera::test {
namespace {

/// Grids whose rows are less, more and just as long as words.
const std::vector<glm::ivec3>& extents() {
    static const std::vector<glm::ivec3> all = {{11, 7, 5},  {64, 5, 4}, {65, 6, 3},
                                                {130, 4, 5}, {1, 9, 6},  {20, 1, 1}};
    return all;
}

PlainMarks someMarks(std::mt19937& random, std::size_t size, unsigned percent) {
    PlainMarks marks(size);
    for (std::uint8_t& mark : marks)
        mark = random() % 100 < percent;
    return marks;
}
/// In lumps, so that there are depths.
PlainMarks lumps(std::mt19937& random, const glm::ivec3& extent, int count) {
    PlainMarks marks(cellCount(extent));
    for (int n = 0; n < count; ++n) {
        const auto at = [&](int length) {
            return static_cast<int>(random() % static_cast<unsigned>(length));
        };
        const glm::ivec3 middle(at(extent.x), at(extent.y), at(extent.z));
        const auto radius = static_cast<double>(1 + random() % 8);
        for (std::size_t i = 0; i < marks.size(); ++i)
            if (glm::length(glm::dvec3(gridPosition(i, extent) - middle)) < radius)
                marks[i] = 1;
    }
    return marks;
}

TEST(Marks, HoldWhatWasAdded) {
    std::mt19937 random(1);
    for (const glm::ivec3& extent : extents()) {
        const PlainMarks plain = someMarks(random, cellCount(extent), 30),
                         other = someMarks(random, cellCount(extent), 50);
        const Marks marks = bitsOf(plain, extent), second = bitsOf(other, extent);
        EXPECT_EQ(bytesOf(marks), plain);
        EXPECT_EQ(marks.count(), static_cast<std::size_t>(std::count(plain.begin(), plain.end(), 1)));
        EXPECT_EQ(marks.any(), marks.count() > 0);
        EXPECT_FALSE(Marks(extent).any());
        EXPECT_EQ(Marks::all(extent).count(), plain.size());
        const PlainMarks common = bytesOf(both(marks, second)),
                         rest = bytesOf(without(Marks::all(extent), marks));
        for (std::size_t i = 0; i < plain.size(); ++i) {
            EXPECT_EQ(common[i], plain[i] && other[i]);
            EXPECT_EQ(rest[i], !plain[i]);
        }
    }
}

/// Sample by sample.
TEST(BodyMarks, AreWhatTheirWordsSay) {
    std::mt19937 random(2);
    for (const glm::ivec3& e : extents()) {
        const auto marked = [&](const PlainMarks& of, const glm::ivec3& v) {
            return v == glm::clamp(v, glm::ivec3(0), e - 1) && of[linearIndex(v, e)] != 0;
        };
        const PlainMarks body = someMarks(random, cellCount(e), 14),
                         firm = someMarks(random, cellCount(e), 40);
        const Marks bodyBits = bitsOf(body, e), firmBits = bitsOf(firm, e);
        PlainMarks air(body.size()); // slices whose borders are air, over faces within the slice
        for (bool grows = true; grows;) {
            grows = false;
            for (std::size_t i = 0; i < air.size(); ++i) {
                const glm::ivec3 v = gridPosition(i, e);
                bool reaches = v.x == 0 || v.y == 0 || v.x == e.x - 1 || v.y == e.y - 1;
                for (const glm::ivec3& step : {glm::ivec3(1, 0, 0), {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}})
                    reaches = reaches || marked(air, v + step);
                if (!firm[i] && !air[i] && reaches) {
                    air[i] = 1;
                    grows = true;
                }
            }
        }
        EXPECT_EQ(bytesOf(reached(firmBits)), air);
        const PlainMarks wide = bytesOf(dilated(bodyBits)), flat = bytesOf(dilatedInSlices(bodyBits)),
                         faces = bytesOf(besideFaces(bodyBits));
        for (std::size_t i = 0; i < body.size(); ++i) {
            bool any = false, inSlice = false, byFace = false;
            for (std::size_t n = 0; n < 27; ++n) {
                const glm::ivec3 step = gridPosition(n, glm::ivec3(3)) - 1;
                const bool there = marked(body, gridPosition(i, e) + step);
                any = any || there;
                inSlice = inSlice || (there && step.z == 0);
                byFace = byFace || (there && glm::abs(step.x) + glm::abs(step.y) + glm::abs(step.z) <= 1);
            }
            EXPECT_EQ(wide[i] != 0, any);
            EXPECT_EQ(flat[i] != 0, inSlice);
            EXPECT_EQ(faces[i] != 0, byFace);
        }
        for (const Outwards& side : kSides) {
            const PlainMarks found = bytesOf(beyond(bodyBits, side)), on = bytesOf(onwards(bodyBits, side)),
                             lines = bytesOf(linesOf(bodyBits, side));
            std::size_t facing = 0;
            for (int z = 0; z < e.z; ++z)
                for (int line = 0; line < e[1 - side.axis]; ++line) {
                    bool free = true, meets = false, isFirm = false; // from the outer end inwards
                    const auto at = [&](int n) {
                        glm::ivec3 v(0, 0, z);
                        v[1 - side.axis] = line;
                        v[side.axis] = side.up ? e[side.axis] - 1 - n : n;
                        return v;
                    };
                    for (int n = 0; n < e[side.axis]; ++n) {
                        free = free && !marked(body, at(n));
                        EXPECT_EQ(marked(found, at(n)), free) << side.axis << side.up;
                        bool inner = false;
                        for (int m = n; m < e[side.axis]; ++m)
                            inner = inner || marked(body, at(m));
                        EXPECT_EQ(marked(on, at(n)), inner) << side.axis << side.up;
                        meets = meets || marked(body, at(n));
                        isFirm = isFirm || marked(firm, at(n));
                    }
                    EXPECT_EQ(marked(lines, at(0)), meets);
                    facing += meets && isFirm ? 1 : 0;
                }
            EXPECT_EQ(facingBody(firmBits, bodyBits, side), facing);
        }
    }
}

/// Parts with their boxes and what they meet, each chosen alone.
TEST(MarkParts, AreThoseOfThePlainWay) {
    std::mt19937 random(3);
    for (const glm::ivec3& e : extents())
        for (const unsigned percent : {20u, 45u, 60u, 100u}) {
            const BodyGrid grid(boxInfo(e, glm::dvec3(1), glm::dvec3(0)), 0, 1);
            const PlainMarks marks = someMarks(random, cellCount(e), percent),
                             other = someMarks(random, cellCount(e), 5);
            using Box = std::array<int, 7>;
            std::multiset<Box> expected, found;
            PlainMarks large(marks.size());
            plainParts(marks, grid, [&](std::span<const std::size_t> voxels) {
                glm::ivec3 low = e, high(0);
                bool meets = false;
                for (const std::size_t i : voxels) {
                    low = glm::min(low, gridPosition(i, e));
                    high = glm::max(high, gridPosition(i, e) + 1);
                    meets = meets || other[i];
                }
                for (const std::size_t i : voxels)
                    large[i] = high.x - low.x > 2;
                expected.insert({low.x, low.y, low.z, high.x, high.y, high.z, meets});
            });
            const Marks chosen = chosenParts(
                bitsOf(marks, e), Connected::throughSlices, bitsOf(other, e), [&](const MarkPart& part) {
                    found.insert({part.low.x, part.low.y, part.low.z, part.high.x, part.high.y, part.high.z,
                                  part.isMeeting});
                    return part.high.x - part.low.x > 2;
                });
            EXPECT_EQ(found, expected);
            EXPECT_EQ(bytesOf(chosen), large);
        }
}

/// Distances of all pairs; of sets in lumps those of the transform, bit for bit, where a limit is a distance
/// too.
TEST(MarkDistance, IsThatOfThePlainWay) {
    std::mt19937 random(4);
    const glm::dvec3 spacings[] = {{1, 1, 1},         {0.7, 1.9, 3.1}, {0.1, 0.1, 0.3},
                                   {2.148, 2.148, 6}, {5, 5, 5},       {0.9765625, 0.9765625, 2}};
    for (const glm::dvec3& spacing : spacings)
        for (const glm::ivec3& extent : {glm::ivec3(13, 9, 7), {70, 31, 12}, {129, 20, 9}}) {
            const BodyGrid grid(boxInfo(extent, spacing, glm::dvec3(0)), 0, 1);
            for (const int share : {0, 1, 30, 97, 100, -9}) {
                const PlainMarks plain = share < 0
                                             ? lumps(random, extent, -share)
                                             : someMarks(random, grid.size(), static_cast<unsigned>(share));
                const Marks marks = bitsOf(plain, extent);
                const std::vector<float> away = plainDistances(plain, 1, grid),
                                         depth = plainDistances(plain, 0, grid);
                EXPECT_EQ(largestDepth(marks, spacing), *std::max_element(depth.begin(), depth.end()));
                for (const double limit : {0., 1.02, 4., 9., 25.}) {
                    const double most = limit * spacing.x * spacing.x;
                    const PlainMarks near = bytesOf(within(marks, spacing, most, 2));
                    for (std::size_t i = 0; i < near.size(); ++i)
                        ASSERT_EQ(near[i] != 0, static_cast<double>(away[i]) <= most)
                            << share << " " << limit << " " << i;
                }
                EXPECT_FALSE(within(marks, spacing, -1, 1).any());
            }
        }
}

TEST(MarkDistance, IsTheNearestOfAllPairs) {
    const glm::ivec3 extent(13, 9, 7);
    const glm::dvec3 spacing(0.7, 1.9, 3.1);
    const BodyGrid grid(boxInfo(extent, spacing, glm::dvec3(0)), 0, 1);
    std::mt19937 random(5);
    for (const unsigned percent : {1u, 20u}) {
        const PlainMarks plain = someMarks(random, grid.size(), percent);
        double deepest = 0;
        for (const double limit : {1.7, 6.3, 40.}) {
            const PlainMarks near = bytesOf(within(bitsOf(plain, extent), spacing, limit, 1));
            for (std::size_t i = 0; i < plain.size(); ++i) {
                double nearest = 1e30, toOthers = 1e30;
                for (std::size_t j = 0; j < plain.size(); ++j) {
                    const glm::dvec3 apart =
                        glm::dvec3(gridPosition(i, extent) - gridPosition(j, extent)) * spacing;
                    double& least = plain[j] ? nearest : toOthers;
                    least = std::min(least, glm::dot(apart, apart));
                }
                ASSERT_EQ(near[i] != 0, nearest <= limit) << i;
                deepest = std::max(deepest, toOthers);
            }
        }
        EXPECT_NEAR(static_cast<double>(largestDepth(bitsOf(plain, extent), spacing)), deepest, 1e-5);
    }
}

TEST(BodyMarks, GrowByMillimetres) {
    const VolumeInfo info = boxInfo({25, 13, 7}, {2, 5, 10}, {0, 0, 0});
    const BodyGrid grid(info, 0, 1);
    Marks marks(grid.extent);
    const glm::ivec3 middle(12, 6, 3);
    marks.add(middle);
    growInto(marks, Marks::all(grid.extent), grid, 20);
    for (std::size_t i = 0; i < grid.size(); ++i) {
        const glm::ivec3 at = gridPosition(i, grid.extent);
        const glm::dvec3 away = glm::abs(glm::dvec3(at - middle)) * grid.spacingMm;
        EXPECT_EQ(marks.has(at), away.x + away.y + away.z <= 20) << i;
    }
}

/// Where ways of as many steps are not as long, the first in the order of samples counts.
TEST(BodyMarks, GrowAsThePlainWayDoes) {
    std::mt19937 random(6);
    for (const glm::ivec3& e : extents())
        for (const double most : {3., 9., 30.}) {
            const BodyGrid grid(boxInfo(e, {1, 2.2, 3.1}, glm::dvec3(0)), 0, 1);
            PlainMarks plain = someMarks(random, grid.size(), 2);
            const PlainMarks open = someMarks(random, grid.size(), 70);
            Marks marks = bitsOf(plain, e);
            growInto(marks, bitsOf(open, e), grid, most);
            plainGrowInto(plain, open, grid, most);
            EXPECT_EQ(bytesOf(marks), plain);
        }
}

} // namespace
} // namespace tessera::test
