// tests/bricking/analysis/lumen_noise_test.cpp: lumens in noise, clipped as exports clip air: what is
// measured of it, what is left of it, thresholds, leaks and trees against those without it.
#include "bricking/analysis/lumen/centreline.h"
#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/seed_threshold.h"
#include "core/animation/path.h"
#include "tests/support/lumen_tubes.h"
#include "tests/support/phantom_chunks.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

constexpr std::size_t kBudget = std::size_t{512} << 20;
constexpr double kClip = -1000;

Centrelines findIn(const ChunkSource& source, const CentrelineRequest& request,
                   std::size_t budget = kBudget) {
    MemoryBudget ram("RAM", "--ram", budget);
    Progress silent;
    Centrelines found = findCentrelines(source, request, ram, silent, 2);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), budget);
    return found;
}

CentrelineRequest treeFrom(const glm::dvec3& seed) {
    CentrelineRequest request;
    request.seeds = {{seed, "--from"}};
    request.tree = true;
    return request;
}

void expectReadBack(const Centrelines& found) {
    Path path;
    path.lumen = found.lumen;
    path.lines = found.lines;
    EXPECT_NO_THROW({
        const Path again = parsePath(pathJson(path), "the path");
        EXPECT_EQ(again.lines, path.lines);
        EXPECT_EQ(again.lumen, path.lumen);
    });
}

FieldChunks airTube(double radius, const glm::dvec3& spacing = glm::dvec3(1)) {
    return {boxInfo(glm::ivec3(64.0 / spacing), spacing, glm::dvec3(-32)),
            tube({{0, 0, -40}, {0, 0, 40}}, radius, 1)};
}

TEST(LumenNoise, IsMeasuredWhetherAirIsClippedOrNot) {
    for (const double radius : {3.0, 9.0, 25.0})
        for (const glm::dvec3& spacing : {glm::dvec3(1), glm::dvec3(0.7, 0.7, 2)}) {
            const FieldChunks clean = airTube(radius, spacing);
            for (const double deviation : {0.0, 10.0, 20.0, 50.0, 100.0})
                for (const double lowest : {-3000.0, kClip}) {
                    const NoisyChunks noisy(clean, deviation, lowest);
                    MemoryBudget ram("RAM", "--ram", kBudget);
                    BrickCache cache(noisy, ram, 32u << 20, 2);
                    LumenValues values(cache, noisy.info());
                    const ValueNoise found = noiseAround(values, glm::dvec3(noisy.info().extentVoxels) / 2.0);
                    EXPECT_NEAR(found.deviation, deviation, 0.25 * deviation + 1)
                        << radius << " mm, clipped at " << lowest;
                }
        }
}

/// Of a field with noise: mean and deviation of what is left, over voxels that a test picks.
struct Left {
    double mean = 0, deviation = 0;
};
template <typename Pick> Left leftOf(const ChunkSource& source, double deviation, const Pick& pick) {
    MemoryBudget ram("RAM", "--ram", kBudget);
    LumenField field(source, ram, 2);
    field.quieten(deviation);
    LumenValues values(field.cache(), source.info());
    std::vector<double> picked;
    const glm::ivec3 n = source.info().extentVoxels;
    for (int z = 4; z < n.z - 4; ++z)
        for (int y = 4; y < n.y - 4; ++y)
            for (int x = 4; x < n.x - 4; ++x)
                if (pick(glm::ivec3(x, y, z)))
                    picked.push_back(values.voxel({x, y, z}));
    Left left;
    for (const double value : picked)
        left.mean += value / static_cast<double>(picked.size());
    for (const double value : picked)
        left.deviation += (value - left.mean) * (value - left.mean) / static_cast<double>(picked.size());
    left.deviation = std::sqrt(left.deviation);
    return left;
}

TEST(LumenNoise, IsTakenOffAndThinWallsStay) {
    // slabs of 8 voxels with walls of one voxel between them
    const auto wallAt = [](int x) { return x % 9 == 8; };
    const FieldChunks slabs(boxInfo({72, 40, 40}, glm::dvec3(1), glm::dvec3(0)), [&](const glm::dvec3& p) {
        return wallAt(static_cast<int>(p.x)) ? -500.0 : -1000.0;
    });
    for (const double deviation : {20.0, 50.0, 80.0}) {
        const NoisyChunks noisy(slabs, deviation);
        const Left air = leftOf(noisy, deviation, [&](const glm::ivec3& v) { return !wallAt(v.x); });
        EXPECT_NEAR(air.mean, -1000, 0.25 * deviation);
        EXPECT_LT(air.deviation, 0.45 * deviation);
        const Left walls = leftOf(noisy, deviation, [&](const glm::ivec3& v) { return wallAt(v.x); });
        EXPECT_NEAR(walls.mean, -500, 0.5 * deviation) << deviation;
        EXPECT_LT(walls.deviation, 0.6 * deviation);
    }
}

