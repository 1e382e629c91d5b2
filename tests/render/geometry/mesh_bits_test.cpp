// tests/render/geometry/mesh_bits_test.cpp: voxels of meshes: which are set, by brute force and by the union
// of three ways; closed, nested and open surfaces; alphas, budgets, threads.
#include "core/base/error.h"
#include "render/geometry/mesh_bits.h"
#include "render/geometry/shape_group.h"
#include "render/geometry/tube_shape.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/voxel_checks.h"

#include <ctime>
#include <gtest/gtest.h>
#include <iostream>
#include <limits>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

struct BitsRam {
    MemoryBudget budget{"RAM", "--ram", std::size_t{1} << 30};
};

MeshBits bitsOf(const std::vector<SceneMesh>& meshes, int resolution, MemoryBudget& ram, int threads = 2) {
    return {meshes, gridAround(meshes, resolution), &ram, threads, true};
}

TriangleMesh joined(const std::vector<TriangleMesh>& meshes) {
    TriangleMesh all;
    for (const TriangleMesh& mesh : meshes) {
        const auto first = static_cast<std::uint32_t>(all.points.size());
        all.points.insert(all.points.end(), mesh.points.begin(), mesh.points.end());
        for (const glm::uvec3& t : mesh.triangles)
            all.triangles.push_back(t + first);
    }
    return all;
}

/// Triangles of all sizes and tilts, long and thin ones among them, that are in no order.
TriangleMesh scattered(unsigned seed, std::size_t triangles) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    TriangleMesh mesh;
    for (std::size_t n = 0; n < triangles; ++n) {
        const glm::dvec3 at(50 * unit(random), 50 * unit(random), 50 * unit(random));
        const double edge = std::pow(10.0, 1.3 * unit(random));
        for (int corner = 0; corner < 3; ++corner)
            mesh.points.emplace_back(
                at + edge * glm::dvec3(unit(random), n % 5 == 0 ? 0 : unit(random), unit(random)));
        const auto first = static_cast<std::uint32_t>(3 * n);
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    return mesh;
}

template <typename Visit> void forEachVoxel(const MeshBits& bits, const Visit& visit) {
    const glm::ivec3 extent = bits.grid().extent;
    for (int n = 0; n < extent.x * extent.y * extent.z; ++n)
        visit(glm::ivec3(n % extent.x, n / extent.x % extent.y, n / extent.x / extent.y), n);
}

bool same(const MeshBits& a, const MeshBits& b) {
    bool equal = a.grid().extent == b.grid().extent;
    forEachVoxel(a, [&](const glm::ivec3& i, int) {
        equal = equal && a.isSet(i) == b.isSet(i) && a.alphaOf(i) == b.alphaOf(i);
    });
    return equal;
}

TEST(MeshBits, NoHoleAndNothingBeyond) {
    BitsRam ram;
    const TriangleMesh meshes[] = {
        sphereMesh({3, -4, 5}, 20, 40), sphereMesh({3, -4, 5}, 20, 6), scattered(3, 400),
        quadMesh({0, 0, 0}, {40, 3, 1}, {-2, 30, 17}),
        joined({sphereMesh({0, 0, 0}, 20, 9), quadMesh({-20, 0, 5}, {40, 0, 0}, {0, 0.01, 0})})};
    for (const TriangleMesh& mesh : meshes)
        for (const int resolution : {16, 61, 150}) {
            const MeshBits bits = bitsOf({sceneMesh(mesh, ram.budget)}, resolution, ram.budget);
            const VoxelFaults faults = faultsOf(bits, inVoxels(mesh, bits.grid()));
            EXPECT_GT(faults.set, 0u);
            EXPECT_EQ(faults.holes, 0u) << resolution;
            EXPECT_EQ(faults.beyond, 0u) << resolution;
        }
}

