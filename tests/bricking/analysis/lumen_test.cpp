// tests/bricking/analysis/lumen_test.cpp: the parts that centre-lines are made of, each against the plain
// way: growing and graphs against a search voxel by voxel, distances against all pairs.
#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/lumen_graph.h"
#include "bricking/analysis/lumen/lumen_paths.h"
#include "bricking/analysis/lumen/lumen_shape.h"
#include "bricking/analysis/lumen/nearest_voxels.h"
#include "bricking/analysis/lumen/smooth_line.h"
#include "core/animation/path.h"
#include "core/base/interrupt.h"
#include "tests/support/lumen_tubes.h"

#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>

namespace tessera::test {
namespace {

double hash(const glm::ivec3& v) {
    std::uint32_t h = static_cast<std::uint32_t>(v.x) * 73856093u ^
                      static_cast<std::uint32_t>(v.y) * 19349663u ^
                      static_cast<std::uint32_t>(v.z) * 83492791u;
    h = (h ^ (h >> 15)) * 2246822519u;
    h = (h ^ (h >> 13)) * 3266489917u;
    return static_cast<double>(h >> 8) / (1 << 24);
}

/// Voxels of a random volume that are air; a share of 0.55 hangs together in a maze with many walls.
struct Maze {
    glm::ivec3 extent{70, 45, 52};
    double share = 0.55;
    bool air(const glm::ivec3& v) const {
        return v == glm::clamp(v, glm::ivec3(0), extent - 1) && hash(v) < share;
    }
    std::set<std::array<int, 3>> from(const glm::ivec3& seed) const {
        std::set<std::array<int, 3>> found = {{seed.x, seed.y, seed.z}};
        std::vector<glm::ivec3> open = {seed};
        while (!open.empty()) {
            const glm::ivec3 at = open.back();
            open.pop_back();
            for (int face = 0; face < 6; ++face) {
                glm::ivec3 next = at;
                next[face / 2] += face % 2 ? 1 : -1;
                if (air(next) && found.insert({next.x, next.y, next.z}).second)
                    open.push_back(next);
            }
        }
        return found;
    }
    FieldChunks chunks() const {
        return {boxInfo(extent, glm::dvec3(1), glm::dvec3(0)),
                [*this](const glm::dvec3& mm) { return air(glm::ivec3(glm::floor(mm))) ? -1000.0 : 40.0; }};
    }
    glm::ivec3 seed() const {
        for (int x = 0;; ++x)
            if (air({x, 20, 20}) && from({x, 20, 20}).size() > 100)
                return {x, 20, 20};
    }
};

GrownLumen grow(const FieldChunks& chunks, const glm::ivec3& seed, MemoryBudget& ram) {
    BrickCache cache(chunks, ram, BrickCache::floorBytes(chunks.info(), 2), 2);
    return growLumen(cache, chunks.info(), {-500, true}, seed, ram);
}

TEST(Lumen, GrowingTakesWhatHangsTogether) {
    for (const double share : {0.33, 0.4, 0.55, 0.9}) {
        const Maze maze{{70, 45, 52}, share};
        const FieldChunks chunks = maze.chunks();
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        const glm::ivec3 seed = maze.seed();
        const GrownLumen grown = grow(chunks, seed, ram);
        const auto expected = maze.from(seed);
        EXPECT_EQ(grown.count, expected.size());
        EXPECT_EQ(grown.voxels.count(), expected.size());
        for (const auto& [x, y, z] : expected)
            ASSERT_TRUE(grown.voxels.contains({x, y, z})) << share << " " << x << " " << y << " " << z;
        EXPECT_LE(chunks.read(), 3 * 2 * 2) << "each chunk once";
    }
}

TEST(Lumen, GrowingStopsAtALimit) {
    const Maze maze;
    const FieldChunks chunks = maze.chunks();
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(chunks, ram, BrickCache::floorBytes(chunks.info(), 2), 2);
    GrowLimits limits;
    limits.mostVoxels = 100;
    const GrownLumen grown = growLumen(cache, chunks.info(), {-500, true}, maze.seed(), ram, limits);
    EXPECT_TRUE(grown.stopped);
    EXPECT_GT(grown.count, 100u);
    EXPECT_LT(grown.count, maze.from(maze.seed()).size());
}

TEST(Lumen, BitsAreChargedAndGrowingAsksWhetherItIsWanted) {
    const Maze maze;
    const FieldChunks chunks = maze.chunks();
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(chunks, ram, BrickCache::floorBytes(chunks.info(), 2), 2);
    const std::size_t before = ram.usedBytes();
    {
        const GrownLumen grown = growLumen(cache, chunks.info(), {-500, true}, maze.seed(), ram);
        EXPECT_GE(ram.usedBytes() - before, grown.voxels.filledChunks().size() * sizeof(ChunkRows));
    }
    EXPECT_EQ(ram.usedBytes(), before);
    const Cancellation::Flag unwanted = true;
    const Cancellation cancellation(&unwanted);
    EXPECT_THROW(growLumen(cache, chunks.info(), {-500, true}, maze.seed(), ram), Cancelled);
}

TEST(Lumen, AGraphOfAnyBlocksJoinsWhatIsJoinedAtFullResolution) {
    const Maze maze{{70, 45, 52}, 0.36}; // thin ways, most of them dead ends
    const FieldChunks chunks = maze.chunks();
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    const GrownLumen grown = grow(chunks, maze.seed(), ram);
    VoxelSet all(maze.extent, ram); // all that is air, whether it hangs together or not
    for (int z = 0; z < maze.extent.z; ++z)
        for (int y = 0; y < maze.extent.y; ++y)
            for (int x = 0; x < maze.extent.x; ++x)
                if (maze.air({x, y, z}))
                    all.edit(linearIndex({x >> 5, y >> 5, z >> 5},
                                         all.chunks()))[static_cast<std::size_t>((y & 31) + 32 * (z & 31))] |=
                        1u << (x & 31);
    for (const std::uint64_t most : {1000000u, 15000u, 3000u, 500u, 80u}) {
        const LumenGraph graph(all, glm::dvec3(1), most, ram);
        const std::array<LumenNode, 1> root = {graph.nodeAt(maze.seed())};
        const LumenReach reach = searchLumen(graph, root, {}, ram);
        for (int z = 0; z < maze.extent.z; ++z)
            for (int y = 0; y < maze.extent.y; ++y)
                for (int x = 0; x < maze.extent.x; ++x) {
                    const LumenNode node = graph.nodeAt({x, y, z});
                    ASSERT_EQ(node != kNoNode, maze.air({x, y, z}));
                    ASSERT_EQ(node != kNoNode && reach.reached(node), grown.voxels.contains({x, y, z}))
                        << "blocks of " << graph.blockExtent() << " at " << x << " " << y << " " << z;
                }
        // and a chain through it goes by faces, within the set
        const LumenNode far = reach.farthest();
        const glm::ivec3 to = graph.someVoxel(far);
        const auto chain = graph.voxelChain(reach.pathTo(far), maze.seed(), to);
        EXPECT_EQ(chain.front(), maze.seed());
        EXPECT_EQ(chain.back(), to);
        for (std::size_t i = 0; i < chain.size(); ++i) {
            ASSERT_TRUE(maze.air(chain[i]));
            if (i > 0) {
                const glm::ivec3 step = glm::abs(chain[i] - chain[i - 1]);
                ASSERT_EQ(step.x + step.y + step.z, 1);
            }
        }
    }
}

TEST(Lumen, DistancesToTheWallAreExactAndAnisotropic) {
    const Maze maze{{40, 33, 37}, 0.985}; // few walls, so that distances are large
    const FieldChunks chunks = maze.chunks();
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    const GrownLumen grown = grow(chunks, maze.seed(), ram);
    const glm::dvec3 spacing(0.7, 1.1, 2.3);
    const LumenGraph graph(grown.voxels, spacing, 1000000, ram);
    ASSERT_EQ(graph.blockExtent(), 1);
    std::vector<glm::ivec3> walls;
    for (int z = -1; z <= maze.extent.z; ++z)
        for (int y = -1; y <= maze.extent.y; ++y)
            for (int x = -1; x <= maze.extent.x; ++x)
                if (!grown.voxels.contains({x, y, z}))
                    walls.emplace_back(x, y, z);
    for (LumenNode node = 0; node < graph.count(); node += 37) {
        double best = 1e300;
        for (const glm::ivec3& wall : walls)
            best = std::min(best, glm::length(glm::dvec3(wall - graph.block(node)) * spacing));
        ASSERT_NEAR(static_cast<double>(graph.wallMm(node)), best, 1e-5);
    }
}

TEST(Lumen, TheRadiusIsTheDistanceToTheSurfaceForAnyAffine) {
    // a ball in an oblique, sheared volume
    VolumeInfo info = boxInfo({60, 50, 40}, glm::dvec3(1), glm::dvec3(0));
    info.patientFromVoxel =
        patientFromVoxelOf({-20, 3, 8}, {0.68, 0.1, -0.02}, {-0.1, 0.7, 0.3}, {0.01, -0.3, 1.1});
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(30, 25, 20, 1));
    const FieldChunks chunks(info, [=](const glm::dvec3& p) {
        return std::clamp(100 * (glm::length(p - middle) - 9), -1000.0, 1000.0);
    });
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(chunks, ram, BrickCache::floorBytes(info, 2), 2);
    const LumenRule rule{0, true};
    const GrownLumen grown = growLumen(cache, info, rule, {30, 25, 20}, ram);
    const LumenShape shape(grown.voxels, info);
    LumenValues values(cache, info);
    for (const glm::dvec3& off :
         {glm::dvec3(0), {2, -1, 1}, {0, 5, 0}, {-3, 3, -4}, {7, 1, 2}, {0.3, 0.2, 8.5}})
        EXPECT_NEAR(shape.wallMm(middle + off, values, rule), 9 - glm::length(off), 0.12)
            << off.x << " " << off.y << " " << off.z;
    EXPECT_EQ(shape.wallMm(middle + glm::dvec3(10, 0, 0), values, rule), 0);
}

void set(VoxelSet& voxels, const glm::ivec3& v) {
    voxels.edit(linearIndex(
        v >> 5, voxels.chunks()))[static_cast<std::size_t>((v.y & 31) + 32 * (v.z & 31))] |= 1u << (v.x & 31);
}

/// A quarter of the rays are shorter: those within 60 degrees of a flat wall's normal meet it before twice
/// its distance, and just as many meet one of two that are parallel before one and a third of theirs.
TEST(Lumen, TheRoughRadiusIsTheLowerQuartileOfRays) {
    const glm::ivec3 extent(96);
    const VolumeInfo info = boxInfo(extent, glm::dvec3(0.5), glm::dvec3(0));
    const auto roughBetween = [&](int low, int high, const glm::dvec3& mm) {
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        VoxelSet voxels(extent, ram);
        for (int z = low; z < high; ++z)
            for (int y = 0; y < extent.y; ++y)
                for (int x = 0; x < extent.x; ++x)
                    set(voxels, {x, y, z});
        return LumenShape(voxels, info).roughRadiusMm(mm);
    };
    EXPECT_NEAR(roughBetween(40, 96, {24, 24, 24}), 2 * 4, 1.2);
    EXPECT_NEAR(roughBetween(0, 56, {24, 24, 24}), 2 * 4, 1.2);
    EXPECT_NEAR(roughBetween(40, 56, {24, 24, 24}), 4 / 0.75, 0.8);
}

/// Voxels of every border of a volume count as others do.
TEST(Lumen, TheNearestVoxelMayLieAtAnyBorder) {
    const glm::ivec3 extent(40, 37, 33);
    const VolumeInfo info = boxInfo(extent, {0.7, 1.3, 2}, {5, 6, 7});
    for (const glm::ivec3 corner : {glm::ivec3(0), extent - 1})
        for (int axis = 0; axis < 3; ++axis) {
            MemoryBudget ram("RAM", "--ram", 64u << 20);
            VoxelSet voxels(extent, ram), other(extent, ram);
            const glm::ivec3 far(20, 18, 16);
            glm::ivec3 near = far;
            near[axis] = corner[axis];
            set(voxels, far), set(voxels, near);
            const LumenShape shape(voxels, info);
            const NearestVoxel found = nearestVoxel(shape, shape.middleOf(near));
            EXPECT_EQ(found.voxel, near);
            EXPECT_NEAR(found.mm, 0, 1e-9);
            set(other, near);
            EXPECT_NEAR(nearestGap(LumenShape(other, info), shape, ram).mm, 0, 1e-9);
        }
}

TEST(Lumen, WhereTwoPartsComeNearestIsExact) {
    const Maze maze{{64, 40, 40}, 1};
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    VoxelSet a(maze.extent, ram), b(maze.extent, ram);
    std::vector<glm::ivec3> ofA, ofB;
    for (int i = 0; i < 4000; ++i) {
        const glm::ivec3 v(static_cast<int>(64 * hash({i, 1, 0})), static_cast<int>(40 * hash({i, 2, 0})),
                           static_cast<int>(40 * hash({i, 3, 0})));
        if (v.x < 25) {
            set(a, v);
            ofA.push_back(v);
        } else if (v.x > 36 + v.y / 5) {
            set(b, v);
            ofB.push_back(v);
        }
    }
    const VolumeInfo info = boxInfo(maze.extent, {0.7, 1.3, 2}, {5, 6, 7});
    const LumenShape shapeA(a, info), shapeB(b, info);
    double best = 1e300;
    for (const glm::ivec3& p : ofA)
        for (const glm::ivec3& q : ofB)
            best = std::min(best, glm::length(glm::dvec3(p - q) * glm::dvec3(0.7, 1.3, 2)));
    const Gap gap = nearestGap(shapeA, shapeB, ram);
    EXPECT_NEAR(gap.mm, best, 1e-9);
    EXPECT_NEAR(glm::length(gap.fromMm - gap.toMm), best, 1e-9);
    const glm::dvec3 place(30, 20, 20);
    best = 1e300;
    for (const glm::ivec3& p : ofA)
        best = std::min(best, glm::length(shapeA.middleOf(p) - place));
    EXPECT_NEAR(nearestVoxel(shapeA, place).mm, best, 1e-9);
}

/// Of few voxels in many chunks, from anywhere: the nearest need not be in the nearest chunk.
TEST(Lumen, TheNearestVoxelIsThatOfAllChunks) {
    const glm::ivec3 extent(140, 75, 101);
    const VolumeInfo info = boxInfo(extent, {0.7, 1.3, 2}, {5, 6, 7});
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    VoxelSet voxels(extent, ram);
    std::vector<glm::ivec3> all;
    for (int i = 0; i < 60; ++i) {
        all.emplace_back(glm::dvec3(hash({i, 1, 5}), hash({i, 2, 5}), hash({i, 3, 5})) * glm::dvec3(extent));
        set(voxels, all.back());
    }
    const LumenShape shape(voxels, info);
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 mm =
            shape.mmOf(glm::dvec3(hash({i, 4, 5}), hash({i, 5, 5}), hash({i, 6, 5})) * glm::dvec3(extent));
        double best = 1e300;
        for (const glm::ivec3& v : all)
            best = std::min(best, glm::length(shape.middleOf(v) - mm));
        const NearestVoxel found = nearestVoxel(shape, mm);
        EXPECT_NEAR(found.mm, best, 1e-9) << i;
        EXPECT_NEAR(glm::length(shape.middleOf(found.voxel) - mm), best, 1e-9);
    }
}