TEST(LumenNoise, WhatIsTakenOffDependsOnValuesAlone) {
    // whatever chunks were read before, and however little of them stays
    const FieldChunks clean = airTube(9, glm::dvec3(0.9));
    const NoisyChunks noisy(clean, 50, kClip);
    const auto sumOf = [&](std::size_t budget, bool backwards) {
        MemoryBudget ram("RAM", "--ram", budget);
        LumenField field(noisy, ram, 2);
        field.quieten(50);
        std::vector<std::byte> all;
        const glm::ivec3 grid = chunkGrid(noisy.info().extentVoxels, 0);
        const auto count = static_cast<int>(cellCount(grid));
        std::vector<std::vector<std::byte>> chunks(static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) {
            const auto chunk = static_cast<std::size_t>(backwards ? count - 1 - i : i);
            const glm::ivec3 at = gridPosition(chunk, grid);
            const ChunkPointer read = field.cache().get({0, at.x, at.y, at.z});
            chunks[chunk].assign(read->bytes.get(), read->bytes.get() + read->size);
        }
        return chunks;
    };
    EXPECT_EQ(sumOf(kBudget, false), sumOf(8u << 20, true));
}

TEST(LumenNoise, ThresholdsAreHalfWayFromEverySeed) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> any(0, 1);
    for (const double radius : {3.5, 8.0}) {
        const FieldChunks clean = airTube(radius, {0.8, 0.8, 1});
        for (const double deviation : {0.0, 20.0, 50.0, 100.0})
            for (const double lowest : {-3000.0, kClip, -1024.0}) {
                const NoisyChunks noisy(clean, deviation, lowest);
                for (int i = 0; i < (deviation == 50 ? 4 : 1); ++i) {
                    const double angle = 6.28 * any(random), away = 0.6 * radius * std::sqrt(any(random));
                    CentrelineRequest request;
                    request.seeds = {
                        {{away * std::cos(angle), away * std::sin(angle), 40 * any(random) - 20}, "--from"}};
                    const Centrelines found = findIn(noisy, request);
                    ASSERT_NEAR(found.lumen.threshold, -480, 100)
                        << "radius " << radius << ", noise " << deviation << ", clipped at " << lowest << ": "
                        << lumenText(found, "HU");
                    ASSERT_EQ(found.lumen.side, Lumen::Side::below);
                    ASSERT_GT(found.lines[0].lengthMm(), 20)
                        << "radius " << radius << ", noise " << deviation << ", clipped at " << lowest
                        << ", seed " << request.seeds[0].mm.z;
                    ASSERT_LT(apart(found.lines[0].points, {{0, 0, -40}, {0, 0, 40}}).mean, 1);
                    expectReadBack(found);
                }
            }
    }
}

TEST(LumenNoise, ALeakInNoiseIsTightenedOrSaid) {
    // as of a windpipe with a hole to a lung, in noise
    const std::vector<glm::dvec3> line = {{0, 0, 0}, {0, 0, 80}};
    const Field pipe = tube(line, 6, 1);
    const FieldChunks leaky(boxInfo({90, 60, 90}, glm::dvec3(1), {-30, -30, -5}), [=](const glm::dvec3& p) {
        const bool hole = p.x > 0 && p.x < 12 && std::abs(p.y) < 2 && std::abs(p.z - 40) < 2;
        return std::min(pipe(p), hole || p.x > 10 ? -850.0 : 40.0);
    });
    for (const double deviation : {20.0, 35.0, 50.0}) {
        const NoisyChunks noisy(leaky, deviation);
        for (const std::optional<double> threshold : {std::optional<double>(), std::optional<double>(-700)}) {
            CentrelineRequest request;
            request.seeds = {{{0, 0, 6}, "--from"}, {{0, 0, 74}, "--to"}};
            request.threshold = threshold;
            const Centrelines found = findIn(noisy, request);
            ASSERT_TRUE(found.evidence.leaksAt) << deviation;
            EXPECT_FALSE(found.evidence.leaks) << lumenText(found, "HU");
            EXPECT_NEAR(static_cast<double>(found.lumenVoxels), 3.14159 * 36 * 80, 3000) << deviation;
            // its wall is drawn where the volume's own noise does not reach
            EXPECT_EQ(found.lumen.surface.has_value(), found.lumen.noise > 0);
            EXPECT_GE(found.lumen.shownAt(), found.lumen.threshold);
            EXPECT_LE(found.lumen.shownAt(), *found.evidence.leaksAt);
            if (found.lumen.surface && !threshold) {
                EXPECT_GT(found.lumen.shownAt(), -1000 + 5 * deviation);
            }
            EXPECT_LT(apart(found.lines[0].points, line).mean, 0.7);
        }
    }
}