/// For each axis, the slice of the depth at all centres across it (4.1 of the paper). Where rounding decides,
/// either may be.
TEST(MeshBits, AreTheUnionOfThreeWays) {
    BitsRam ram;
    for (const TriangleMesh& mesh : {sphereMesh({3, -4, 5}, 20, 25), scattered(5, 300)}) {
        const MeshBits bits = bitsOf({sceneMesh(mesh, ram.budget)}, 70, ram.budget);
        const glm::ivec3 extent = bits.grid().extent;
        std::vector<int> most(static_cast<std::size_t>(extent.x * extent.y * extent.z),
                              0); // 1: either, 2: set
        std::size_t all = 0, sure = 0;
        for (const Corners& t : inVoxels(mesh, bits.grid()))
            for (int w = 0; w < 3; ++w)
                forEachCentre(t, w, [&](const glm::ivec3& voxel, double depth, double within) {
                    if (within < -1e-9 || !std::isfinite(depth))
                        return;
                    const double off = depth - std::floor(depth);
                    const bool clear = within > 1e-9 && off > 1e-9 && off < 1 - 1e-9;
                    for (int n = clear ? 0 : -1; n <= (clear ? 0 : 1); ++n) {
                        glm::ivec3 i = voxel;
                        i[w] += n;
                        if (glm::any(glm::lessThan(i, glm::ivec3(0))) ||
                            glm::any(glm::greaterThanEqual(i, extent)))
                            continue;
                        int& kept = most[static_cast<std::size_t>((i.z * extent.y + i.y) * extent.x + i.x)];
                        kept = std::max(kept, clear ? 2 : 1);
                    }
                });
        std::size_t wrong = 0;
        forEachVoxel(bits, [&](const glm::ivec3& i, int n) {
            const int kept = most[static_cast<std::size_t>(n)];
            sure += kept == 2 ? 1 : 0;
            all += bits.isSet(i) ? 1 : 0;
            wrong += kept != 1 && bits.isSet(i) != (kept == 2) ? 1 : 0;
        });
        EXPECT_EQ(wrong, 0u);
        EXPECT_GT(sure, all * 99 / 100);
    }
}

/// Voxels that can be reached from a corner of the grid through faces.
std::vector<bool> reached(const MeshBits& bits) {
    const glm::ivec3 extent = bits.grid().extent;
    const auto index = [&](const glm::ivec3& i) {
        return static_cast<std::size_t>((i.z * extent.y + i.y) * extent.x + i.x);
    };
    std::vector<bool> seen(static_cast<std::size_t>(extent.x * extent.y * extent.z));
    std::vector<glm::ivec3> stack = {glm::ivec3(0)};
    seen[0] = true;
    while (!stack.empty()) {
        const glm::ivec3 i = stack.back();
        stack.pop_back();
        for (int side = 0; side < 6; ++side) {
            glm::ivec3 to = i;
            to[side / 2] += side % 2 == 0 ? 1 : -1;
            if (glm::any(glm::lessThan(to, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(to, extent)) ||
                seen[index(to)] || bits.isSet(to))
                continue;
            seen[index(to)] = true;
            stack.push_back(to);
        }
    }
    return seen;
}

TEST(MeshBits, ClosedSurfacesAreTightNestedOnesToo) {
    BitsRam ram;
    const auto isReached = [](const MeshBits& bits, const glm::dvec3& p) {
        const glm::ivec3 i(bits.grid().fromPatient * glm::dvec4(p, 1)), extent = bits.grid().extent;
        return bool{reached(bits)[static_cast<std::size_t>((i.z * extent.y + i.y) * extent.x + i.x)]};
    };
    for (const int rings : {12, 100}) { // triangles of several voxels, and of a fraction of one
        TriangleMesh open = sphereMesh({0, 0, 0}, 20, rings);
        std::erase_if(open.triangles, [&](const glm::uvec3& t) { return open.points[t.x].z > 12; });
        const std::vector<SceneMesh> nested = {sceneMesh(sphereMesh({0, 0, 0}, 20, rings), ram.budget),
                                               sceneMesh(sphereMesh({2, 1, 0}, 12, rings, true), ram.budget)};
        const MeshBits closed = bitsOf(nested, 60, ram.budget);
        EXPECT_TRUE(isReached(closed, {-20, -20, -20}));
        EXPECT_FALSE(isReached(closed, {0, 0, -16})) << rings; // between the two
        EXPECT_FALSE(isReached(closed, {2, 1, 0})) << rings;
        EXPECT_FALSE(closed.isSet(glm::ivec3(closed.grid().fromPatient * glm::dvec4(2, 1, 0, 1))));
        const MeshBits bowl = bitsOf({sceneMesh(open, ram.budget)}, 60, ram.budget);
        EXPECT_TRUE(isReached(bowl, {0, 0, 0})) << rings;
    }
}

TEST(MeshBits, DegenerateAndDoubleTrianglesChangeNothing) {
    BitsRam ram;
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 20, 15);
    TriangleMesh more = mesh;
    more.triangles.insert(more.triangles.end(), mesh.triangles.begin(), mesh.triangles.begin() + 50);
    for (std::uint32_t n = 0; n < 40; ++n) { // points, and lines from one to another
        more.triangles.emplace_back(n, n, n);
        more.triangles.emplace_back(n, n + 100, n);
    }
    const MeshBits plain = bitsOf({sceneMesh(mesh, ram.budget)}, 80, ram.budget);
    EXPECT_TRUE(same(plain, bitsOf({sceneMesh(more, ram.budget)}, 80, ram.budget)));
    const SceneMesh one = sceneMesh(mesh, ram.budget);
    EXPECT_TRUE(same(plain, bitsOf({one, one}, 80, ram.budget)));
    EXPECT_FALSE(same(plain, bitsOf({sceneMesh(sphereMesh({0, 0, 0}, 20, 14), ram.budget)}, 80, ram.budget)));
}

