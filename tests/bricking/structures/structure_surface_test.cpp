// tests/bricking/structures/structure_surface_test.cpp: contours of structures as closed surfaces: volumes,
// places, holes, islands, tilted and uneven planes, gaps, memory.
#include "bricking/import/structures/structure_surface.h"
#include "core/base/error.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/mat3x3.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <numeric>

namespace tessera {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kPi = glm::pi<double>();

std::vector<glm::dvec3> circle(double radius, double z, const glm::dvec2& centre = {0, 0}, int points = 240) {
    std::vector<glm::dvec3> ring;
    for (int i = 0; i < points; ++i) {
        const double angle = 2 * kPi * (i + 0.3) / points;
        ring.emplace_back(centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle), z);
    }
    return ring;
}

Structure structureOf(const std::vector<std::vector<glm::dvec3>>& rings) {
    Structure structure{{5, "GTV"}, {}};
    for (const auto& ring : rings)
        structure.contours.push_back({ContourForm::ring, ring});
    return structure;
}

/// A ball of radius 20 around the origin: planes at odd numbers.
std::vector<std::vector<glm::dvec3>> ballRings(const std::function<bool(int)>& has = [](int) {
    return true;
}) {
    std::vector<std::vector<glm::dvec3>> rings;
    for (int z = -19; z <= 19; z += 2)
        if (has(z))
            rings.push_back(circle(std::sqrt(400.0 - z * z), z));
    return rings;
}

double volumeOf(const TriangleMesh& mesh) {
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles)
        sum += glm::dot(glm::dvec3(mesh.points[t.x]),
                        glm::cross(glm::dvec3(mesh.points[t.y]), glm::dvec3(mesh.points[t.z])));
    return std::abs(sum) / 6;
}

/// Every side of a triangle is a side of one other, in the other direction.
bool isClosed(const TriangleMesh& mesh) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const glm::uvec3& t : mesh.triangles)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = t[i], b = t[(i + 1) % 3];
            sides[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    return std::all_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 0; });
}

std::size_t piecesOf(const TriangleMesh& mesh) {
    std::vector<std::uint32_t> root(mesh.points.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t at) {
        while (root[at] != at)
            at = root[at] = root[root[at]];
        return at;
    };
    std::size_t pieces = root.size();
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        pieces -= a != b;
        root[a] = b;
    };
    for (const glm::uvec3& t : mesh.triangles) {
        join(t.x, t.y);
        join(t.x, t.z);
    }
    return pieces;
}

class StructureSurfaces : public testing::Test {
  protected:
    StructureSurface made(const Structure& structure, const SurfaceOptions& options = {}) {
        StructureSurface surface = surfaceOf(structure, options, ram_);
        EXPECT_EQ(ram_.usedBytes(), 0u);
        EXPECT_TRUE(isClosed(surface.mesh));
        EXPECT_EQ(surface.mesh.normals.size(), surface.mesh.points.size());
        return surface;
    }
    MemoryBudget ram_{"RAM", "--ram", std::size_t{256} << 20};
};

TEST_F(StructureSurfaces, ABallHasItsVolumeAndPlace) {
    for (const double step : {0.0, 0.5}) {
        const StructureSurface ball = made(structureOf(ballRings()), {step, 0});
        EXPECT_EQ(ball.notes.size(), 0u);
        EXPECT_EQ(piecesOf(ball.mesh), 1u);
        EXPECT_NEAR(volumeOf(ball.mesh) / (4.0 / 3 * kPi * 8000), 1, 0.02);
        double worst = 0, turned = 1;
        for (std::size_t i = 0; i < ball.mesh.points.size(); ++i) {
            const glm::dvec3 p(ball.mesh.points[i]);
            EXPECT_LE(std::abs(p.z), 20 + 1e-6); // half the spacing behind the last plane
            if (std::abs(p.z) > 18)
                continue;
            worst = std::max(worst, std::abs(glm::length(p) - 20));
            turned = std::min(turned, glm::dot(glm::normalize(p), glm::dvec3(ball.mesh.normals[i])));
        }
        EXPECT_LT(worst, step == 0 ? 0.5 : 0.25);
        EXPECT_GT(std::abs(turned), 0.9);
    }
}

/// Planes across a torus' axis: a hole in every plane, as a contour inside another or as a keyhole.
TEST_F(StructureSurfaces, ATorusHasAHole) {
    for (const bool isKeyhole : {false, true}) {
        std::vector<std::vector<glm::dvec3>> rings;
        for (double z = -7.5; z < 8; z += 1) {
            const double half = std::sqrt(64 - z * z);
            std::vector<glm::dvec3> outer = circle(20 + half, z), inner = circle(20 - half, z);
            if (isKeyhole) { // along the outer ring, over to the inner one, back, over again
                outer.push_back(outer.front());
                outer.insert(outer.end(), inner.rbegin(), inner.rend());
                outer.push_back(inner.back());
                rings.push_back(outer);
            } else {
                rings.push_back(outer);
                rings.push_back(inner);
            }
        }
        const StructureSurface torus = made(structureOf(rings));
        EXPECT_EQ(piecesOf(torus.mesh), 1u);
        EXPECT_NEAR(volumeOf(torus.mesh) / (2 * kPi * kPi * 20 * 64), 1, 0.02);
        const auto v = static_cast<long>(torus.mesh.points.size()),
                   f = static_cast<long>(torus.mesh.triangles.size());
        EXPECT_EQ(v - f / 2, 0) << "of a torus: Euler's number";
        for (const glm::vec3& p : torus.mesh.points)
            if (std::abs(p.z) < 7) {
                EXPECT_NEAR(glm::length(glm::dvec2(glm::length(glm::dvec2(p.x, p.y)) - 20, p.z)), 8, 0.5);
            }
    }
}

