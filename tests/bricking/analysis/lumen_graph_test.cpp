// tests/bricking/analysis/lumen_graph_test.cpp: graphs of lumens, costs of paths, rays and walls of lumens
// and lines against plain searches and formulas.
#include "bricking/analysis/lumen/lumen_graph.h"
#include "bricking/analysis/lumen/lumen_paths.h"
#include "bricking/analysis/lumen/lumen_shape.h"
#include "bricking/analysis/lumen/lumen_tree.h"
#include "bricking/analysis/lumen/smooth_line.h"
#include "bricking/analysis/lumen/wall_patches.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/phantom_chunks.h"

#include <gtest/gtest.h>
#include <map>
#include <random>

namespace tessera::test {
namespace {

using Inside = std::function<bool(const glm::ivec3&)>;

void fill(VoxelSet& voxels, const Inside& inside) {
    for (std::size_t i = 0; i < cellCount(voxels.extentVoxels()); ++i) {
        const glm::ivec3 v = gridPosition(i, voxels.extentVoxels());
        if (inside(v))
            voxels.edit(linearIndex(
                v >> 5, voxels.chunks()))[static_cast<std::size_t>((v.y & 31) + 32 * (v.z & 31))] |=
                1u << (v.x & 31);
    }
    for (const std::size_t chunk : voxels.filledChunks())
        voxels.settle(chunk);
}

const glm::ivec3 kExtent(77, 45, 39);

/// A tube of its own along each axis, and single voxels that are not inside.
bool inPipes(const glm::ivec3& v) {
    const glm::dvec3 p(v);
    const bool pipe = std::hypot(p.y - 20, p.z - 17) < 12 || std::hypot(p.x - 50, p.z - 21) < 9 ||
                      std::hypot(p.x - 14, p.y - 31) < 6;
    return pipe && normalAt(v) < 2.6;
}

/// By the blocks alone: how many voxels of each are inside.
struct PlainBlocks {
    int extent;
    int filled(const glm::ivec3& block) const {
        int count = 0;
        for (int i = 0; i < extent * extent * extent; ++i) {
            const glm::ivec3 v =
                block * extent + gridPosition(static_cast<std::size_t>(i), glm::ivec3(extent));
            count += v == glm::clamp(v, glm::ivec3(0), kExtent - 1) && inPipes(v) ? 1 : 0;
        }
        return count;
    }
    bool full(const glm::ivec3& block) const { return filled(block) == extent * extent * extent; }
};

TEST(LumenGraphs, BlocksAreTheSmallestThatAreFewEnough) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    for (const int extent : {1, 2, 4, 8}) {
        std::uint64_t met = 0;
        const glm::ivec3 grid = ceilDiv(kExtent, extent);
        for (std::size_t i = 0; i < cellCount(grid); ++i)
            met += PlainBlocks{extent}.filled(gridPosition(i, grid)) > 0 ? 1 : 0;
        EXPECT_EQ(LumenGraph(voxels, glm::dvec3(1), met, ram).blockExtent(), extent);
        EXPECT_EQ(LumenGraph(voxels, glm::dvec3(1), met - 1, ram).blockExtent(), 2 * extent);
    }
    EXPECT_EQ(LumenGraph(voxels, glm::dvec3(1), 1, ram).blockExtent(), 16) << "none is larger";
}

/// Between middles of blocks: half filled ones count as lumen, others are a quarter of a block's least edge
/// away at most, by their filling.
TEST(LumenGraphs, DistancesToTheOutsideAreThoseBetweenBlocks) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    const glm::dvec3 spacing(0.7, 1.2, 0.9);
    for (const std::uint64_t most : {6000u, 1200u}) {
        const LumenGraph graph(voxels, spacing, most, ram);
        const int n = graph.blockExtent();
        ASSERT_GT(n, 1);
        const glm::ivec3 grid = ceilDiv(kExtent, n) + 2; // one beyond on every side
        std::vector<double> filled(cellCount(grid));
        for (std::size_t i = 0; i < filled.size(); ++i)
            filled[i] = PlainBlocks{n}.filled(gridPosition(i, grid) - 1) / static_cast<double>(n * n * n);
        std::vector<bool> counts(filled.size(), false);
        for (LumenNode node = 0; node < graph.count(); ++node) { // a block of two parts counts as none
            int parts = 0;
            graph.eachNode(graph.block(node), [&](LumenNode) { ++parts; });
            const std::size_t i = linearIndex(graph.block(node) + 1, grid);
            counts[i] = parts == 1 && filled[i] >= 0.5;
        }
        float widest = 0;
        for (LumenNode node = 0; node < graph.count(); ++node) {
            const glm::ivec3 own = graph.block(node) + 1;
            const std::size_t i = linearIndex(own, grid);
            EXPECT_EQ(graph.middle(node), (glm::dvec3(own) - 0.5) * static_cast<double>(n));
            widest = std::max(widest, graph.wallMm(node));
            int parts = 0;
            graph.eachNode(graph.block(node), [&](LumenNode) { ++parts; });
            if (parts > 1) {
                EXPECT_LE(graph.wallMm(node), 0.25 * n * spacing.x);
                continue;
            }
            double best = 1e300;
            for (std::size_t j = 0; j < counts.size(); ++j)
                if (!counts[j])
                    best = std::min(best, glm::length(glm::dvec3(gridPosition(j, grid) - own) * spacing) * n);
            ASSERT_NEAR(static_cast<double>(graph.wallMm(node)),
                        counts[i] ? best : 0.25 * n * spacing.x * filled[i], 1e-4);
        }
        EXPECT_EQ(graph.widestMm(), widest);
    }
}

