// tests/render/geometry/shape_forms_test.cpp: shapes against closed forms and plain sums: where a tube is
// met, what shapes say of themselves, light past several of them, and how few triangles a ray looks at.
#include "core/base/error.h"
#include "render/geometry/box_tree.h"
#include "render/geometry/mesh_shape.h"
#include "render/geometry/shape_group.h"
#include "render/geometry/shape_shade.h"
#include "render/geometry/triangle_hit.h"
#include "render/geometry/tube_shape.h"
#include "tests/support/mesh_shapes.h"

#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace tessera::test {
namespace {

constexpr double kEndless = std::numeric_limits<double>::max();

struct Met {
    double t;
    std::uint32_t part;
};
std::vector<Met> metBy(const Shape& shape, const ShapeRay& ray) {
    std::vector<Met> met;
    HitOrder after{-kEndless, 0};
    for (ShapeHit hit; met.size() < 10000 && shape.next(ray, after, kEndless, {}, hit); after = hit.at)
        met.push_back({hit.at.t, hit.at.part});
    return met;
}
std::vector<double> placesOf(const std::vector<Met>& met) {
    std::vector<double> places;
    for (const Met& one : met)
        places.push_back(one.t);
    return places;
}

// A capsule from (1, 2, 3), 10 long, of radius 2: along each axis, by rays of any length of direction.
TEST(TubeForms, ACapsuleIsMetWhereItsFormulaSays) {
    MemoryBudget ram("RAM", "--ram", 1 << 20);
    const double cap = std::sqrt(3.0); // half of the chord of a ball of radius 2, 1 off its middle
    struct Row {
        glm::dvec3 from, direction; // in the capsule's axes: along, and two across
        std::vector<double> met;
    };
    const std::vector<Row> rows = {
        {{3, 0, -10}, {0, 0, 1}, {8, 12}},              // across the cylinder
        {{3, 0, -10}, {0, 0, 4}, {2, 3}},               // in the direction's own lengths
        {{3, 1, 10}, {0, 0, -1}, {10 - cap, 10 + cap}}, // 1 beside its axis
        {{3, 1.99, -10}, {0, 0, 1}, {10 - std::sqrt(4 - 1.99 * 1.99), 10 + std::sqrt(4 - 1.99 * 1.99)}},
        {{3, 2.01, -10}, {0, 0, 1}, {}},
        {{-10, 0, 0}, {1, 0, 0}, {8, 22}},              // along its axis, from cap to cap
        {{30, 0, 0}, {-2, 0, 0}, {9, 16}},              // and back
        {{-10, 0, 1}, {1, 0, 0}, {10 - cap, 20 + cap}}, // beside the axis
        {{-10, 2.01, 0}, {1, 0, 0}, {}},
        {{-1, 0, -10}, {0, 0, 1}, {10 - cap, 10 + cap}},     // through the first ball alone
        {{11, 0, -10}, {0, 1e-30, 1}, {10 - cap, 10 + cap}}, // the last
        {{-2.01, 0, -10}, {0, 0, 1}, {}},
        {{12.01, 0, -10}, {0, 0, 1}, {}},
        {{5, 0, 0}, {0, 0, 1}, {-2, 2}},                   // from within: behind the origin, too
        {{-3, -3, 0}, {1, 1, 0}, {3 - std::sqrt(2.0), 5}}, // into the first ball, out of the cylinder
    };
    for (int axis = 0; axis < 3; ++axis) {
        const auto turned = [&](const glm::dvec3& p) {
            glm::dvec3 to;
            for (int n = 0; n < 3; ++n)
                to[(axis + n) % 3] = p[n];
            return to;
        };
        const glm::dvec3 start(1, 2, 3);
        const TubeShape shape(Tube{{start, start + turned({10, 0, 0})}, 2}, ram);
        for (const Row& row : rows) {
            const auto met = metBy(shape, {start + turned(row.from), turned(row.direction)});
            ASSERT_EQ(met.size(), row.met.size()) << axis << ": " << row.from.x << " " << row.from.y;
            for (std::size_t n = 0; n < met.size(); ++n) {
                EXPECT_NEAR(met[n].t, row.met[n], 1e-9) << axis << ": " << row.from.x << " " << row.from.y;
                EXPECT_EQ(met[n].part, 0u);
            }
        }
    }
}

// A line of n points has n - 1 pieces, whatever boxes they make: each is met at its middle, and is the part.
TEST(TubeForms, EveryPieceIsMetByItsNumber) {
    MemoryBudget ram("RAM", "--ram", 1 << 22);
    for (const int pieces : {1, 15, 16, 17, 255, 256, 257, 300}) {
        Tube tube{{}, 0.25};
        for (int n = 0; n <= pieces; ++n)
            tube.points.emplace_back(2 * n, n % 2, 0.125 * n);
        const TubeShape shape(tube, ram);
        ASSERT_EQ(shape.parts(), static_cast<std::size_t>(pieces));
        for (int n = 0; n < pieces; ++n) {
            const auto met = metBy(shape, {{2 * n + 1, 0.5, -100}, {0, 0, 1}});
            ASSERT_EQ(met.size(), 2u) << n << " of " << pieces;
            EXPECT_EQ(met[0].part, static_cast<std::uint32_t>(n));
            EXPECT_EQ(met[1].part, static_cast<std::uint32_t>(n));
        }
    }
}

/// Balls of a shape, as it tells them.
std::vector<std::pair<glm::dvec3, double>> ballsOf(const Shape& shape) {
    std::vector<std::pair<glm::dvec3, double>> balls;
    shape.forEachBall([&](const glm::dvec3& at, double radius) { balls.emplace_back(at, radius); });
    return balls;
}
void expectBox(const Shape& shape, const glm::dvec3& low, const glm::dvec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(shape.box().low[axis], low[axis], 1e-6) << axis;
        EXPECT_NEAR(shape.box().high[axis], high[axis], 1e-6) << axis;
    }
}