TEST_F(StructureSurfaces, AHoleInsideIsASurfaceOfItsOwn) {
    std::vector<std::vector<glm::dvec3>> rings = ballRings();
    for (int z = -7; z <= 7; z += 2)
        rings.push_back(circle(std::sqrt(64.0 - z * z), z));
    const StructureSurface shell = made(structureOf(rings));
    EXPECT_EQ(piecesOf(shell.mesh), 2u);
    EXPECT_NEAR(volumeOf(shell.mesh) / (4.0 / 3 * kPi * (8000 - 512)), 1, 0.02);
}

TEST_F(StructureSurfaces, IslandsMerge) {
    std::vector<std::vector<glm::dvec3>> rings;
    for (int z = 0; z < 10; ++z) {
        if (z < 5) {
            rings.push_back(circle(5, z, {-6, 0}));
            rings.push_back(circle(5, z, {6, 0}));
        } else {
            std::vector<glm::dvec3> box = {{-11, -5, z}, {11, -5, z}, {11, 5, z}, {-11, 5, z}};
            rings.push_back(box);
        }
    }
    const StructureSurface joined = made(structureOf(rings));
    EXPECT_EQ(piecesOf(joined.mesh), 1u);
    const double islands = 2 * kPi * 25, box = 220;
    EXPECT_NEAR(volumeOf(joined.mesh) / (4.5 * islands + (islands + box) / 2 + 4.5 * box), 1, 0.02);
    for (const glm::vec3& p : joined.mesh.points)
        if (p.z < 4) {
            EXPECT_GT(std::abs(p.x), 0.5) << "apart where they are two";
        }
}

TEST_F(StructureSurfaces, TiltedPlanesGiveTheTiltedSurface) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, -0.5, 0.8)), centre(30, -70, 15);
    const glm::dvec3 u = glm::normalize(glm::cross(normal, glm::dvec3(0.3, 1, 0)));
    const glm::dmat3 turn(u, glm::cross(normal, u), normal);
    std::vector<std::vector<glm::dvec3>> rings = ballRings();
    for (auto& ring : rings)
        for (glm::dvec3& point : ring) {
            point = centre + turn * point;
            point = glm::round(point * 100.0) / 100.0; // as files write them
        }
    const StructureSurface ball = made(structureOf(rings));
    EXPECT_EQ(ball.otherContours.size(), 0u);
    EXPECT_NEAR(volumeOf(ball.mesh) / (4.0 / 3 * kPi * 8000), 1, 0.02);
    for (const glm::vec3& p : ball.mesh.points)
        if (std::abs(glm::dot(glm::dvec3(p) - centre, normal)) < 18) {
            EXPECT_NEAR(glm::distance(glm::dvec3(p), centre), 20, 0.5);
        }
}

TEST_F(StructureSurfaces, UnevenPlanesAreWhereTheyAre) {
    std::vector<std::vector<glm::dvec3>> rings;
    for (const double z : {9.0, 0.0, 4.5, 1.0, 4.0}) // in any order; distances 1, 3, 0.5, 4.5, median 3
        rings.push_back(circle(10 + z, z, {100, -50}));
    const StructureSurface cone = made(structureOf(rings), {0.25, 0});
    const auto slab = [](double a, double b, double h) { return kPi * h / 3 * (a * a + a * b + b * b); };
    EXPECT_NEAR(volumeOf(cone.mesh) / (slab(10, 19, 9) + slab(10, 10, 0.5) + slab(19, 19, 1.5)), 1, 0.005);
    for (const glm::vec3& p : cone.mesh.points)
        if (p.z > 0 && p.z < 9) {
            EXPECT_NEAR(glm::distance(glm::dvec2(p.x, p.y), glm::dvec2(100, -50)), 10 + p.z, 0.05);
        }
}