/// Over a face where voxels touch; diagonally where all blocks of the box between are full.
TEST(LumenGraphs, NeighboursAreThoseThatTouch) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    const glm::dvec3 spacing(0.7, 1.2, 0.9);
    for (const std::uint64_t most : {1000000u, 6000u}) {
        const LumenGraph graph(voxels, spacing, most, ram);
        const int n = graph.blockExtent();
        const PlainBlocks plain{n};
        std::vector<LumenStep> steps;
        for (LumenNode node = 0; node < graph.count(); node += 5) {
            std::map<LumenNode, double> expected;
            const glm::ivec3 own = graph.block(node);
            for (int i = 0; i < n * n * n; ++i) { // faces, voxel by voxel
                const glm::ivec3 v = own * n + gridPosition(static_cast<std::size_t>(i), glm::ivec3(n));
                if (graph.nodeAt(v) != node)
                    continue;
                for (int axis = 0; axis < 3; ++axis)
                    for (const int side : {-1, 1}) {
                        glm::ivec3 beside = v;
                        beside[axis] += side;
                        const LumenNode other = graph.nodeAt(beside);
                        if (other != kNoNode && other != node && graph.block(other) != own)
                            expected[other] = spacing[axis] * n;
                    }
            }
            if (plain.full(own))
                for (std::size_t d = 0; d < 27; ++d) {
                    const glm::ivec3 step = gridPosition(d, glm::ivec3(3)) - 1;
                    bool open = glm::dot(glm::dvec3(step), glm::dvec3(step)) > 1.5;
                    for (std::size_t c = 1; c < 8 && open; ++c)
                        open = plain.full(own + step * gridPosition(c, glm::ivec3(2)));
                    if (open)
                        expected[graph.nodeAt((own + step) * n)] =
                            n * glm::length(glm::dvec3(step) * spacing);
                }
            graph.neighbours(node, steps);
            ASSERT_EQ(steps.size(), expected.size()) << node;
            for (const LumenStep& step : steps) {
                ASSERT_TRUE(expected.contains(step.to));
                EXPECT_NEAR(static_cast<double>(step.mm), expected[step.to], 1e-4);
            }
        }
    }
}