TEST(Shapes, TellTheirBoxesBallsPartsAndBytes) {
    MemoryBudget ram("RAM", "--ram", 1 << 20);
    const Tube line{{{0, -4, 7}, {3, 5, -6}, {1, 2, 8}}, 1.5};
    auto tube = std::make_unique<const TubeShape>(line, ram);
    expectBox(*tube, {-1.5, -5.5, -7.5}, {4.5, 6.5, 9.5});
    ASSERT_EQ(ballsOf(*tube).size(), 3u);
    for (std::size_t n = 0; n < 3; ++n)
        EXPECT_EQ(ballsOf(*tube)[n], std::pair(line.points[n], 1.5));
    EXPECT_STREQ(tube->partName(), "pieces of lines");
    EXPECT_EQ(tube->bytes(), ram.usedBytes());
    // Points, pieces of two numbers, and a box around sixteen pieces at least; and sixteen boxes more at
    // most.
    EXPECT_GE(tube->bytes(), 3 * sizeof(glm::dvec3) + 2 * 8 + sizeof(ShapeBox));
    EXPECT_LE(tube->bytes(), 3 * sizeof(glm::dvec3) + 2 * 8 + 17 * sizeof(ShapeBox));

    TriangleMesh quad = quadMesh({2, 1, -3}, {4, 0, 0}, {0, 0, 20});
    quad.points.emplace_back(900, 900, 900); // of no triangle
    auto mesh = std::make_unique<const MeshShape>(quad, ram, "a quad");
    expectBox(*mesh, {2, 1, -3}, {6, 1, 17});
    EXPECT_EQ(mesh->parts(), 2u);
    EXPECT_STREQ(mesh->partName(), "triangles");
    EXPECT_EQ(ram.usedBytes(), tube->bytes() + mesh->bytes());
    std::vector<std::pair<glm::dvec3, double>> corners = ballsOf(*mesh);
    ASSERT_EQ(corners.size(), 6u) << "those of each triangle";
    for (const auto& [at, radius] : corners) {
        EXPECT_EQ(radius, 0);
        EXPECT_LT(at.x, 900);
    }

    const std::size_t both = tube->bytes() + mesh->bytes();
    std::vector<ShapeGroup::Member> members;
    members.push_back({std::move(mesh), {}});
    members.push_back({std::move(tube), glm::dvec3(0.25)});
    const ShapeGroup group(std::move(members));
    expectBox(group, {-1.5, -5.5, -7.5}, {6, 6.5, 17});
    EXPECT_EQ(group.parts(), 4u);
    EXPECT_EQ(group.bytes(), both);
    EXPECT_EQ(ballsOf(group).size(), 9u);
    EXPECT_STREQ(group.partName(), "triangles") << "those of its first";
    ShapeHit hit;
    ASSERT_TRUE(group.next({{4, -9, 2}, {0, 1, 0}}, {-kEndless, 0}, kEndless, {}, hit));
    EXPECT_EQ(hit.colour, nullptr) << "the quad has none of its own";
}