TEST(MeshBits, ThreadsChangeNothingAndBudgetsHold) {
    BitsRam ram;
    std::vector<SceneMesh> meshes = {sceneMesh(scattered(9, 20000), ram.budget),
                                     sceneMesh(scattered(10, 20000), ram.budget, 0.3),
                                     sceneMesh(scattered(11, 20000), ram.budget, 0.6)};
    const std::size_t before = ram.budget.usedBytes();
    {
        const MeshBits one = bitsOf(meshes, 128, ram.budget, 1), four = bitsOf(meshes, 128, ram.budget, 4);
        EXPECT_TRUE(same(one, four));
        EXPECT_LE(2 * one.bytes(), ram.budget.usedBytes() - before);
        EXPECT_LE(one.bytes(), MeshBits::bytesAtMost(meshes, one.grid(), true));
        EXPECT_EQ(one.bytes(), four.bytes());
    }
    EXPECT_EQ(ram.budget.usedBytes(), before);
    MemoryBudget little("RAM", "--ram", std::size_t{64} << 10);
    EXPECT_THROW(bitsOf(meshes, 128, little), InputError);
    EXPECT_EQ(little.usedBytes(), 0u);
    // Only where something is: a ball fills an eighth of the bricks around it at most.
    const MeshBits sparse = bitsOf({sceneMesh(sphereMesh({0, 0, 0}, 1, 60), ram.budget),
                                    sceneMesh(sphereMesh({50, 0, 0}, 1, 60), ram.budget)},
                                   256, ram.budget);
    EXPECT_LE(sparse.bytes(), 8 * sizeof(std::uint32_t) * 1024 + 4096u);
}