/// The voxel of a node is the nearest to its block's centre.
TEST(LumenGraphs, ANodesVoxelIsInItsMiddle) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    for (const std::uint64_t most : {1000000u, 6000u, 700u}) {
        const LumenGraph graph(voxels, glm::dvec3(1), most, ram);
        const int n = graph.blockExtent();
        for (LumenNode node = 0; node < graph.count(); ++node) {
            const glm::ivec3 some = graph.someVoxel(node);
            ASSERT_EQ(graph.nodeAt(some), node);
            const auto away = [&](const glm::ivec3& v) {
                return glm::length(glm::dvec3(v) + 0.5 - graph.middle(node));
            };
            for (int i = 0; i < n * n * n; ++i) {
                const glm::ivec3 v =
                    graph.block(node) * n + gridPosition(static_cast<std::size_t>(i), glm::ivec3(n));
                if (graph.nodeAt(v) == node) {
                    ASSERT_GE(away(v), away(some) - 1e-9);
                }
            }
        }
    }
}

TEST(LumenGraphs, CostsAreLeastAndPathsHaveThem) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    const LumenGraph graph(voxels, {0.7, 1.2, 0.9}, 4000, ram);
    std::vector<float> perMm(graph.count());
    for (LumenNode node = 0; node < graph.count(); ++node)
        perMm[node] = 1.5F + 0.4F * static_cast<float>(normalAt({static_cast<int>(node), 3, 9}));
    const std::array<LumenNode, 2> sources = {3, graph.count() / 2};
    const LumenReach reach = searchLumen(graph, sources, perMm, ram);
    std::vector<double> cost(graph.count(), 1e30); // Bellman and Ford
    cost[sources[0]] = cost[sources[1]] = 0;
    std::vector<LumenStep> steps;
    for (bool changes = true; changes;) {
        changes = false;
        for (LumenNode node = 0; node < graph.count(); ++node) {
            graph.neighbours(node, steps);
            for (const LumenStep& step : steps)
                if (const double there =
                        cost[node] +
                        0.5 * (static_cast<double>(perMm[node]) + static_cast<double>(perMm[step.to])) *
                            static_cast<double>(step.mm);
                    there < cost[step.to] - 1e-9) {
                    cost[step.to] = there;
                    changes = true;
                }
        }
    }
    LumenNode farthest = 0;
    double most = -1;
    for (LumenNode node = 0; node < graph.count(); ++node) {
        ASSERT_EQ(reach.reached(node), cost[node] < 1e29);
        if (!reach.reached(node))
            continue;
        ASSERT_NEAR(static_cast<double>(reach.cost[node]), cost[node], 1e-4 * (1 + cost[node]));
        if (static_cast<double>(reach.cost[node]) > most) {
            most = static_cast<double>(reach.cost[node]);
            farthest = node;
        }
    }
    EXPECT_EQ(reach.farthest(), farthest);
    const std::vector<LumenNode> path = reach.pathTo(farthest);
    EXPECT_TRUE(path.front() == sources[0] || path.front() == sources[1]);
    EXPECT_EQ(path.back(), farthest);
    // a search that ends early
    const LumenReach ends = searchLumen(graph, sources, perMm, ram,
                                        [&](LumenNode node) { return node == path[path.size() / 2]; });
    EXPECT_EQ(ends.cost[path[path.size() / 2]], reach.cost[path[path.size() / 2]]);
    EXPECT_FALSE(ends.reached(farthest));
}

/// (1 - D / Dmax)^4, a hundredth of the share of the way from the root, and three thousandths.
TEST(LumenGraphs, CostsKeepPathsInTheMiddle) {
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    const LumenGraph graph(voxels, {0.7, 1.2, 0.9}, 4000, ram);
    std::vector<float> fromRoot(graph.count());
    for (LumenNode node = 0; node < graph.count(); ++node)
        fromRoot[node] =
            node % 7 == 3 ? std::numeric_limits<float>::infinity() : static_cast<float>(node % 91);
    for (const float widest : {0.5F * graph.widestMm(), 1.7F * graph.widestMm()}) {
        const std::vector<float> costs = costsPerMm(graph, fromRoot, widest);
        ASSERT_EQ(costs.size(), graph.count());
        for (LumenNode node = 0; node < graph.count(); ++node) {
            const double off =
                1 - std::min(1.0, static_cast<double>(graph.wallMm(node)) / static_cast<double>(widest));
            const double root = node % 7 == 3 ? 1 : node % 91 / 90.0;
            ASSERT_NEAR(static_cast<double>(costs[node]), std::pow(off, 4) + 0.01 * root + 0.003, 1e-5);
        }
    }
    const glm::dvec3 pitch = graph.spacingMm() * static_cast<double>(graph.blockExtent());
    for (std::size_t i = 0; i < cellCount(kExtent); i += 1999) // all over the volume
        for (const double reach : {0.0, 2.3, 6.1, 11.4}) {
            const glm::ivec3 voxel = gridPosition(i, kExtent);
            float widest = 0;
            for (LumenNode node = 0; node < graph.count(); ++node)
                if (glm::length(glm::dvec3(graph.block(node) - voxel / graph.blockExtent()) * pitch) <= reach)
                    widest = std::max(widest, graph.wallMm(node));
            EXPECT_EQ(widestNear(graph, voxel, reach), widest) << reach;
        }
}