TEST_F(StructureSurfaces, AGapIsJoinedUpToALimit) {
    const StructureSurface missing = made(structureOf(ballRings([](int z) { return z != 1; })));
    EXPECT_EQ(piecesOf(missing.mesh), 1u);
    EXPECT_NEAR(volumeOf(missing.mesh) / (4.0 / 3 * kPi * 8000), 1, 0.02);
    EXPECT_THAT(missing.notes, Contains(testing::AllOf(HasSubstr("\"GTV\""), HasSubstr("1 gap of up to 4 mm"),
                                                       HasSubstr("median 2 mm"))));
    const auto wide = structureOf(ballRings([](int z) { return std::abs(z) > 4; })); // 10 mm between planes
    const StructureSurface apart = made(wide);
    EXPECT_EQ(piecesOf(apart.mesh), 2u);
    EXPECT_THAT(apart.notes, Contains(testing::AllOf(HasSubstr("2 pieces"), HasSubstr("10 mm apart"))));
    for (const glm::vec3& p : apart.mesh.points)
        EXPECT_GE(std::abs(p.z), 4 - 1e-5); // half of the median distance
    EXPECT_EQ(piecesOf(made(wide, {0, 11}).mesh), 1u);
    EXPECT_EQ(piecesOf(made(structureOf(ballRings([](int z) { return z != 1; })), {0, 3}).mesh), 2u);
}

TEST_F(StructureSurfaces, WhatIsNoSurfaceStaysLines) {
    const StructureSurface one = made(structureOf({circle(10, 3), circle(4, 3)}));
    EXPECT_TRUE(one.mesh.triangles.empty());
    EXPECT_THAT(one.otherContours, testing::ElementsAre(0u, 1u));
    EXPECT_THAT(one.notes, Contains(testing::AllOf(HasSubstr("5 \"GTV\""), HasSubstr("one plane alone"))));
    Structure mixed = structureOf(ballRings());
    mixed.contours.insert(mixed.contours.begin(), {ContourForm::points, {{0, 0, 0}}});
    mixed.contours.push_back({ContourForm::line, circle(3, 5)});
    mixed.contours.push_back({ContourForm::ring, {{0, 0, 0}, {5, 0, 0}, {5, 5, 4}, {0, 5, 0}}});
    mixed.contours.push_back({ContourForm::ring, {{0, 0, 0}, {0, 5, 0}, {0, 5, 5}}});
    const StructureSurface rest = made(mixed);
    EXPECT_THAT(rest.otherContours, testing::ElementsAre(0u, 21u, 22u, 23u));
    EXPECT_THAT(rest.notes, Contains(HasSubstr("4 contours that are open")));
    EXPECT_NEAR(volumeOf(rest.mesh) / (4.0 / 3 * kPi * 8000), 1, 0.02);
    const StructureSurface none = made({{7, "needle"}, {{ContourForm::line, {{0, 0, 0}, {1, 2, 3}}}}});
    EXPECT_THAT(none.notes, Contains(HasSubstr("7 \"needle\": contours in no plane")));
    const StructureSurface flat =
        made(structureOf({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 0, 0}, {0, 0, 0}}}));
    EXPECT_EQ(flat.otherContours.size(), 2u);
}

TEST_F(StructureSurfaces, SmallStructuresGetAFinerGrid) {
    std::vector<std::vector<glm::dvec3>> rings;
    for (double z = -1.75; z < 2; z += 0.5)
        rings.push_back(circle(std::sqrt(4 - z * z), z, {33.3, -71.7}));
    const StructureSurface ball = made(structureOf(rings));
    EXPECT_NEAR(volumeOf(ball.mesh) / (4.0 / 3 * kPi * 8), 1, 0.03);
    const StructureSurface lost =
        made(structureOf({circle(0.05, 0, {0.6, 0.6}), circle(0.05, 1, {0.6, 0.6})}), {2, 0});
    EXPECT_TRUE(lost.mesh.triangles.empty());
    EXPECT_EQ(lost.otherContours.size(), 2u);
    EXPECT_THAT(lost.notes, Contains(HasSubstr("enclose no point of the grid of 2 mm")));
}

TEST_F(StructureSurfaces, MemoryIsCountedFirst) {
    const Structure ball = structureOf(ballRings());
    for (const std::size_t budget : {std::size_t{1} << 20, std::size_t{4} << 20, std::size_t{64} << 20}) {
        MemoryBudget ram("RAM", "--ram", budget);
        const StructureSurface coarse = surfaceOf(ball, {}, ram);
        EXPECT_LE(ram.peakBytes(), budget);
        EXPECT_EQ(ram.usedBytes(), 0u);
        EXPECT_GT(coarse.mesh.triangles.size(), 100u);
        EXPECT_NEAR(volumeOf(coarse.mesh) / (4.0 / 3 * kPi * 8000), 1,
                    budget > (std::size_t{2} << 20) ? 0.02 : 0.1);
        if (budget == std::size_t{1} << 20) {
            EXPECT_THAT(coarse.notes, Contains(HasSubstr("--ram")));
        }
    }
    for (const double step : {0.001, 1e-9}) {
        MemoryBudget ram("RAM", "--ram", std::size_t{16} << 20);
        try {
            surfaceOf(ball, {step, 0}, ram);
            ADD_FAILURE() << "a grid beyond memory";
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("GTV"));
        }
        EXPECT_LT(ram.peakBytes(), std::size_t{16} << 20);
    }
}

} // namespace
} // namespace tessera
