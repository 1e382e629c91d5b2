// tests/bricking/levels/ray_choice_test.cpp: the rays that stand for a brick, and the places of their
// samples, by the words at the top of brick_rays.h, followed slowly.
#include "tests/support/blobs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

namespace tessera {
namespace {

using test::Blobs;

struct Row {
    int axis = 0;
    glm::ivec3 start{0};
    double mean = 0, distance = 0; // of its values; of them from level 3
};

double valueAt(const Blobs& b, int level, const glm::ivec3& voxel) {
    const auto at = static_cast<std::size_t>(level);
    return static_cast<double>(b.levels[at][linearIndex(voxel >> level, b.extents[at])]);
}

/// "Every second one each way is a candidate": staggered, so that odd and even voxels both occur.
std::vector<Row> candidatesOf(const Blobs& b) {
    std::vector<Row> rows;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, w = (axis + 2) % 3;
        for (int q = 0; q < b.size[w] / 2; ++q)
            for (int p = 0; p < b.size[u] / 2; ++p) {
                Row row;
                row.axis = axis;
                row.start[u] = 2 * p + q % 2;
                row.start[w] = 2 * q + p % 2;
                for (int i = 0; i < b.size[axis]; ++i) {
                    glm::ivec3 voxel = row.start;
                    voxel[axis] = i;
                    row.mean += valueAt(b, 0, voxel) / b.size[axis];
                    row.distance += std::abs(valueAt(b, 0, voxel) - valueAt(b, 3, voxel)) / b.size[axis];
                }
                rows.push_back(row);
            }
    }
    return rows;
}

TEST(BrickRays, AreTheMiddleOnesOfTheirHalves) {
    const Blobs b({32, 32, 32}, 11);
    const auto parts = sampleRays(b.fields());
    std::vector<Row> rows = candidatesOf(b);
    std::sort(rows.begin(), rows.end(), [](const Row& x, const Row& y) { return x.mean < y.mean; });
    for (std::size_t group = 0; group < 11; ++group) {
        std::vector<Row> mine(rows.begin() + static_cast<std::ptrdiff_t>(rows.size() * group / 11),
                              rows.begin() + static_cast<std::ptrdiff_t>(rows.size() * (group + 1) / 11));
        std::sort(mine.begin(), mine.end(),
                  [](const Row& x, const Row& y) { return x.distance < y.distance; });
        for (const std::size_t half : {0u, 1u}) {
            const Row& row = mine[mine.size() * (2 * half + 1) / 4];
            const BrickRayPart& part = parts[(half + group) % 2]; // near and far ones turn by turn
            ASSERT_EQ(part.axis(static_cast<int>(group)), row.axis) << group << " " << half;
            const double step = (static_cast<double>(part.hi) - static_cast<double>(part.lo)) / 255;
            for (int j = 0; j < 16; ++j) { // voxels 0, 3, 4, 7, 8, ...
                glm::ivec3 voxel = row.start;
                voxel[row.axis] = 2 * j + j % 2;
                const std::size_t code = group * kSamplesPerRay + static_cast<std::size_t>(j);
                EXPECT_NEAR(static_cast<double>(part.lo) + step * part.codes[code], valueAt(b, 0, voxel),
                            0.501 * step)
                    << group << " " << half << " " << j;
            }
        }
    }
}

// In a brick of 16 voxels every voxel of a ray is sampled, so that those through the extremes meet them.
TEST(BrickRays, TheLastOnesGoThroughTheExtremes) {
    const Blobs b({16, 16, 16}, 3);
    const auto parts = sampleRays(b.fields());
    const auto [least, most] = std::minmax_element(b.levels[0].begin(), b.levels[0].end());
    EXPECT_EQ(parts[0].hi, *most);
    EXPECT_EQ(parts[1].lo, *least);
    const auto ray = parts[0].codes.begin() + std::ptrdiff_t{11 * kSamplesPerRay};
    EXPECT_EQ(*std::max_element(ray, ray + 16), 255);
}

// Their rays are kept for the next one: a thread that has seen none finds the same.
TEST(BrickRays, OfOneValueAreThoseOfABrickAlone) {
    struct Brick {
        glm::ivec3 size;
        float value, levels;
    };
    const std::vector<Brick> bricks = {
        {{32, 32, 32}, 5, 5},  {{32, 32, 32}, -7, -7}, {{32, 32, 32}, -7, -7}, {{32, 32, 32}, -7, 1},
        {{32, 32, 9}, -7, -7}, {{9, 32, 32}, -7, -7},  {{32, 32, 32}, 0, 0},   {{32, 32, 32}, -0.f, -0.f}};
    for (const Brick& brick : bricks) {
        Blobs b(brick.size, 1);
        for (std::vector<float>& level : b.levels)
            std::fill(level.begin(), level.end(), &level == &b.levels[0] ? brick.value : brick.levels);
        const auto rays = sampleRays(b.fields());
        std::array<BrickRayPart, kBrickRayParts> alone;
        std::thread([&] { alone = sampleRays(b.fields()); }).join();
        for (std::size_t part = 0; part < rays.size(); ++part) {
            std::array<std::uint8_t, kBrickRayBytes> bytes{}, expected{};
            encode(rays[part], bytes);
            encode(alone[part], expected);
            EXPECT_EQ(bytes, expected) << brick.size.x << " " << brick.value << " " << brick.levels;
            EXPECT_EQ(rays[part].lo, std::min(brick.value, brick.levels));
            EXPECT_EQ(rays[part].hi, std::max(brick.value, brick.levels));
        }
    }
}

} // namespace
} // namespace tessera