// ---- branches

/// Lines of a tree whose trunk has a stub of a length beyond its wall.
std::size_t linesWithStub(double beyond, double radius) {
    const std::vector<glm::dvec3> trunk = {{0, 0, 2}, {0, 0, 60}},
                                  stub = {{0, 0, 30}, {5 + beyond - radius, 0, 30}};
    VolumeInfo info = boxInfo({64, 32, 128}, glm::dvec3(0.5), {-8, -8, -1});
    MemoryBudget ram("RAM", "--ram", 256u << 20);
    VoxelSet voxels(info.extentVoxels, ram);
    fill(voxels, [&](const glm::ivec3& v) {
        const glm::dvec3 p(info.patientFromVoxel * glm::dvec4(glm::dvec3(v) + 0.5, 1));
        return lineDistance(p, trunk) < 5 || lineDistance(p, stub) < radius;
    });
    const LumenGraph graph(voxels, info.spacingMm(), 1000000, ram);
    return lumenLimbs(graph, graph.nodeAt({16, 16, 8}), ram).size();
}

/// A stub is a branch if it is longer beyond its parent's wall than 3 mm, and than its width.
TEST(LumenGraphs, ShortStubsAreNoBranches) {
    EXPECT_EQ(linesWithStub(0, 1), 1u);
    EXPECT_EQ(linesWithStub(2, 1), 1u);
    EXPECT_EQ(linesWithStub(6, 1), 2u);
    EXPECT_EQ(linesWithStub(6, 3), 1u);
    EXPECT_EQ(linesWithStub(13, 3), 2u);
}

// ---- rays and walls

VolumeInfo obliqueInfo(const glm::ivec3& extent) {
    VolumeInfo info = boxInfo(extent, glm::dvec3(1), glm::dvec3(0));
    info.patientFromVoxel =
        patientFromVoxelOf({-20, 3, 8}, {0.68, 0.1, -0.02}, {-0.1, 0.9, 0.3}, {0.01, -0.3, 1.2});
    return info;
}