/// Empty and full chunks take no bits, any other its 4 KiB; slabs of 32 of them are charged.
TEST(Lumen, ChunksOfASetThatAreAllOrNothingTakeNoBits) {
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    VoxelSet voxels({96, 64, 40}, ram);
    using Kind = VoxelSet::Kind;
    const std::size_t before = ram.usedBytes();
    EXPECT_EQ(before, 3 * 2 * 2 * sizeof(std::uint32_t));
    ChunkRows rows;
    rows.fill(~0u);
    voxels.setChunk(4, rows);
    EXPECT_EQ(voxels.kind(4), Kind::all);
    EXPECT_EQ(voxels.count(4), 32768u);
    rows.fill(0);
    voxels.setChunk(5, rows);
    EXPECT_EQ(voxels.kind(5), Kind::none);
    rows[7] = 0b1011u;
    voxels.setChunk(3, rows);
    voxels.setChunk(4, rows);
    EXPECT_EQ(voxels.kind(4), Kind::some);
    EXPECT_EQ(voxels.count(4), 3u);
    EXPECT_EQ(voxels.count(), 6u);
    EXPECT_EQ(voxels.filledChunks(), (std::vector<std::size_t>{3, 4}));
    const std::size_t slab = ram.usedBytes() - before;
    EXPECT_NEAR(static_cast<double>(slab), 32 * 4096, 64);
    voxels.edit(3)[7] = 0;
    EXPECT_EQ(voxels.kind(3), Kind::some) << "until it is settled";
    voxels.settle(3);
    EXPECT_EQ(voxels.kind(3), Kind::none);
    voxels.edit(4).fill(~0u);
    voxels.settle(4);
    EXPECT_EQ(voxels.kind(4), Kind::all);
    EXPECT_EQ(voxels.row(4, 1000), ~0u);
    voxels.setAll(0);
    EXPECT_EQ(voxels.count(), 2u * 32768);
    EXPECT_EQ(ram.usedBytes() - before, slab);
    // all slots are used again before there is another slab
    for (int turn = 0; turn < 5; ++turn)
        for (std::size_t chunk = 0; chunk < 12; ++chunk)
            voxels.setChunk(chunk, turn % 2 ? ChunkRows{} : rows);
    EXPECT_EQ(ram.usedBytes() - before, slab);
}