TEST(LumenNoise, ALeakThatNothingCloses) {
    // two seeds with a piece between them that is as dark as the lung it opens to
    const Field pipe = tube({{0, 0, 0}, {0, 0, 80}}, 6, 1);
    const FieldChunks open(boxInfo({90, 60, 90}, glm::dvec3(1), {-30, -30, -5}), [=](const glm::dvec3& p) {
        return p.z > 30 && p.z < 50 && pipe(p) < -800
                   ? -840.0
                   : std::min(pipe(p), p.x > 10 || (p.x > 0 && std::abs(p.z - 40) < 5 && std::abs(p.y) < 3)
                                           ? -850.0
                                           : 40.0);
    });
    CentrelineRequest request;
    request.seeds = {{{0, 0, 6}, "--from"}, {{0, 0, 74}, "--to"}};
    const Centrelines found = findIn(open, request);
    EXPECT_TRUE(found.evidence.leaks);
    EXPECT_TRUE(found.lumen.leaks);
    // the seed is at 6 mm, the piece that is as dark as the lung begins at 30: what is surely lumen ends
    // there
    ASSERT_TRUE(found.lumen.leavesAtMm);
    EXPECT_NEAR(*found.lumen.leavesAtMm, 24, 2);
    EXPECT_THAT(lumenText(found, "HU"), ::testing::HasSubstr("it leaks: lines may lie outside of it from 2"));
    EXPECT_THAT(doubtText(found.lumen), ::testing::HasSubstr("may have left the lumen at 2"));
    expectReadBack(found);
    std::reverse(request.seeds.begin(), request.seeds.end()); // from the other end: 74 to 50
    EXPECT_NEAR(findIn(open, request).lumen.leavesAtMm.value_or(0), 24, 2);
}

TEST(LumenNoise, TheAirwaysTreeIsThatWithoutNoise) {
    const glm::ivec3 extent(256, 192, 300);
    const PhantomChunks torso("torso", extent);
    const auto airways = torsoAirways();
    for (const double lowest : {-3000.0, kClip}) {
        const NoisyChunks noisy(torso, 50, lowest);
        const Centrelines tree = findIn(noisy, treeFrom({0, 8, 180}));
        expectReadBack(tree);
        std::vector<glm::dvec3> all;
        for (const CentreLine& line : tree.lines)
            all.insert(all.end(), line.points.begin(), line.points.end());
        int found = 0, of = 0;
        for (const PhantomCurve& tube : airways)
            if (tube.generation <= 4) {
                const glm::dvec3 most = tube.pointsMm.size() > 2
                                            ? tube.pointsMm[tube.pointsMm.size() * 3 / 4]
                                            : 0.25 * tube.pointsMm[0] + 0.75 * tube.pointsMm[1];
                double nearest = 1e300;
                for (const glm::dvec3& p : all)
                    nearest = std::min(nearest, glm::length(p - most));
                ++of;
                found += nearest < 2;
            }
        EXPECT_EQ(found, of) << lumenText(tree, "HU");
        double mean = 0, most = 0;
        for (const glm::dvec3& p : all) {
            double off = 1e300;
            for (const PhantomCurve& tube : airways)
                if (tube.generation < 2 || glm::length(tube.pointsMm.front() - p) < 60)
                    off = std::min(off, lineDistance(p, tube.pointsMm));
            mean += off / static_cast<double>(all.size());
            most = std::max(most, off);
        }
        EXPECT_LT(mean, 1);
        EXPECT_LT(most, 4) << "none in the lung";
    }
}

TEST(LumenNoise, TreesOfAnyThresholdAreReadBack) {
    const PhantomChunks torso("torso", {192, 144, 224});
    for (const double threshold : {-700.0, -800.0, -880.0})
        for (const glm::dvec3& seed : {glm::dvec3(0, 8, 180), glm::dvec3(2, 9, 150)}) {
            CentrelineRequest request = treeFrom(seed);
            request.threshold = threshold;
            request.mayLeak = true;
            expectReadBack(findIn(torso, request));
        }
}

} // namespace
} // namespace tessera::test