// Hits are asked for behind a place in their order, before another, and by a filter: of several members,
// some at the same places, every hit comes once, by place and then by number.
TEST(Shapes, OfAGroupHitsComeOnceInOrder) {
    MemoryBudget ram("RAM", "--ram", 1 << 20);
    const auto layer = [&](double z) {
        return std::make_unique<const MeshShape>(quadMesh({0, 0, z}, {4, 0, 0}, {0, 4, 0}), ram, "a quad");
    };
    std::vector<ShapeGroup::Member> members;
    for (const double z : {3.0, 1.0, 3.0, 2.0})
        members.push_back({layer(z), glm::dvec3(z)});
    const ShapeGroup group(std::move(members));
    const ShapeRay ray{{3, 1, 0}, {0, 0, 1}}; // through the first triangle of each
    const auto met = metBy(group, ray);
    EXPECT_THAT(placesOf(met), testing::ElementsAre(1, 2, 3, 3));
    ASSERT_EQ(met.size(), 4u);
    EXPECT_EQ(met[0].part, 2u);
    EXPECT_EQ(met[1].part, 6u);
    EXPECT_EQ(met[2].part, 0u);
    EXPECT_EQ(met[3].part, 4u);
    ShapeHit hit;
    const auto next = [&](HitOrder after, double most, const HitFilter& filter = {}) {
        return group.next(ray, after, most, filter, hit) ? hit.at.t : -1;
    };
    EXPECT_EQ(next({1, 1}, kEndless), 1) << "part 2 is behind part 1 of its place";
    EXPECT_EQ(next({1, 2}, kEndless), 2);
    EXPECT_EQ(next({1, 2}, 2), -1) << "2 is not before 2";
    EXPECT_EQ(next({1, 2}, std::nextafter(2.0, 3.0)), 2);
    EXPECT_EQ(next({3, 3}, kEndless), 3);
    EXPECT_EQ(next({3, 4}, kEndless), -1);
    EXPECT_EQ(
        next({-kEndless, 0}, kEndless,
             {[](const void* least, double t) { return t > *static_cast<const double*>(least); }, &met[1].t}),
        3);
}

TEST(Shapes, BeginWithNoHitAtAll) {
    EXPECT_EQ(HitOrder().t, -kEndless);
    EXPECT_EQ(HitOrder().part, 0u);
    EXPECT_TRUE((HitOrder{1, 2} < HitOrder{1, 3}) && (HitOrder{1, 9} < HitOrder{2, 0}));
    EXPECT_FALSE((HitOrder{1, 2} < HitOrder{1, 2}) || (HitOrder{2, 0} < HitOrder{1, 9}));
    EXPECT_EQ(ShapeHit().normal, glm::dvec3(0));
    EXPECT_EQ(ShapeHit().colour, nullptr);
    EXPECT_EQ(ShapeRay().direction, glm::dvec3(0));
    EXPECT_TRUE(HitFilter()(3)) << "all count";
    EXPECT_EQ(TriangleHit().t + TriangleHit().u + TriangleHit().v, 0);
    EXPECT_EQ(ShadeStep().t + ShadeStep().opacity, 0);
    const ShearedRay sheared({1, 2, 3}, {0.5, -4, 1}); // along y, the steepest
    EXPECT_EQ(sheared.y * 100 + sheared.x * 10 + sheared.z, 21) << "axes after it, in turn";
    EXPECT_EQ(sheared.sheared({2, 6, 7}), glm::dvec3(4 - 4 * (1 / -4.0), 1 - 4 * (0.5 / -4.0), 4));
}

// Light past meshes: each surface strictly between two places takes its share.
TEST(Shade, IsTheProductOfWhatLiesBetween) {
    MemoryBudget ram("RAM", "--ram", 1 << 20);
    std::vector<SceneMesh> meshes;
    const auto add = [&](double z, double opacity) {
        SceneMesh& mesh = meshes.emplace_back();
        mesh.opacity = opacity;
        mesh.shape =
            std::make_shared<const MeshShape>(quadMesh({0, 0, z}, {4, 0, 0}, {0, 4, 0}), ram, "a quad");
    };
    add(5, 0.5), add(2, 0.25), add(3, 0.75);
    const ShapeRay ray{{3, 1, 0}, {0, 0, 2}}; // at 2.5, 1 and 1.5
    struct Row {
        double from, to, left;
        std::vector<double> at;
    };
    for (const Row& row :
         {Row{0, 9, 0.5 * 0.75 * 0.25, {1, 1.5, 2.5}}, Row{0, 2.5, 0.75 * 0.25, {1, 1.5}},
          Row{1, 2.5, 0.25, {1.5}}, Row{1.5, 2.5, 1, {}}, Row{2, 2.51, 0.5, {2.5}}, Row{3, 9, 1, {}}}) {
        EXPECT_DOUBLE_EQ(shadeBetween(meshes, ray, row.from, row.to), row.left) << row.from << " " << row.to;
        std::vector<ShadeStep> steps = {{99, 0.125}}; // what was there stays, and stays first
        shadeSteps(meshes, ray, row.from, row.to, steps);
        ASSERT_EQ(steps.size(), row.at.size() + 1) << row.from << " " << row.to;
        EXPECT_EQ(steps[0].t, 99);
        double left = 1;
        for (std::size_t n = 0; n < row.at.size(); ++n) {
            EXPECT_EQ(steps[n + 1].t, row.at[n]);
            left *= 1 - steps[n + 1].opacity;
        }
        EXPECT_DOUBLE_EQ(left, row.left) << "of each its own";
    }
    meshes[1].opacity = 1;
    EXPECT_EQ(shadeBetween(meshes, ray, 0, 9), 0);
}