TEST(LumenShapes, TheNearestVoxelOutsideDecidesForAnyAffine) {
    const glm::ivec3 extent(70, 45, 41);
    const VolumeInfo info = obliqueInfo(extent);
    // a hall with single voxels of wall, and walls beyond the volume
    const auto inside = [](const glm::ivec3& v) { return normalAt(v + glm::ivec3(5)) < 3.05; };
    const FieldChunks chunks(info, [&](const glm::dvec3& mm) {
        const glm::dvec3 place(glm::inverse(info.patientFromVoxel) * glm::dvec4(mm, 1));
        return inside(glm::ivec3(glm::floor(place))) ? -1000.0 : 40.0;
    });
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    BrickCache cache(chunks, ram, BrickCache::floorBytes(info, 2), 2);
    LumenValues values(cache, info);
    VoxelSet voxels(extent, ram);
    fill(voxels, inside);
    const LumenShape shape(voxels, info);
    std::vector<glm::dvec3> walls; // middles
    for (int z = -1; z <= extent.z; ++z)
        for (int y = -1; y <= extent.y; ++y)
            for (int x = -1; x <= extent.x; ++x)
                if (!voxels.contains({x, y, z}))
                    walls.push_back(glm::dvec3(x, y, z) + 0.5);
    const LumenRule rule{-480, true};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(0, 1);
    const double thin = 4 * shape.smallestSpacingMm();
    int far = 0;
    for (int i = 0; i < 250; ++i) {
        const glm::dvec3 place = glm::dvec3(any(random), any(random), any(random)) * glm::dvec3(extent);
        const glm::dvec3 mm = shape.mmOf(place);
        if (!shape.holds(mm) || !rule.takes(values.at(place))) {
            EXPECT_EQ(shape.wallMm(mm, values, rule), 0);
            continue;
        }
        glm::dvec3 nearest(0);
        double best = 1e300;
        for (const glm::dvec3& wall : walls)
            if (const double away = glm::length(shape.mmOf(wall) - mm); away < best) {
                best = away;
                nearest = wall;
            }
        // back from there, in small steps, to where values are lumen
        double t = 1;
        while (t > 0 && !rule.takes(values.at(place + t * (nearest - place))))
            t -= 1e-3;
        const double wall = best * t;
        if (wall > thin) {
            ++far;
            EXPECT_NEAR(shape.wallMm(mm, values, rule), wall, 0.05) << i;
        } else {
            EXPECT_LT(shape.wallMm(mm, values, rule), wall + 0.05) << i;
        }
    }
    EXPECT_GT(far, 30);
}

/// The edge is half way from the lumen's value to the peak of the wall within 3 mm of the threshold.
TEST(LumenShapes, AnEdgeIsHalfWayToTheWallsPeak) {
    struct Case {
        double rise, threshold; // mm of the wall's rise, and HU
    };
    for (const Case& c : {Case{2, -900}, {2, -800}, {2.6, -950}, {7, -950}, {7, -900}}) {
        const double radius = 8, slope = 1040 / c.rise;
        const FieldChunks chunks(
            boxInfo(glm::ivec3(64), glm::dvec3(0.5), glm::dvec3(-16)), [&](const glm::dvec3& p) {
                const double r = glm::length(p);
                return r > radius + c.rise + 1.5 ? -400
                                                 : -1000 + std::clamp(slope * (r - radius), 0.0, 1040.0);
            });
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        BrickCache cache(chunks, ram, BrickCache::floorBytes(chunks.info(), 2), 2);
        LumenValues values(cache, chunks.info());
        const LumenRule rule{c.threshold, true};
        const GrownLumen grown = growLumen(cache, chunks.info(), rule, glm::ivec3(32), ram);
        const LumenShape shape(grown.voxels, chunks.info());
        const double at = radius + (c.threshold + 1000) / slope; // where the threshold is
        const double peak = std::min(radius + c.rise, at + 3);
        const double expected = std::max(0.0, radius + 0.5 * (peak - radius) - at);
        EXPECT_NEAR(shape.wallMm({0.1, 0, 0}, values, rule), at - 0.1, 0.1);
        EXPECT_NEAR(shape.edgeBeyondMm({0.1, 0, 0}, at - 0.1, values, rule, -1000), expected, 0.12)
            << c.rise << " " << c.threshold;
        // rays that go further than 1.5 wall distances do not count: here all but a few, there all
        EXPECT_EQ(shape.edgeBeyondMm({0, 0, 0}, at / 1.7, values, rule, -1000), 0);
        EXPECT_GT(shape.edgeBeyondMm({0, 0, 0}, at / 1.4, values, rule, -1000), 0.5 * expected - 1e-9);
    }
}

