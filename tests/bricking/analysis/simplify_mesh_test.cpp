// tests/bricking/analysis/simplify_mesh_test.cpp: fewer triangles: closed as before, of the same shape.
#include "bricking/analysis/surface/simplify_mesh.h"
#include "core/base/error.h"
#include "tests/support/closed_mesh.h"
#include "tests/support/held_volume.h"
#include "tests/support/recorded_numbers.h"

#include <gtest/gtest.h>

namespace tessera::test {
namespace {

HeldMesh meshOf(const HeldVolume& volume, double value) {
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    const SurfaceLattice lattice(volume.info(), {glm::dvec3(0), glm::dvec3(volume.info().extentVoxels)}, 0,
                                 "test");
    SurfaceRequest request;
    request.value = value, request.threads = 1;
    HeldMesh mesh;
    extractSurface(volume, lattice, volume.ranges(), request, ram, mesh);
    return mesh;
}

TriangleMesh asFloats(const HeldMesh& mesh) {
    TriangleMesh floats;
    for (const glm::dvec3& p : mesh.points)
        floats.points.emplace_back(p);
    for (const Corners& t : mesh.triangles)
        floats.triangles.emplace_back(t[0], t[1], t[2]);
    return floats;
}

HeldMesh held(const TriangleMesh& mesh) {
    HeldMesh out;
    for (const glm::vec3& p : mesh.points)
        out.points.emplace_back(p);
    for (const glm::uvec3& t : mesh.triangles)
        out.triangles.push_back({t.x, t.y, t.z});
    return out;
}

double simplify(TriangleMesh& mesh, std::uint64_t triangles,
                double error = std::numeric_limits<double>::infinity()) {
    const std::size_t needed = simplifyBytes(mesh.points.size(), mesh.triangles.size());
    MemoryBudget ram("RAM", "--ram", needed);
    SimplifyRequest request;
    request.mostTriangles = triangles, request.mostErrorMm = error;
    const double made = simplifyMesh(mesh, request, ram);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(made, error);
    EXPECT_EQ(faultOf(held(mesh)), "");
    return made;
}

double gyroidAt(const glm::ivec3& v, double scale) {
    const glm::dvec3 p = scale * (glm::dvec3(v) + 0.5);
    return std::sin(p.x) * std::cos(p.y) + std::sin(p.y) * std::cos(p.z) + std::sin(p.z) * std::cos(p.x);
}

TEST(SimplifyMesh, KeepsSurfacesClosedAndWhatTheyAre) {
    for (int kind = 0; kind < 4; ++kind) {
        SCOPED_TRACE(kind);
        const HeldVolume volume(glm::ivec3(24), [kind](const glm::ivec3& v) {
            switch (kind) {
            case 0:
                return gyroidAt(v, 0.3);
            case 1: // many samples of the value itself
                return std::round(8 * gyroidAt(v, 0.5)) / 4 + 0.3;
            case 2: // a border of voxels
                return glm::length(glm::dvec3(v) - 11.3) < 8 ? 1.0 : 0.0;
            default: // noise: pieces of a voxel, and all that a cell can be
                return static_cast<double>((v.x * 7919u ^ v.y * 104729u ^ v.z * 1299709u) % 17) - 8;
            }
        });
        const HeldMesh before = meshOf(volume, kind == 2 ? 0.5 : 0.3);
        const Shape shape = shapeOf(before);
        for (const double share : {0.5, 0.1, 0.0}) {
            TriangleMesh mesh = asFloats(before);
            const auto goal = static_cast<std::uint64_t>(share * static_cast<double>(mesh.triangles.size()));
            simplify(mesh, goal);
            if (share == 0.5) {
                EXPECT_LE(mesh.triangles.size(), goal);
            }
            EXPECT_GE(mesh.triangles.size() + 1, goal);
            const Shape after = shapeOf(held(mesh));
            EXPECT_EQ(after.components, shape.components);
            EXPECT_EQ(after.euler, shape.euler);
            EXPECT_TRUE(after.each);
            if (kind != 3 && share == 0.5) {
                EXPECT_NEAR(after.volume, shape.volume, 0.05 * shape.volume);
            }
        }
    }
}

TEST(SimplifyMesh, ErrorsBoundIt) {
    const HeldVolume ball(glm::ivec3(48),
                          [](const glm::ivec3& v) { return 20 - glm::length(glm::dvec3(v) - 23.4); });
    const HeldMesh before = meshOf(ball, 0);
    std::size_t last = before.triangles.size();
    for (const double error : {0.01, 0.05, 0.2}) {
        TriangleMesh mesh = asFloats(before);
        simplify(mesh, 0, error);
        EXPECT_LT(mesh.triangles.size(), 2 * last / 3) << error;
        last = mesh.triangles.size();
        for (const glm::vec3& p : mesh.points)
            EXPECT_NEAR(glm::length(glm::dvec3(p) - 23.9), 20, 2 * error + 0.01) << error;
    }
    // a flat face needs few triangles
    const HeldVolume box(glm::ivec3(30), [](const glm::ivec3&) { return 1.0; });
    TriangleMesh flat = asFloats(meshOf(box, 1));
    simplify(flat, 0, 1e-3);
    EXPECT_LT(flat.triangles.size(), 900u);
    EXPECT_NEAR(shapeOf(held(flat)).volume, 27000, 5);
}

/// Triangles, errors and places, as they are recorded: rules of the choice of edges show in these alone.
TEST(SimplifyMesh, IsThatOfTheRecord) {
    RecordedNumbers record("tests/bricking/analysis/recorded/simplified.txt");
    const HeldVolume waves({23, 19, 27}, [](const glm::ivec3& v) {
        return gyroidAt(v, 0.37) + 0.02 * v.x - 0.013 * v.y + 0.007 * v.z;
    });
    const HeldMesh before = meshOf(waves, 0.21);
    for (const auto& [goal, error] :
         {std::pair{3001.0, 1e9}, {800.0, 1e9}, {0.0, 0.06}, {0.0, 0.4}, {0.0, 1e9}}) {
        TriangleMesh mesh = asFloats(before);
        const double made = simplify(mesh, static_cast<std::uint64_t>(goal), error);
        glm::dvec3 sum(0), squares(0);
        for (const glm::vec3& p : mesh.points) {
            sum += glm::dvec3(p);
            squares += glm::dvec3(p) * glm::dvec3(p);
        }
        record.expect("mesh",
                      {static_cast<double>(mesh.triangles.size()), static_cast<double>(mesh.points.size()),
                       made, shapeOf(held(mesh)).volume, sum.x, sum.y, sum.z, squares.x, squares.y,
                       squares.z},
                      1e-4);
    }
}

TEST(SimplifyMesh, TheSameMeshGivesTheSame) {
    const HeldVolume volume(glm::ivec3(20), [](const glm::ivec3& v) { return gyroidAt(v, 0.4); });
    const HeldMesh before = meshOf(volume, 0.1);
    TriangleMesh a = asFloats(before), b = asFloats(before);
    simplify(a, 3000), simplify(b, 3000);
    EXPECT_EQ(a.points, b.points);
    EXPECT_EQ(a.triangles, b.triangles);
    MemoryBudget little("RAM", "--ram", simplifyBytes(before.points.size(), before.triangles.size()) - 1);
    TriangleMesh c = asFloats(before);
    EXPECT_THROW(simplifyMesh(c, {}, little), InputError);
    EXPECT_EQ(c.triangles.size(), before.triangles.size());
}

} // namespace
} // namespace tessera::test
