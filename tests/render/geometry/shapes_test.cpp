// tests/render/geometry/shapes_test.cpp: rays meet triangles and tubes where they are: against every triangle
// without a tree, across edges and corners, closed forms, order, budgets.
#include "core/base/error.h"
#include "render/geometry/box_tree.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/shape_group.h"
#include "render/geometry/triangle_hit.h"
#include "render/geometry/tube_shape.h"
#include "tests/support/mesh_shapes.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace tessera {
namespace {

using namespace tessera::test;

constexpr double kAll = std::numeric_limits<double>::max();

struct Ram {
    MemoryBudget budget{"RAM", "--ram", std::size_t{256} << 20};
};

std::vector<ShapeHit> allHits(const Shape& shape, const ShapeRay& ray, const HitFilter& filter = {}) {
    std::vector<ShapeHit> hits;
    HitOrder after{-kAll, 0};
    for (ShapeHit hit; hits.size() < 100000 && shape.next(ray, after, kAll, filter, hit); after = hit.at)
        hits.push_back(hit);
    return hits;
}

std::vector<HitOrder> withoutTree(const TriangleMesh& mesh, const ShapeRay& ray) {
    const ShearedRay sheared(ray.origin, ray.direction);
    std::vector<HitOrder> hits;
    for (std::uint32_t n = 0; n < mesh.triangles.size(); ++n) {
        const glm::uvec3& t = mesh.triangles[n];
        TriangleHit hit;
        if (meetTriangle(sheared, mesh.points[t.x], mesh.points[t.y], mesh.points[t.z], hit))
            hits.push_back({hit.t, n});
    }
    std::sort(hits.begin(), hits.end());
    return hits;
}

/// Triangles of all sizes, some of them needles, far from the origin.
TriangleMesh randomMesh(std::mt19937& random, std::size_t triangles) {
    std::uniform_real_distribution<double> place(-100, 100), size(-1, 1);
    TriangleMesh mesh;
    for (std::size_t n = 0; n < triangles; ++n) {
        const glm::dvec3 at = glm::dvec3(place(random), place(random), place(random)) + 700.0;
        const double edge = std::pow(10.0, 2 * size(random));
        for (int corner = 0; corner < 3; ++corner)
            mesh.points.emplace_back(
                at + edge * glm::dvec3(size(random), size(random), n % 7 == 0 ? 0 : size(random)));
        const auto first = static_cast<std::uint32_t>(3 * n);
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

TEST(MeshShapes, TheTreeMissesNoHit) {
    std::mt19937 random(1);
    Ram ram;
    const TriangleMesh mesh = randomMesh(random, 3000);
    const MeshShape shape(mesh, ram.budget, "a mesh");
    std::uniform_real_distribution<double> place(560, 840), slope(-1, 1);
    std::size_t met = 0;
    for (int n = 0; n < 4000; ++n) {
        ShapeRay ray{{place(random), place(random), place(random)},
                     {slope(random), slope(random), slope(random)}};
        if (n % 4 == 0) // along an axis, and along a plane of two
            ray.direction = {0, n % 8 ? 1 : slope(random), 1};
        if (n % 5 == 0)
            ray.origin *= 1000.0 / 700, ray.direction *= 1e-3;
        const std::vector<HitOrder> expected = withoutTree(mesh, ray);
        const std::vector<ShapeHit> hits = allHits(shape, ray);
        ASSERT_EQ(hits.size(), expected.size()) << n;
        for (std::size_t i = 0; i < hits.size(); ++i) {
            EXPECT_EQ(hits[i].at.t, expected[i].t);
            EXPECT_EQ(hits[i].at.part, expected[i].part);
        }
        met += hits.size();
    }
    EXPECT_GT(met, 2000u);
}

// Of a closed surface, rays from outside meet an even number of triangles, those through its edges and
// corners too: none slips through, and none counts twice.
TEST(MeshShapes, ClosedSurfacesHaveNoGaps) {
    Ram ram;
    const TriangleMesh mesh = sphereMesh({3, -2, 5}, 40, 24);
    const MeshShape shape(mesh, ram.budget, "a sphere");
    std::mt19937 random(2);
    std::uniform_real_distribution<double> weight(0, 1), slope(-1, 1);
    for (int n = 0; n < 20000; ++n) {
        const glm::uvec3& t = mesh.triangles[random() % mesh.triangles.size()];
        const glm::dvec3 a(mesh.points[t[static_cast<int>(random() % 3)]]),
            b(mesh.points[t[static_cast<int>(random() % 3)]]);
        const glm::dvec3 through = n % 2 ? a : a + weight(random) * (b - a); // a corner, or on an edge
        const glm::dvec3 direction(slope(random), slope(random), n % 3 ? slope(random) : 0);
        if (!(glm::length(direction) > 0.01))
            continue;
        const ShapeRay ray{through - 4.0 * 40.0 * glm::normalize(direction), direction};
        EXPECT_EQ(allHits(shape, ray).size() % 2, 0u) << n;
    }
}

// The edges of an even grid run through the rays: each ray meets one triangle.
TEST(MeshShapes, ARayThroughAnEdgeMeetsOneTriangle) {
    Ram ram;
    TriangleMesh mesh;
    constexpr int kCells = 8;
    for (int y = 0; y <= kCells; ++y)
        for (int x = 0; x <= kCells; ++x)
            mesh.points.emplace_back(x, y, 0.25f * static_cast<float>(x) - 3);
    for (std::uint32_t y = 0; y < kCells; ++y)
        for (std::uint32_t x = 0; x < kCells; ++x) {
            const std::uint32_t at = y * (kCells + 1) + x;
            mesh.triangles.push_back({at, at + 1, at + kCells + 2});
            if ((x + y) % 2) // turned the other way round
                mesh.triangles.push_back({at, at + kCells + 1, at + kCells + 2});
            else
                mesh.triangles.push_back({at, at + kCells + 2, at + kCells + 1});
        }
    const MeshShape shape(mesh, ram.budget, "a grid");
    for (int y = 1; y < 2 * kCells; ++y)
        for (int x = 1; x < 2 * kCells; ++x)
            for (const glm::dvec3& direction : {glm::dvec3(0, 0, 1), {0, 0, -2}, {1, 0, 8}, {0, -1, 4}}) {
                const glm::dvec3 through(0.5 * x, 0.5 * y, 0.125 * x - 3);
                const auto hits = allHits(shape, {through - direction, direction});
                ASSERT_EQ(hits.size(), 1u) << x << ", " << y;
                EXPECT_NEAR(hits[0].at.t, 1, 1e-12);
            }
}

TEST(MeshShapes, HitsComeInOrderAndEqualOnesByNumber) {
    Ram ram;
    TriangleMesh mesh = quadMesh({0, 0, 2}, {4, 0, 0}, {0, 4, 0});
    mesh.triangles.push_back(mesh.triangles[0]); // once more, and once turned
    mesh.triangles.push_back({0, 2, 1});
    const MeshShape shape(mesh, ram.budget, "quads");
    const ShapeRay ray{{3, 1, 0}, {0, 0, 1}};
    std::vector<std::uint32_t> parts;
    for (const ShapeHit& hit : allHits(shape, ray)) {
        EXPECT_EQ(hit.at.t, 2);
        parts.push_back(hit.at.part);
    }
    EXPECT_THAT(parts, testing::ElementsAre(0, 2, 3));
    ShapeHit hit;
    EXPECT_FALSE(shape.next(ray, {-kAll, 0}, 2, {}, hit)) << "nothing before 2";
    EXPECT_FALSE(shape.next(ray, {2, 3}, kAll, {}, hit)) << "nothing behind the last";
    const HitFilter none{[](const void*, double t) { return t > 2; }, nullptr};
    EXPECT_TRUE(allHits(shape, ray, none).empty());
}

// No plane parts them.
TEST(MeshShapes, AThousandOfOnePlaceAreAllMet) {
    Ram ram;
    TriangleMesh mesh = quadMesh({0, 0, 2}, {4, 0, 0}, {0, 4, 0});
    mesh.triangles.assign(1000, mesh.triangles[0]);
    const MeshShape shape(mesh, ram.budget, "triangles");
    std::uint32_t part = 0;
    for (const ShapeHit& hit : allHits(shape, {{3, 1, 0}, {0, 0, 1}}))
        EXPECT_EQ(hit.at.part, part++);
    EXPECT_EQ(part, 1000u);
}

TEST(MeshShapes, ATriangleFromItsEdgeIsNotMet) {
    Ram ram;
    const MeshShape shape(quadMesh({0, 0, 2}, {4, 0, 0}, {0, 4, 0}), ram.budget, "a quad");
    EXPECT_TRUE(allHits(shape, {{-1, 1, 2}, {1, 0, 0}}).empty());
    EXPECT_EQ(allHits(shape, {{-1, 1.5, 2 - 1e-9}, {1, 0, 1e-9}}).size(), 1u) << "all but from its edge";
}

TEST(MeshShapes, NormalsOfTheFileAreInterpolated) {
    Ram ram;
    TriangleMesh mesh = sphereMesh({0, 0, 0}, 10, 16);
    for (const glm::vec3& p : mesh.points)
        mesh.normals.push_back(glm::normalize(p));
    const MeshShape shape(mesh, ram.budget, "a sphere");
    std::mt19937 random(3);
    std::uniform_real_distribution<double> slope(-1, 1);
    for (int n = 0; n < 500; ++n) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(slope(random), slope(random), slope(random)));
        const auto hits = allHits(shape, {glm::dvec3(0), d});
        ASSERT_FALSE(hits.empty());
        EXPECT_GT(glm::dot(glm::normalize(hits.back().normal), d), 0.9999);
    }
}

TEST(MeshShapes, MemoryIsChargedBeforeItIsTaken) {
    const TriangleMesh mesh = sphereMesh({0, 0, 0}, 1, 40);
    MemoryBudget large("RAM", "--ram", MeshShape::bytesFor(mesh));
    {
        const MeshShape shape(mesh, large, "a sphere");
        EXPECT_EQ(shape.bytes(), large.usedBytes());
        EXPECT_GE(shape.bytes(), mesh.bytes());
    }
    EXPECT_EQ(large.usedBytes(), 0u);
    MemoryBudget small("RAM", "--ram", MeshShape::bytesFor(mesh) - 1);
    EXPECT_THROW(MeshShape(mesh, small, "a sphere"), InputError);
    EXPECT_EQ(small.usedBytes(), 0u);
}

TEST(MeshShapes, TreesOfFewTrianglesTakeNoMoreThanIsSaid) {
    TriangleMesh mesh;
    mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    for (std::size_t count = 1; count < 40; ++count) {
        mesh.triangles.push_back(count % 2 ? glm::uvec3(0, 1, 2) : glm::uvec3(1, 3, 2));
        EXPECT_LE(BoxTree(mesh).bytes(), BoxTree::bytesFor(count)) << count;
    }
}

/// The distance of a point to a line through points.
double distanceTo(const std::vector<glm::dvec3>& points, const glm::dvec3& p) {
    double least = glm::length(p - points[0]);
    for (std::size_t n = 0; n + 1 < points.size(); ++n) {
        const glm::dvec3 way = points[n + 1] - points[n];
        const double along = std::clamp(glm::dot(p - points[n], way) / glm::dot(way, way), 0.0, 1.0);
        least = std::min(least, glm::length(p - points[n] - along * way));
    }
    return least;
}

// Surfaces lie where the distance to the line is the radius; between the first and the second a ray is
// inside, between the second and the third outside.
TEST(Tubes, SurfacesAreAtTheRadius) {
    Ram ram;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-20, 20), slope(-1, 1);
    std::size_t met = 0, many = 0;
    for (const int count : {1, 2, 3, 40, 70}) {
        Tube tube{{}, 1.75};
        for (int n = 0; n < count; ++n)
            tube.points.emplace_back(0.5 * place(random), 0.5 * place(random), 0.5 * place(random));
        const TubeShape shape(tube, ram.budget);
        EXPECT_EQ(shape.parts(), static_cast<std::size_t>(std::max(1, count - 1)));
        for (int n = 0; n < 3000; ++n) {
            const ShapeRay ray{{place(random), place(random), -60},
                               {0.3 * slope(random), 0.3 * slope(random), 1}};
            const auto hits = allHits(shape, ray);
            ASSERT_EQ(hits.size() % 2, 0u);
            const auto at = [&](double t) { return distanceTo(tube.points, ray.origin + t * ray.direction); };
            for (std::size_t i = 0; i < hits.size(); ++i) {
                EXPECT_NEAR(at(hits[i].at.t), tube.radiusMm, 1e-9);
                EXPECT_NEAR(glm::length(hits[i].normal), tube.radiusMm, 1e-9);
                if (i + 1 < hits.size()) {
                    const double middle = 0.5 * (hits[i].at.t + hits[i + 1].at.t);
                    EXPECT_EQ(at(middle) < tube.radiusMm, i % 2 == 0);
                }
            }
            for (double t = 0; t < 120; t += 0.5) { // nothing of it is missed
                const auto before = std::count_if(hits.begin(), hits.end(),
                                                  [&](const ShapeHit& hit) { return hit.at.t < t; });
                if (std::abs(at(t) - tube.radiusMm) > 1e-6) {
                    ASSERT_EQ(at(t) < tube.radiusMm, before % 2 == 1);
                }
            }
            met += hits.size();
            many += hits.size() > 2;
        }
    }
    EXPECT_GT(met, 3000u);
    EXPECT_GT(many, 100u);
}