TEST(LumenShapes, RaysEndHalfAStepBeforeWhatIsNoLumen) {
    const VolumeInfo info = boxInfo({40, 36, 33}, {0.8, 1, 1.4}, {-3, 2, 5});
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    VoxelSet voxels(info.extentVoxels, ram);
    fill(voxels, [](const glm::ivec3& v) { return v.x >= 5 && v.x < 30; });
    const LumenShape shape(voxels, info);
    const glm::dvec3 mm = shape.mmOf({12.3, 17.2, 16.4});
    EXPECT_NEAR(shape.rayMm(mm, {1, 0, 0}, 100), (30 - 12.3) * 0.8, 0.2);
    EXPECT_NEAR(shape.rayMm(mm, {-1, 0, 0}, 100), (12.3 - 5) * 0.8, 0.2);
    EXPECT_NEAR(shape.rayMm(mm, {0, 1, 0}, 100), 36 - 17.2, 0.2);
    EXPECT_NEAR(shape.rayMm(mm, {0, 0, -1}, 100), 16.4 * 1.4, 0.2);
    EXPECT_EQ(shape.rayMm(mm, {0, 0, 1}, 7.3), 7.3) << "at most";
    EXPECT_NEAR(shape.rayMm(mm, {0.6, 0, 0.8}, 100), (30 - 12.3) * 0.8 / 0.6, 0.3);
}

// ---- lines

TEST(LumenLines, AMeanAlongALineIsGaussian) {
    std::mt19937 random(9);
    std::normal_distribution<double> normal;
    std::vector<glm::dvec3> line;
    std::vector<double> deviation;
    for (int i = 0; i < 31; ++i) {
        line.emplace_back(i + 0.3 * normal(random), normal(random), 2 * normal(random));
        deviation.push_back(i % 5 == 2 ? 0 : 0.4 + 0.11 * i);
    }
    const int n = static_cast<int>(line.size());
    const auto at = [&](int i) { // reflected at the ends, as far as there are points
        return i < 0    ? 2.0 * line[0] - line[static_cast<std::size_t>(std::min(-i, n - 1))]
               : i >= n ? 2.0 * line.back() - line[static_cast<std::size_t>(std::max(2 * (n - 1) - i, 0))]
                        : line[static_cast<std::size_t>(i)];
    };
    const std::vector<glm::dvec3> found = blurred(line, deviation);
    for (int i = 0; i < n; ++i) {
        const double sigma = deviation[static_cast<std::size_t>(i)];
        glm::dvec3 sum(0);
        double total = 0;
        for (int d = -40; d <= 40; ++d)
            if (std::abs(d) <= std::ceil(3 * sigma)) {
                const double weight = d == 0 ? 1 : std::exp(-d * d / (2 * sigma * sigma));
                sum += weight * at(i + d);
                total += weight;
            }
        EXPECT_LT(glm::length(found[static_cast<std::size_t>(i)] - sum / total), 1e-9) << i;
    }
    // 1 - (1 - G)^3
    const auto twice = blurred(found, deviation), thrice = blurred(twice, deviation),
               smooth = smoothed(line, deviation);
    for (std::size_t i = 0; i < line.size(); ++i)
        EXPECT_LT(glm::length(smooth[i] - (3.0 * found[i] - 3.0 * twice[i] + thrice[i])), 1e-9);
}

TEST(LumenLines, PlacesAreEvenAlongTheLine) {
    const std::vector<glm::dvec3> line = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {3, 4, 1}}; // of 3, 4 and 1 mm
    const auto expectPlaces = [&](double spacing, const std::vector<double>& expected) {
        const std::vector<double> places = evenPlaces(line, spacing);
        ASSERT_EQ(places.size(), expected.size()) << spacing;
        for (std::size_t i = 0; i < places.size(); ++i)
            EXPECT_NEAR(places[i], expected[i], 1e-9) << spacing;
    };
    expectPlaces(2, {0, 2 / 3.0, 1.25, 1.75, 3});
    expectPlaces(1.99, {0, 8 / 15.0, 1 + 0.2 / 4, 1 + 1.8 / 4, 1 + 3.4 / 4, 3}); // 1.6 mm
    expectPlaces(8, {0, 3});
    expectPlaces(1000, {0, 3});
    EXPECT_EQ(pointAt(line, 1.5, true), glm::dvec3(3, 2, 0));
    // Catmull and Rom: through its points, along the line between those beside them
    for (std::size_t i = 0; i < line.size(); ++i)
        EXPECT_LT(glm::length(pointAt(line, static_cast<double>(i), false) - line[i]), 1e-12);
    const double h = 1e-5;
    for (std::size_t i = 1; i + 1 < line.size(); ++i)
        for (const double side : {-h, h}) {
            const glm::dvec3 slope = (pointAt(line, static_cast<double>(i) + side, false) - line[i]) / side;
            EXPECT_LT(glm::length(slope - 0.5 * (line[i + 1] - line[i - 1])), 1e-3);
        }
    const std::vector<double> arcs = arcsOf(line);
    EXPECT_EQ(arcs, (std::vector<double>{0, 3, 7, 8}));
    EXPECT_TRUE(stepsHold({{0, 0, 0}, {0.6, 0, 0}}, 1));
    EXPECT_FALSE(stepsHold({{0, 0, 0}, {0.59, 0, 0}}, 1));
    EXPECT_FALSE(stepsHold({{0, 0, 0}, {1, 0, 0}, {0.41, 0, 0}}, 1));
}

