// tests/render/geometry/bit_rays_test.cpp: rays of light before voxelised meshes: planes do not shade
// themselves, and how near occlusion is to that of the triangles.
#include "render/geometry/bit_rays.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/voxel_checks.h"

#include <cstdlib>
#include <functional>
#include <gtest/gtest.h>
#include <iostream>
#include <numbers>
#include <random>

namespace tessera {
namespace {

using namespace tessera::test;

MemoryBudget& raysRam() {
    static MemoryBudget ram("RAM", "--ram", std::size_t{1} << 30);
    return ram;
}

/// Spread evenly over the cosine-weighted hemisphere, turned by chance.
glm::dvec3 hemisphere(const glm::dvec3& n, int k, int count, double turn, double shift) {
    const double squared = (k + shift) / count, angle = turn + k * 2.399963229728653;
    const glm::dvec3 side =
        glm::normalize(glm::cross(n, std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    return std::sqrt(squared) * (std::cos(angle) * side + std::sin(angle) * glm::cross(n, side)) +
           std::sqrt(1 - squared) * n;
}

/// Where rays begin, mm, by the cosine; none: the guard's way.
using Start = std::function<double(double)>;

/// A place's share of the light from all sides, by so many directions in the voxels.
double openByBits(const BitRays& rays, const glm::dvec3& p, const glm::dvec3& n, double radius, int count,
                  const Start& start, std::uint64_t key) {
    double lost = 0;
    for (int k = 0; k < count; ++k) {
        const glm::dvec3 d =
            hemisphere(n, k, count, unitFraction(mixedBits(key)) * 7, unitFraction(mixedBits(key + 9)));
        const double cosine = glm::dot(d, n), from = start ? start(cosine) : rays.guardedStart(cosine);
        if (from < radius)
            lost += 1 - rays.reach(p, d, from, radius, mixedBits(key) + static_cast<unsigned>(2 * k),
                                   start ? 0 : cosine) /
                            radius;
    }
    return 1 - lost / count;
}
/// The same by the triangles.
double openByTriangles(const Shape& shape, const glm::dvec3& p, const glm::dvec3& n, double radius,
                       int count) {
    double lost = 0;
    for (int k = 0; k < count; ++k) {
        ShapeHit hit;
        if (shape.next({p, hemisphere(n, k, count, 0.3, 0.5)}, {1e-6, 0}, radius, {}, hit))
            lost += 1 - hit.at.t / radius;
    }
    return 1 - lost / count;
}

/// Whatever its tilt and wherever voxels lie, and with every threshold: not one ray.
TEST(BitRays, APlaneDoesNotShadeItself) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::size_t unguarded = 0, diagonal = 0, cases = 0;
    for (int plane = 0; plane < 60; ++plane) {
        glm::dvec3 n = plane < 6    ? glm::dvec3(0.0)
                       : plane < 12 ? glm::dvec3(1, 1, plane % 2)
                                    : glm::dvec3(unit(random), unit(random), unit(random));
        if (plane < 6)
            n[plane / 2] = plane % 2 == 0 ? 1 : -1;
        n = glm::normalize(n);
        const glm::dvec3 u = glm::normalize(glm::cross(n, glm::dvec3(0.3, 0.5, 0.7))), v = glm::cross(n, u);
        std::vector<SceneMesh> meshes = {
            sceneMesh(quadMesh(-50.0 * u - 50.0 * v, 100.0 * u, 100.0 * v), raysRam())};
        VoxelGrid grid = gridAround(meshes, 64);
        grid.extent += 12;
        grid.fromPatient[3] +=
            glm::dvec4(6 + 0.5 * unit(random), 6 + 0.5 * unit(random), 6 + 0.5 * unit(random), 0);
        if (plane < 6) // on faces of voxels, and in their middles
            grid.fromPatient[3] =
                glm::dvec4(glm::floor(glm::dvec3(grid.fromPatient[3])) + (plane % 3) * 0.25, 1);
        const MeshBits bits(meshes, grid, nullptr, 1, true);
        for (const double threshold : {0.2, 0.45, 0.65, 0.8}) {
            const BitRays rays(bits, threshold);
            for (int n_ = 0; n_ < 40; ++n_) {
                // As hits have it: rounded to floats, on the plane.
                const glm::dvec3 p(glm::vec3(20.0 * unit(random) * u + 20.0 * unit(random) * v));
                const auto key = static_cast<std::uint64_t>(random());
                EXPECT_EQ(openByBits(rays, p, n, 40, 16, {}, key), 1) << plane << " at " << threshold;
                const double s = grid.edgeMm;
                ++cases;
                unguarded += openByBits(
                                 rays, p, n, 40, 16, [](double) { return 0.0; }, key) < 1
                                 ? 1
                                 : 0;
                diagonal += openByBits(
                                rays, p, n, 40, 16, [&](double c) { return 0.866 * s / c; }, key) < 1
                                ? 1
                                : 0;
            }
        }
    }
    EXPECT_GT(unguarded, cases * 3 / 4);
    EXPECT_GT(diagonal, 0u); // half a voxel's diagonal is not enough where thresholds are low
}

/// A floor and a wall: places of the floor by their distance from the wall.
TriangleMesh cornerMesh() {
    TriangleMesh mesh = quadMesh({-30, -30, 0}, {60, 0, 0}, {0, 60, 0});
    const TriangleMesh wall = quadMesh({0, -30, 0}, {0, 60, 0}, {0, 0, 30});
    mesh.points.insert(mesh.points.end(), wall.points.begin(), wall.points.end());
    for (const glm::uvec3& t : wall.triangles)
        mesh.triangles.push_back(t + 4u);
    return mesh;
}

/// Nearer to a concave edge than the guard reaches, rays begin behind the wall: a bright band. Its width, in
/// voxels, at most one.
TEST(BitRays, TheBrightBandOfAnEdgeIsAVoxelWide) {
    constexpr double kRadius = 10;
    const SceneMesh mesh = sceneMesh(cornerMesh(), raysRam());
    for (const int resolution : {64, 128, 256}) {
        const MeshBits bits(std::span(&mesh, 1), gridAround(std::span(&mesh, 1), resolution), nullptr, 1,
                            true);
        const BitRays rays(bits, 0.45);
        const double s = bits.grid().edgeMm;
        double width = 0;
        for (double x = 0.05; x < 6; x += 0.05) {
            const glm::dvec3 p(x * s, 3.3, 0), n(0, 0, 1);
            double open = 0;
            for (unsigned k = 0; k < 32; ++k)
                open += openByBits(rays, p + glm::dvec3(0, k * 0.37 * s, 0), n, kRadius, 64, {}, k) / 32;
            if (open - openByTriangles(*mesh.shape, p, n, kRadius, 1024) > 0.05)
                width = x;
        }
        EXPECT_LE(width, 1.0) << resolution;
        if (std::getenv("TESSERA_TELL"))
            std::cout << "band at " << resolution << ": " << width << " voxels\n";
    }
}

/// A ball above a floor between two others, as an STL of them has it: folds, contacts, hollows.
TriangleMesh folds() {
    TriangleMesh mesh = quadMesh({-40, -40, 0}, {80, 0, 0}, {0, 80, 0});
    for (const auto& [centre, radius] : {std::pair{glm::dvec3(0, 0, 12), 12.0},
                                         {glm::dvec3(-18, 5, 9), 8.0},
                                         {glm::dvec3(14, -14, 5), 5.0},
                                         {glm::dvec3(10, 20, 20), 6.0}}) {
        const TriangleMesh ball = sphereMesh(centre, radius, 60);
        const auto first = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.insert(mesh.points.end(), ball.points.begin(), ball.points.end());
        for (const glm::uvec3& t : ball.triangles)
            mesh.triangles.push_back(t + first);
    }
    return mesh;
}

/// Against 4096 rays in the triangles, 16 mm: errors fall with the voxels' edge, and guards that are none
/// darken. TESSERA_TELL=1 tells of all.
TEST(BitRays, OcclusionIsNearThatOfTheTriangles) {
    constexpr double kRadius = 16;
    const bool tells = std::getenv("TESSERA_TELL") != nullptr;
    const SceneMesh mesh = sceneMesh(folds(), raysRam());
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    struct Place {
        glm::dvec3 p, n;
        double truth;
    };
    std::vector<Place> places;
    while (places.size() < (tells ? 400u : 120u)) { // seen from above
        const ShapeRay ray{{25 * unit(random), 25 * unit(random), 60},
                           {0.2 * unit(random), 0.2 * unit(random), -1}};
        ShapeHit hit;
        if (!mesh.shape->next(ray, {0, 0}, 1e9, {}, hit))
            continue;
        const glm::dvec3 n =
            glm::normalize(glm::dot(hit.normal, ray.direction) > 0 ? -hit.normal : hit.normal);
        const glm::dvec3 p = ray.origin + hit.at.t * ray.direction;
        places.push_back({p, n, openByTriangles(*mesh.shape, p + 1e-4 * n, n, kRadius, tells ? 4096 : 512)});
    }
    const auto errorOf = [&](int resolution, double threshold, int directions, const char* guard,
                             double& bias) {
        const MeshBits bits(std::span(&mesh, 1), gridAround(std::span(&mesh, 1), resolution), nullptr, 1,
                            true);
        const BitRays rays(bits, threshold);
        const double s = bits.grid().edgeMm;
        const std::string name = guard;
        const Start start =
            name == "guard"   ? Start()
            : name == "slant" ? Start([=](double c) { return 0.866 * s / c; })
                              : Start([=](double) { return name == "none" ? 0 : (name == "1" ? 1 : 7) * s; });
        double sum = 0, squares = 0;
        for (std::size_t n = 0; n < places.size(); ++n) {
            const Place& place = places[n];
            const double off =
                openByBits(rays, place.p, place.n, kRadius, directions, start, n) - place.truth;
            sum += off, squares += off * off;
        }
        bias = sum / double(places.size());
        const double rms = std::sqrt(squares / double(places.size()));
        if (tells)
            std::cout << resolution << " V_t " << threshold << " " << directions << " directions, start "
                      << guard << ": bias " << bias << ", rms " << rms << "\n";
        return rms;
    };
    double bias = 0, unguarded = 0, one = 0, seven = 0;
    const double coarse = errorOf(64, 0.45, 64, "guard", bias),
                 middle = errorOf(128, 0.45, 64, "guard", bias), fine = errorOf(256, 0.45, 64, "guard", bias);
    EXPECT_LT(fine, 0.012);
    EXPECT_LT(std::abs(bias), 0.005);
    EXPECT_LT(middle, coarse);
    EXPECT_LT(fine, middle);
    EXPECT_GT(errorOf(128, 0.45, 64, "none", unguarded), 10 * middle);
    EXPECT_LT(unguarded, -0.3);
    EXPECT_GT(errorOf(128, 0.45, 64, "1", one), 2 * middle);
    EXPECT_GT(errorOf(128, 0.45, 64, "7", seven), 2 * middle);
    if (tells)
        errorOf(128, 0.45, 64, "slant", bias);
    if (tells)
        for (const double threshold : {0.2, 0.3, 0.4, 0.45, 0.5, 0.65, 0.8})
            for (const int directions : {16, 256})
                errorOf(128, threshold, directions, "guard", bias);
}

/// Glass at an angle takes its opacity, wherever the ray begins.
TEST(BitRays, TranslucentMeshesTakeTheirShare) {
    for (const double opacity : {0.25, 0.6}) {
        const SceneMesh mesh = sceneMesh(quadMesh({-20, -20, 0}, {40, 0, 0}, {0, 40, 0}), raysRam(), opacity);
        const MeshBits bits(std::span(&mesh, 1), gridAround(std::span(&mesh, 1), 100), nullptr, 1, true);
        const BitRays rays(bits, 0.45);
        int met = 0;
        constexpr int kRays = 20000;
        for (int k = 0; k < kRays; ++k)
            met += rays.reach({0.001 * k, 1, 3}, {0, 0, -1}, 0, 10,
                              mixedBits(static_cast<std::uint64_t>(k))) < 10
                       ? 1
                       : 0;
        EXPECT_NEAR(double(met) / kRays, opacity, 0.015);
    }
}

} // namespace
} // namespace tessera
