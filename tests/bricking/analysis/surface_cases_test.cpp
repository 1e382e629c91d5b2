// tests/bricking/analysis/surface_cases_test.cpp: the cases of a cell, each by itself, and as neighbours in
// lattices of random values.
#include "bricking/analysis/surface/cell_cases.h"
#include "tests/support/closed_mesh.h"
#include "tests/support/held_volume.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <random>

namespace tessera::test {
namespace {

std::array<int, 2> facesOf(int edge) {
    const int axis = edge / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
    return {2 * u + (edge & 1), 2 * v + (edge >> 1 & 1)};
}

/// Faces that two points on edges share; a middle is on none.
std::vector<int> sharedFaces(int a, int b) {
    std::vector<int> faces;
    if (a < kCellEdges && b < kCellEdges)
        for (const int f : facesOf(a))
            for (const int g : facesOf(b))
                if (f == g)
                    faces.push_back(f);
    return faces;
}

TEST(SurfaceCases, CutEveryFaceOnceAndFillTheLoops) {
    std::size_t cases = 0, middles = 0;
    for (int inside = 0; inside < 256; ++inside) {
        const std::uint8_t ambiguous = ambiguousFaces(static_cast<std::uint8_t>(inside));
        for (int joined = 0; joined < 64; ++joined) {
            if (joined & ~ambiguous)
                continue;
            ++cases;
            const CellCase found =
                cellCase(static_cast<std::uint8_t>(inside), static_cast<std::uint8_t>(joined));
            middles += found.middles.size();
            std::map<std::pair<int, int>, int> edges;
            for (std::size_t t = 0; t < found.corners.size(); t += 3)
                for (std::size_t i = 0; i < 3; ++i)
                    ++edges[{found.corners[t + i], found.corners[t + (i + 1) % 3]}];
            std::array<int, 6> cuts{};
            for (const auto& [edge, count] : edges) {
                ASSERT_EQ(count, 1) << inside << " " << joined;
                const std::vector<int> faces = sharedFaces(edge.first, edge.second);
                const bool twice = edges.contains({edge.second, edge.first});
                ASSERT_EQ(faces.empty(), twice) << inside << " " << joined << ": an inner edge in a face";
                for (const int face : faces)
                    ++cuts[static_cast<std::size_t>(face)];
            }
            for (int face = 0; face < 6; ++face) {
                const std::array<int, 4> c = cornersOf(face);
                int changes = 0;
                for (std::size_t i = 0; i < 4; ++i)
                    changes += (inside >> c[i] & 1) != (inside >> c[(i + 1) % 4] & 1);
                ASSERT_EQ(cuts[static_cast<std::size_t>(face)], changes / 2) << inside << " " << joined;
            }
        }
    }
    EXPECT_EQ(cases, 656u) << "the sum of 2^(ambiguous faces) over 256 cases";
    std::printf("%zu cases, %zu loops filled around their middle\n", cases, middles);
}

/// A random affine: any spacing, sheared, mirrored or not.
glm::dmat4 randomAffine(std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    for (;;) {
        glm::dmat4 m(1);
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row)
                m[column][row] = column == 3 ? 100 * unit(random) : 2 * unit(random);
        if (std::abs(glm::determinant(glm::dmat3(m))) > 0.5)
            return m;
    }
}

TEST(SurfaceCases, RandomLatticesAreClosedAroundWhatIsInside) {
    int mostComponents = 0;
    for (unsigned seed = 0; seed < 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        std::mt19937 random(seed);
        const auto upTo = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
        const int most = seed % 8 == 0 ? 11 : 6;
        const glm::ivec3 extent(1 + upTo(most), 1 + upTo(most), 1 + upTo(most));
        const int kind = upTo(4);
        HeldVolume volume(
            extent,
            [&](const glm::ivec3&) {
                switch (kind) {
                case 0: // the value itself is frequent
                    return static_cast<double>(upTo(3) - 1);
                case 1: // opposite corners with equal products
                    return upTo(2) ? 1.0 : -1.0;
                case 2:
                    return std::uniform_real_distribution<double>(-1, 1)(random);
                default: // values next to that of the surface, and far ones
                    return (upTo(2) ? 1 : -1) * std::ldexp(1.0, 40 - upTo(80));
                }
            },
            randomAffine(random));
        SurfaceRequest request;
        request.tileExtent = 1 + upTo(5);
        request.blockExtent = 1 + upTo(7);
        request.threads = 1;
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        const SurfaceLattice lattice(volume.info(), {glm::dvec3(0), glm::dvec3(extent)}, 0, "test");
        HeldMesh mesh;
        const SurfaceCounts counts = extractSurface(volume, lattice, volume.ranges(), request, ram, mesh);
        ASSERT_EQ(counts.points, mesh.points.size());
        ASSERT_EQ(counts.triangles, mesh.triangles.size());
        ASSERT_EQ(faultOf(mesh), "");
        if (mesh.triangles.empty())
            continue;
        const Shape shape = shapeOf(mesh);
        EXPECT_TRUE(shape.each);
        EXPECT_GT(shape.volume, 0);
        EXPECT_NEAR(shape.volume, counts.volumeMm3, 1e-6 * std::abs(shape.volume));
        mostComponents = std::max(mostComponents, shape.components);
        for (std::size_t at = 0; at < cellCount(extent); ++at) {
            const glm::ivec3 voxel = gridPosition(at, extent);
            const glm::dvec3 place(volume.info().patientFromVoxel * glm::dvec4(glm::dvec3(voxel) + 0.5, 1));
            ASSERT_NEAR(windingOf(mesh, place), volume.at(voxel) < 0 ? 0 : 1, 1e-6);
        }
    }
    EXPECT_GE(mostComponents, 5);
}

TEST(SurfaceCases, EveryCellWithEveryWayOfItsFaces) {
    std::mt19937 random(7);
    std::set<std::pair<int, int>> met;
    for (int round = 0; round < 16; ++round)
        for (int inside = 0; inside < 256; ++inside) {
            std::array<double, 8> v{};
            for (std::size_t c = 0; c < 8; ++c)
                v[c] = (inside >> c & 1 ? 1 : -1) *
                       std::exp2(std::uniform_real_distribution<double>(-4, 4)(random));
            HeldVolume volume(glm::ivec3(2), [&](const glm::ivec3& at) {
                return v[static_cast<std::size_t>(at.x + 2 * at.y + 4 * at.z)];
            });
            MemoryBudget ram("RAM", "--ram", 64u << 20);
            SurfaceRequest request;
            request.threads = 1;
            const SurfaceLattice lattice(volume.info(), {glm::dvec3(0), glm::dvec3(2)}, 0, "test");
            HeldMesh mesh;
            extractSurface(volume, lattice, volume.ranges(), request, ram, mesh);
            ASSERT_EQ(faultOf(mesh), "") << inside;
            int joined = 0;
            for (int face = 0; face < 6; ++face)
                if (ambiguousFaces(static_cast<std::uint8_t>(inside)) >> face & 1) {
                    const std::array<int, 4> c = cornersOf(face);
                    const auto at = [&](std::size_t i) { return v[static_cast<std::size_t>(c[i])]; };
                    const double saddle = (at(0) * at(2) - at(1) * at(3)) / (at(0) + at(2) - at(1) - at(3));
                    joined |= (saddle >= 0) << face;
                }
            met.insert({inside, joined});
        }
    EXPECT_GT(met.size(), 450u) << "of 656, of which values do not reach all";
}

TEST(SurfaceCases, FacesAreJoinedAsTheFieldIsAtTheirSaddle) {
    std::mt19937 random(3);
    int joined = 0;
    for (int round = 0; round < 300; ++round) {
        const auto size = [&] { return std::exp2(std::uniform_real_distribution<double>(-2, 2)(random)); };
        const double a = size(), b = -size(), c = size(), d = -size(); // around the face z = 1.5
        if (std::abs(a * c - b * d) < 0.02 * a * c)
            continue; // the saddle is all but on the surface
        HeldVolume volume(glm::ivec3(2, 2, 3), [&](const glm::ivec3& at) {
            return at.z != 1      ? (at.x == at.y ? size() : -size())
                   : at.x == at.y ? (at.x ? c : a)
                   : at.x         ? b
                                  : d;
        });
        MemoryBudget ram("RAM", "--ram", 64u << 20);
        SurfaceRequest request;
        request.threads = 1;
        const SurfaceLattice lattice(volume.info(), {glm::dvec3(0), glm::dvec3(2, 2, 3)}, 0, "test");
        HeldMesh mesh;
        extractSurface(volume, lattice, volume.ranges(), request, ram, mesh);
        // a (1-u)(1-v) + b u (1-v) + c u v + d (1-u) v has its saddle at (u, v), between the face's two cuts
        const double sum = a - b + c - d;
        const glm::dvec3 saddle(0.5 + (a - d) / sum, 0.5 + (a - b) / sum, 1.5);
        const bool inside = a * c > b * d;
        joined += inside;
        ASSERT_NEAR(windingOf(mesh, saddle), inside ? 1 : 0, 1e-6) << a << " " << b << " " << c << " " << d;
    }
    EXPECT_GT(joined, 50);
}

} // namespace
} // namespace tessera::test
