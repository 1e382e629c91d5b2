// tests/bricking/analysis/mesh_parts_test.cpp: parts of a mesh that is held: what they enclose, and which
// stay.
#include "bricking/analysis/surface/mesh_parts.h"
#include "bricking/analysis/surface/simplify_mesh.h"
#include "tests/support/closed_mesh.h"
#include "tests/support/held_volume.h"
#include "tests/support/recorded_numbers.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace tessera::test {
namespace {

/// A ball with a cavity in it, and two others; smaller ones are found first.
TriangleMesh balls() {
    const HeldVolume volume({40, 24, 31}, [](const glm::ivec3& v) {
        const auto ball = [&](const glm::dvec3& middle, double radius) {
            return radius - glm::length(glm::dvec3(v) + 0.5 - middle);
        };
        const double hollow = std::min(ball({14.2, 11.1, 20.3}, 9), -ball({14.9, 10.4, 21}, 3.5));
        return std::max({hollow, ball({31.3, 15.2, 9.6}, 6), ball({8.1, 7.7, 5.2}, 2.6)});
    });
    MemoryBudget ram("RAM", "--ram", 64u << 20);
    const SurfaceLattice lattice(volume.info(), {glm::dvec3(0), glm::dvec3(volume.info().extentVoxels)}, 0,
                                 "test");
    SurfaceRequest request;
    request.threads = 1;
    HeldMesh held;
    const SurfaceCounts counts = extractSurface(volume, lattice, volume.ranges(), request, ram, held);
    HeldSurface surface(counts.points, counts.triangles);
    EXPECT_GE(HeldSurface::heldBytes(counts.points, counts.triangles),
              12 * (counts.points + counts.triangles));
    for (const glm::dvec3& p : held.points)
        surface.point(p);
    for (const Corners& t : held.triangles)
        surface.triangle({t[0], t[1], t[2]}, {});
    return surface.mesh;
}

double volumeOf(const TriangleMesh& mesh) {
    double volume = 0; // about the patient's origin
    for (const glm::uvec3& t : mesh.triangles)
        volume += glm::dot(glm::dvec3(mesh.points[t.x]),
                           glm::cross(glm::dvec3(mesh.points[t.y]), glm::dvec3(mesh.points[t.z]))) /
                  6;
    return volume;
}

double ballVolume(double radius) {
    return 4 * M_PI / 3 * radius * radius * radius;
}

void expectWhole(const TriangleMesh& mesh) {
    std::vector<bool> isUsed(mesh.points.size());
    for (const glm::uvec3& t : mesh.triangles)
        for (int i = 0; i < 3; ++i) {
            ASSERT_LT(t[i], mesh.points.size());
            isUsed[t[i]] = true;
        }
    EXPECT_EQ(std::count(isUsed.begin(), isUsed.end(), false), 0);
}

TEST(MeshParts, TheLargestIsTheOneThatEnclosesMost) {
    TriangleMesh mesh = balls();
    const std::vector<glm::vec3> before = mesh.points;
    const PartsFound all = keepParts(mesh, {});
    EXPECT_EQ(all.parts, 4u);
    EXPECT_EQ(all.kept, 4u);
    EXPECT_EQ(mesh.points, before);
    EXPECT_NEAR(measuresOf(mesh).volumeMm3, volumeOf(mesh), 1e-3);
    EXPECT_NEAR(measuresOf(mesh).areaMm2, 4 * M_PI * (81 + 12.25 + 36 + 6.76), 25);
    const PartsFound largest = keepParts(mesh, {true, 0});
    EXPECT_EQ(largest.parts, 4u);
    EXPECT_EQ(largest.kept, 1u);
    expectWhole(mesh);
    EXPECT_NEAR(volumeOf(mesh), ballVolume(9), 0.02 * ballVolume(9)) << "its cavity is filled";
    EXPECT_NEAR(measuresOf(mesh).areaMm2, 4 * M_PI * 81, 15);
    // points keep their order
    auto at = before.begin();
    for (const glm::vec3& p : mesh.points) {
        at = std::find(at, before.end(), p);
        ASSERT_NE(at, before.end());
    }
}

TEST(MeshParts, SmallOnesGo) {
    const auto kept = [](double least, bool largest = false) {
        TriangleMesh mesh = balls();
        const PartsFound found = keepParts(mesh, {largest, least});
        EXPECT_EQ(found.parts, 4u);
        expectWhole(mesh);
        return std::pair(found.kept, volumeOf(mesh));
    };
    // of 3054, 905, 180 (the cavity) and 74 mm3
    const double whole = ballVolume(9) + ballVolume(6);
    EXPECT_EQ(kept(50).first, 4u);
    EXPECT_EQ(kept(100).first, 3u);
    EXPECT_NEAR(kept(100).second, whole - ballVolume(3.5), 90);
    EXPECT_EQ(kept(300).first, 2u);
    EXPECT_NEAR(kept(300).second, whole, 90);
    EXPECT_EQ(kept(1500).first, 1u);
    EXPECT_EQ(kept(1500, true).first, 1u);
    EXPECT_EQ(kept(4000, true).first, 0u);
    EXPECT_EQ(kept(4000).second, 0);
    // one of just that volume stays
    const double own = kept(1500).second;
    EXPECT_EQ(kept(own - 1e-3).first, 1u);
    EXPECT_EQ(kept(own + 1e-3).first, 0u);
}

/// Memory that is promised for meshes.
TEST(MeshParts, BytesAreThoseOfTheRecord) {
    RecordedNumbers record("tests/bricking/analysis/recorded/mesh_bytes.txt");
    VolumeInfo info;
    info.type = ValueType::i16;
    for (const glm::ivec3& extent : {glm::ivec3(5, 7, 6), {100, 90, 60}, {300, 40, 500}}) {
        info.extentVoxels = extent;
        for (const int level : {0, 2}) {
            const SurfaceLattice lattice(info, {glm::dvec3(0), glm::dvec3(extent)}, level, "test");
            record.expect("surface",
                          {static_cast<double>(surfaceFloorBytes(info, lattice, 1)),
                           static_cast<double>(surfaceFloorBytes(info, lattice, 4))},
                          0, 0.5);
        }
    }
    record.expect("held",
                  {static_cast<double>(simplifyBytes(5000, 9990)), static_cast<double>(partsBytes(5000)),
                   static_cast<double>(HeldSurface::heldBytes(5000, 9990))},
                  0, 0.5);
}

} // namespace
} // namespace tessera::test