TEST(LumenLines, ATurnHasTheRadiusOfItsCircle) {
    std::vector<glm::dvec3> line;
    for (int i = 0; i < 20; ++i)
        line.emplace_back(7 * std::cos(0.1 * i), 7 * std::sin(0.1 * i), 3);
    for (const std::size_t reach : {1u, 3u}) {
        EXPECT_TRUE(std::isinf(turnMm(line, reach - 1, reach)));
        EXPECT_NEAR(turnMm(line, reach, reach), 7, 1e-6);
        EXPECT_NEAR(turnMm(line, line.size() - 1 - reach, reach), 7, 1e-6);
        EXPECT_TRUE(std::isinf(turnMm(line, line.size() - reach, reach)));
    }
    EXPECT_TRUE(std::isinf(turnMm({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 1, 1)));
}

// ---- walls of voxels

TEST(LumenWalls, FacesAreThoseBetweenLumenAndOthers) {
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    const VolumeInfo info = obliqueInfo(kExtent);
    VoxelSet voxels(kExtent, ram);
    const auto inside = [](const glm::ivec3& v) { return inPipes(v) || v.x + v.y > 100 || v.x - v.z > 60; };
    fill(voxels, inside);
    const WallFaces wall(voxels, info.patientFromVoxel);
    for (std::size_t chunk = 0; chunk < cellCount(voxels.chunks()); ++chunk)
        for (int row = 0; row < kRowsPerChunk; ++row)
            for (int side = 0; side < kSides; ++side) {
                const glm::ivec3 at = gridPosition(chunk, voxels.chunks());
                std::uint32_t expected = 0;
                for (int x = 0; x < 32; ++x) {
                    const glm::ivec3 v = 32 * at + glm::ivec3(x, row & 31, row >> 5),
                                     beside = v + sideStep(side);
                    const bool in = beside == glm::clamp(beside, glm::ivec3(0), kExtent - 1);
                    if (voxels.contains(v) && in && !voxels.contains(beside))
                        expected |= 1u << x;
                }
                ASSERT_EQ(wall.bits(at, row, side), expected) << chunk << " " << row << " " << side;
            }
}

TEST(LumenWalls, ALineOfSightCrossesLumenAlone) {
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    VoxelSet voxels(kExtent, ram);
    fill(voxels, inPipes);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-0.02, 1.02);
    int open = 0, missed = 0;
    for (int i = 0; i < 3000; ++i) {
        const auto place = [&] {
            return glm::dvec3(any(random), any(random), any(random)) * glm::dvec3(kExtent);
        };
        const glm::dvec3 from = place(), to = i % 3 ? from + 0.2 * (place() - from) : place();
        bool free = true; // in small steps: corners of voxels may be missed
        for (int k = 0; k <= 4000 && free; ++k)
            free = voxels.containsPlace(from + (to - from) * (k / 4000.0));
        const bool found = seesThrough(voxels, from, to);
        if (!free) {
            EXPECT_FALSE(found);
        } else {
            missed += found ? 0 : 1;
        }
        open += found ? 1 : 0;
        EXPECT_EQ(seesThrough(voxels, to, from), found);
    }
    EXPECT_GT(open, 100);
    EXPECT_LE(missed, 3);
}

} // namespace
} // namespace tessera::test