// A square and a line beside it as one surface, twice in a group: both are where the distance to the nearer
// one is the radius, in their own colours, each place once for each member.
TEST(Tubes, ContoursOfAGroup) {
    Ram ram;
    const std::vector<glm::dvec3> square{
        {-20, -20, 1}, {20, -20, 1}, {20, 20, 1}, {-20, 20, 1}, {-20, -20, 1}},
        line{{-30, 0, 4}, {-5, 3, 0}, {30, 0, 4}}, ball{{3, 4, 20}};
    Tube tube{square, 2};
    tube.points.insert(tube.points.end(), line.begin(), line.end());
    tube.points.insert(tube.points.end(), ball.begin(), ball.end());
    const std::vector<std::uint32_t> ends{5, 8, 9};
    std::vector<ShapeGroup::Member> members;
    members.push_back({std::make_unique<const TubeShape>(tube, ends, ram.budget), glm::dvec3(1, 0, 0)});
    members.push_back({std::make_unique<const TubeShape>(tube, ends, ram.budget), glm::dvec3(0, 1, 0)});
    const ShapeGroup group(std::move(members));
    EXPECT_EQ(group.parts(), 2u * (4 + 2 + 1));
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(-35, 35), slope(-0.3, 0.3);
    std::size_t met = 0;
    for (int n = 0; n < 5000; ++n) {
        const ShapeRay ray{{place(random), place(random), -60}, {slope(random), slope(random), 1}};
        const auto at = [&](double t) {
            const glm::dvec3 p = ray.origin + t * ray.direction;
            return std::min({distanceTo(square, p), distanceTo(line, p), distanceTo(ball, p)});
        };
        const auto hits = allHits(group, ray);
        ASSERT_EQ(hits.size() % 4, 0u);
        for (std::size_t i = 0; i < hits.size(); ++i) {
            EXPECT_NEAR(at(hits[i].at.t), tube.radiusMm, 1e-9);
            EXPECT_EQ(hits[i].at.t, hits[i / 2 * 2].at.t);
            ASSERT_TRUE(hits[i].colour);
            EXPECT_EQ(*hits[i].colour, i % 2 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0));
        }
        for (double t = 30; t < 90; t += 0.25) { // nothing of it is missed
            const auto before =
                std::count_if(hits.begin(), hits.end(), [&](const ShapeHit& hit) { return hit.at.t < t; });
            if (std::abs(at(t) - tube.radiusMm) > 1e-6) {
                ASSERT_EQ(at(t) < tube.radiusMm, before % 4 == 2);
            }
        }
        met += hits.size();
    }
    EXPECT_GT(met, 3000u);
}

} // namespace
} // namespace tessera