TEST(MeshBits, TranslucentMeshesKeepTheLargestAlpha) {
    BitsRam ram;
    const TriangleMesh floor = quadMesh({0, 0, 0}, {40, 0, 0}, {0, 40, 0});
    const std::vector<SceneMesh> meshes = {
        sceneMesh(floor, ram.budget, 0.4), sceneMesh(floor, ram.budget, 0.7),
        sceneMesh(floor, ram.budget, 0.2),
        sceneMesh(quadMesh({0, 0, 10}, {40, 0, 0}, {0, 40, 0}), ram.budget)};
    const MeshBits bits = bitsOf(meshes, 40, ram.budget);
    const auto at = [&](double z) {
        return glm::ivec3(bits.grid().fromPatient * glm::dvec4(20.2, 20.2, z, 1));
    };
    EXPECT_EQ(bits.alphaOf(at(0)), std::lround(255 * 0.7));
    EXPECT_FALSE(bits.isSet(at(0)));
    EXPECT_TRUE(bits.isSet(at(10)));
    EXPECT_EQ(bits.alphaOf(at(10)), 0);
    const glm::vec3 centre = glm::vec3(at(0)) + 0.5f;
    EXPECT_NEAR(bits.thickness(centre), -std::log1p(-0.7), 0.01);
    EXPECT_NEAR(bits.thickness(centre + glm::vec3(0, 0, 0.5f)), -std::log1p(-0.7) / 2, 0.01);
    EXPECT_EQ(bits.coverage(centre), 0);
}

/// A tube of a radius of several voxels lies where its axis says; one that is thinner is a line.
TEST(MeshBits, TubesAreSurfacesOrLines) {
    BitsRam ram;
    const glm::dvec3 a(0, 0, 0), b(60, 13, 27);
    for (const double radius : {9.0, 2.0, 0.05}) {
        SceneMesh mesh;
        mesh.tube = Tube{{a, b}, radius};
        mesh.shape = std::make_shared<const TubeShape>(*mesh.tube, ram.budget);
        const MeshBits bits = bitsOf({mesh}, 70, ram.budget);
        const double voxel = bits.grid().edgeMm;
        const glm::dmat4 back = glm::inverse(bits.grid().fromPatient);
        double most = 0;
        std::size_t count = 0;
        forEachVoxel(bits, [&](const glm::ivec3& i, int) {
            if (!bits.isSet(i))
                return;
            const glm::dvec3 p(back * glm::dvec4(glm::dvec3(i) + 0.5, 1));
            most = std::max(most, std::abs(distanceTo(Corners{a, b, b}, p) - radius));
            ++count;
        });
        EXPECT_LE(most, (std::sqrt(0.75) + 0.25) * voxel) << radius;
        EXPECT_GE(count, 60u) << radius;
    }
}

TEST(MeshBits, DistancesNeverLie) {
    BitsRam ram;
    const MeshBits bits = bitsOf({sceneMesh(sphereMesh({0, 0, 0}, 20, 40), ram.budget),
                                  sceneMesh(quadMesh({-50, 0, 0}, {0, 3, 0}, {0, 0, 3}), ram.budget, 0.5)},
                                 120, ram.budget);
    std::mt19937 random(4);
    const glm::vec3 extent(bits.grid().extent);
    std::uniform_real_distribution<float> unit(0, 1), side(-1, 1);
    int far = 0;
    for (int n = 0; n < 20000; ++n) {
        const glm::vec3 p = extent * glm::vec3(unit(random), unit(random), unit(random));
        const int clear = bits.clearVoxels(p);
        far = std::max(far, clear);
        for (int k = 0; clear > 0 && k < 8; ++k) {
            const glm::vec3 q = p + float(clear) * glm::vec3(side(random), side(random), side(random));
            ASSERT_EQ(bits.coverage(q) + bits.thickness(q), 0);
        }
    }
    EXPECT_GT(far, 16);
}

/// TESSERA_TELL=1 tells of the processor's seconds.
TEST(MeshBits, AMillionTriangles) {
    if (!std::getenv("TESSERA_TELL"))
        GTEST_SKIP() << "TESSERA_TELL=1 tells of seconds";
    BitsRam ram;
    const SceneMesh mesh = sceneMesh(sphereMesh({0, 0, 0}, 100, 501), ram.budget);
    for (const int resolution : {64, 128, 256, 512}) {
        const auto start = std::clock();
        const MeshBits bits = bitsOf({mesh}, resolution, ram.budget, 2);
        std::cout << resolution << ": " << double(std::clock() - start) / CLOCKS_PER_SEC << " s of "
                  << mesh.shape->parts() << " triangles, " << bits.count() << " voxels, " << bits.bytes()
                  << " bytes\n";
    }
}

} // namespace
} // namespace tessera