/// Triangles that rays look at, in the mean; each ray goes on to its first hit or, `all`, to the end.
double lookedAt(const TriangleMesh& mesh, const std::vector<ShapeRay>& rays, bool all) {
    const BoxTree tree(mesh);
    std::vector<std::uint32_t> order = tree.order();
    std::sort(order.begin(), order.end());
    for (std::size_t n = 0; n < order.size(); ++n)
        EXPECT_EQ(order[n], n) << "every triangle is in one leaf";
    std::size_t looked = 0;
    for (const ShapeRay& ray : rays) {
        const ShearedRay sheared(ray.origin, ray.direction);
        double nearest = kEndless;
        tree.visit(ray, -kEndless, kEndless, [&](std::uint32_t place) {
            ++looked;
            const glm::uvec3& t = mesh.triangles[tree.order()[place]];
            TriangleHit hit;
            if (!all && meetTriangle(sheared, mesh.points[t.x], mesh.points[t.y], mesh.points[t.z], hit))
                nearest = std::min(nearest, hit.t);
            return nearest;
        });
    }
    return static_cast<double>(looked) / static_cast<double>(rays.size());
}

// What the tree is for. Without it a ray looks at all of some thousand triangles.
TEST(BoxTrees, LetARayLookAtFewTriangles) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> share(0, 1);
    TriangleMesh layers; // forty sheets, each finer along one axis, at uneven distances
    for (int sheet = 0; sheet < 40; ++sheet)
        for (int x = 0; x < 12; ++x)
            for (int y = 0; y < 5; ++y) {
                const TriangleMesh quad = quadMesh({x, 3 * y, 0.02 * sheet * sheet}, {1, 0, 0}, {0, 3, 0});
                const auto first = static_cast<std::uint32_t>(layers.points.size());
                layers.points.insert(layers.points.end(), quad.points.begin(), quad.points.end());
                for (const glm::uvec3& t : quad.triangles)
                    layers.triangles.push_back(t + first);
            }
    const TriangleMesh ball = sphereMesh({3, 4, 5}, 10, 40);
    for (int axis = 0; axis < 3; ++axis) {
        SCOPED_TRACE(axis);
        const auto turned = [&](const glm::dvec3& p) {
            glm::dvec3 to;
            for (int n = 0; n < 3; ++n)
                to[(axis + n) % 3] = p[n];
            return to;
        };
        TriangleMesh mine = layers;
        for (glm::vec3& p : mine.points)
            p = glm::vec3(turned(glm::dvec3(p)));
        std::vector<ShapeRay> along, slanted, around;
        for (int n = 0; n < 400; ++n) {
            const glm::dvec3 from(12 * share(random), 15 * share(random), -5);
            along.push_back({turned(from), turned({0, 0, n % 2 ? 1 : 2})});
            slanted.push_back({turned(from), turned({share(random) - 0.5, share(random) - 0.5, 1})});
            const glm::dvec3 way(share(random) - 0.5, share(random) - 0.5, share(random) - 0.5);
            around.push_back({glm::dvec3(3, 4, 5) - 30.0 * way, turned(way) - 0.3 * way});
        }
        // A leaf has four triangles at most: one leaf for the first sheet, and about one a sheet for all
        // forty.
        EXPECT_LE(lookedAt(mine, along, false), 4.05);
        EXPECT_LE(lookedAt(mine, along, true), 40 * 2.8);
        EXPECT_LE(lookedAt(mine, slanted, false), 3.5);
        EXPECT_LE(lookedAt(ball, around, true), 11) << "of 6240, through front and back";
    }
}

} // namespace
} // namespace tessera::test