TEST(Lumen, SmoothingKeepsBendsAndTakesRipples) {
    std::vector<glm::dvec3> circle, rippled;
    for (int i = 0; i <= 200; ++i) {
        const double angle = 0.02 * i, r = 50; // a point a millimetre
        circle.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
        rippled.push_back(circle.back() * (1 + 0.02 * std::sin(2 * 3.14159265 * i / 12.0)));
    }
    const std::vector<double> deviation(circle.size(), 10);
    const auto smooth = smoothed(circle, deviation), flat = smoothed(rippled, deviation);
    for (std::size_t i = 40; i < 160; ++i) {
        EXPECT_NEAR(glm::length(smooth[i]), 50, 0.01); // a plain mean is off by a millimetre
        EXPECT_NEAR(glm::length(flat[i]), 50, 0.05);
        EXPECT_NEAR(turnMm(circle, i, 5), 50, 1e-6);
    }
    double spacing = 0;
    const auto even = evenly(rippled, 1.7, false, spacing);
    EXPECT_LE(spacing, 1.7);
    for (std::size_t i = 0; i + 1 < even.size(); ++i)
        EXPECT_NEAR(glm::length(even[i + 1] - even[i]), spacing, 0.03);
}

TEST(Lumen, WhatIsWrittenIsReadBackWhateverTheLineDoes) {
    // lines that turn back within a step, as narrow branches make them
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 300; ++trial) {
        std::vector<glm::dvec3> line = {{0, 0, 0}};
        for (int i = 0; i < 3 + trial % 40; ++i)
            line.push_back(line.back() + (trial % 3 == 0 && i % 5 == 4 ? -0.8 : 1.0) * glm::dvec3(0.3, 0, 0) +
                           0.01 * (trial % 30) * glm::dvec3(normal(random), normal(random), normal(random)));
        const EvenSteps even = evenSteps(line, 0.5, 0.1);
        EXPECT_TRUE(stepsHold(even.mm, even.spacingMm)) << trial;
        EXPECT_EQ(even.mm.front(), line.front());
        EXPECT_LT(glm::length(even.mm.back() - line.back()), 1e-9);
        EXPECT_TRUE(std::is_sorted(even.places.begin(), even.places.end()));
        EXPECT_LE(even.spacingMm, 0.5 + 1e-9);
        for (std::size_t i = 0; i < even.mm.size(); ++i)
            EXPECT_LT(lineDistance(even.mm[i], line), 0.5);
        Path path;
        path.lines.push_back({"", even.mm, std::vector<double>(even.mm.size(), 1.0), even.spacingMm});
        EXPECT_NO_THROW(parsePath(pathJson(path), "the path"));
    }
}

} // namespace
} // namespace tessera::test
