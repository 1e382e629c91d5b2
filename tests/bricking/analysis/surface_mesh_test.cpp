// tests/bricking/analysis/surface_mesh_test.cpp: surfaces of known shapes: area, volume, topology, where they
// lie, how they end at faces, and that nothing of it depends on what is visited at once.
#include "bricking/analysis/surface/surface_mesh.h"
#include "core/base/error.h"
#include "tests/support/closed_mesh.h"
#include "tests/support/held_volume.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;
constexpr std::size_t kRam = std::size_t{64} << 20;
const double kPi = std::acos(-1.0);

struct Found {
    HeldMesh mesh;
    SurfaceCounts counts;
};

VoxelBox wholeOf(const ChunkSource& volume) {
    return {glm::dvec3(0), glm::dvec3(volume.info().extentVoxels)};
}

Found surfaceOf(const HeldVolume& volume, double value, SurfaceRequest request = {},
                std::optional<VoxelBox> box = {}, int level = 0, bool wide = false) {
    request.value = value;
    request.threads = 1;
    MemoryBudget ram("RAM", "--ram", kRam);
    const SurfaceLattice lattice(volume.info(), box.value_or(wholeOf(volume)), level, "test");
    Found found;
    found.counts = extractSurface(volume, lattice, wide ? volume.wideRanges() : volume.ranges(), request, ram,
                                  found.mesh);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_EQ(faultOf(found.mesh), "");
    return found;
}

glm::dvec3 middleOf(const glm::ivec3& voxel) {
    return glm::dvec3(voxel) + 0.5;
}

/// A ball of a radius: values fall outwards.
HeldVolume ballOf(double radius, const glm::dmat4& affine = glm::dmat4(1)) {
    const int n = static_cast<int>(std::ceil(2 * radius)) + 6;
    const glm::dvec3 centre(0.5 * n + 0.13, 0.5 * n - 0.21, 0.5 * n + 0.07);
    return HeldVolume(
        glm::ivec3(n),
        [=](const glm::ivec3& voxel) { return radius - glm::length(middleOf(voxel) - centre); }, affine);
}

TEST(SurfaceMesh, BallsHaveTheirAreaAndVolumeToSecondOrder) {
    double areaBefore = 0, volumeBefore = 0;
    for (const double radius : {5.0, 10.0, 20.0, 40.0}) {
        const HeldVolume ball = ballOf(radius);
        const Found found = surfaceOf(ball, 0);
        const Shape shape = shapeOf(found.mesh);
        EXPECT_EQ(shape.components, 1);
        EXPECT_EQ(shape.euler, 2);
        const double area = std::abs(found.counts.areaMm2 / (4 * kPi * radius * radius) - 1),
                     volume = std::abs(found.counts.volumeMm3 / (4 * kPi * radius * radius * radius / 3) - 1);
        std::printf("radius %4.1f: area %.2e, volume %.2e\n", radius, area, volume);
        EXPECT_LT(area, 0.4 / (radius * radius));
        EXPECT_LT(volume, 0.65 / (radius * radius));
        if (areaBefore > 0) {
            EXPECT_NEAR(std::log2(areaBefore / area), 2, 0.25);
            EXPECT_NEAR(std::log2(volumeBefore / volume), 2, 0.25);
        }
        areaBefore = area, volumeBefore = volume;
    }
}

TEST(SurfaceMesh, ShearAndMirrorsKeepTheOutside) {
    for (const double mirror : {1.0, -1.0}) {
        glm::dmat4 affine(1);
        affine[0] = {0.7 * mirror, 0.1, 0, 0};
        affine[1] = {0.2, 0.8, -0.3, 0};
        affine[2] = {0, 0.4, 1.5, 0};
        affine[3] = {-40, 30, 500, 1};
        const HeldVolume ball = ballOf(12, affine);
        const Found found = surfaceOf(ball, 0);
        const double expected = 4 * kPi * 12 * 12 * 12 / 3 * std::abs(glm::determinant(glm::dmat3(affine)));
        EXPECT_NEAR(found.counts.volumeMm3, expected, 0.006 * expected);
        EXPECT_GT(shapeOf(found.mesh).volume, 0);
        EXPECT_LE(found.counts.lowMm.z, found.counts.highMm.z);
    }
}

TEST(SurfaceMesh, NormalsPointToLowerPhysicalValues) {
    HeldVolume ball = ballOf(8);
    ball.description().rescaleSlope = -2;
    ball.description().rescaleIntercept = 10; // a hollow in the box now
    const Found found = surfaceOf(ball, 10);
    const double box = std::pow(ball.info().extentVoxels.x, 3);
    EXPECT_NEAR(found.counts.volumeMm3, box - 4 * kPi * 512 / 3, 0.01 * 4 * kPi * 512 / 3);
    EXPECT_EQ(shapeOf(found.mesh).components, 2);
}

TEST(SurfaceMesh, ATorusHasOneHandle) {
    const HeldVolume torus(glm::ivec3(40, 40, 20), [](const glm::ivec3& voxel) {
        const glm::dvec3 p = middleOf(voxel) - glm::dvec3(20.1, 19.8, 10.2);
        return 5 - std::hypot(std::hypot(p.x, p.y) - 12, p.z);
    });
    const Found found = surfaceOf(torus, 0);
    const Shape shape = shapeOf(found.mesh);
    EXPECT_EQ(shape.components, 1);
    EXPECT_EQ(shape.euler, 0);
    EXPECT_NEAR(found.counts.volumeMm3, 2 * kPi * kPi * 12 * 25, 0.01 * 2 * kPi * kPi * 12 * 25);
    EXPECT_NEAR(found.counts.areaMm2, 4 * kPi * kPi * 12 * 5, 0.01 * 4 * kPi * kPi * 12 * 5);
}

/// Something at every scale, which the faces of the volume cut.
HeldVolume foam(const glm::ivec3& extent) {
    return HeldVolume(extent, [](const glm::ivec3& v) {
        const glm::dvec3 p = 0.35 * middleOf(v);
        const double gyroid =
            std::sin(p.x) * std::cos(p.y) + std::sin(p.y) * std::cos(p.z) + std::sin(p.z) * std::cos(p.x);
        return std::round(8 * gyroid) / 4; // many of the value itself
    });
}

TEST(SurfaceMesh, NothingDependsOnWhatIsVisitedAtOnce) {
    const HeldVolume volume = foam({41, 37, 70});
    const Found plain = surfaceOf(volume, 0.5);
    const auto expected = placesOf(plain.mesh);
    ASSERT_GT(expected.size(), 10000u);
    ASSERT_EQ(expected.size(), plain.mesh.triangles.size());
    for (const auto& [tile, block] :
         {std::pair{8, 32}, {1, 1}, {3, 5}, {5, 3}, {8, 16}, {7, 64}, {64, 64}, {2, 13}}) {
        SurfaceRequest request;
        request.tileExtent = tile, request.blockExtent = block;
        const Found found = surfaceOf(volume, 0.5, request, {}, 0, tile != 8);
        EXPECT_EQ(placesOf(found.mesh), expected) << tile << " " << block;
        EXPECT_EQ(found.counts.points, plain.counts.points);
    }
}

TEST(SurfaceMesh, PointsLieWhereTheFieldHasTheValue) {
    const HeldVolume volume = foam({20, 20, 20});
    const VoxelBox whole{glm::dvec3(0), glm::dvec3(20)}, part{{1.3, 2.6, 3.45}, {17.2, 16.7, 18.4}};
    for (const VoxelBox& box : {whole, part})
        for (const glm::dvec3& p : surfaceOf(volume, 0.37, {}, box).mesh.points) { // no sample has it
            const glm::dvec3 place = glm::clamp(p - 0.5, glm::dvec3(0), glm::dvec3(19));
            const glm::ivec3 low = glm::min(glm::ivec3(place), glm::ivec3(18));
            const glm::dvec3 t = place - glm::dvec3(low);
            double value = 0;
            for (int c = 0; c < 8; ++c) {
                const glm::ivec3 step(c & 1, c >> 1 & 1, c >> 2);
                double share = 1;
                for (int axis = 0; axis < 3; ++axis)
                    share *= step[axis] ? t[axis] : 1 - t[axis];
                value += share * volume.at(low + step);
            }
            bool onFace = false, inMiddle = true; // a middle of a loop lies on no edge of the lattice
            for (int axis = 0; axis < 3; ++axis) {
                onFace = onFace || p[axis] < box.low[axis] + 0.002 || p[axis] > box.high[axis] - 0.002;
                inMiddle = inMiddle && std::abs(place[axis] - std::round(place[axis])) > 1e-9;
            }
            if (onFace) {
                EXPECT_GE(value, 0.37 - 1e-6);
            } else if (!inMiddle) {
                EXPECT_NEAR(value, 0.37, 1e-6);
            }
        }
}

TEST(SurfaceMesh, IsClosedAtTheFacesOfTheVolumeAndOfABox) {
    // all of it inside: the volume's box, its corners but for 1/1024 voxel
    const HeldVolume full(glm::ivec3(9, 17, 33), [](const glm::ivec3&) { return 5.0; });
    const Found box = surfaceOf(full, 5);
    EXPECT_NEAR(box.counts.volumeMm3, 9 * 17 * 33, 0.01);
    EXPECT_NEAR(box.counts.areaMm2, 2 * (9 * 17 + 17 * 33 + 33 * 9), 1.5);
    EXPECT_EQ(box.counts.lowMm, glm::dvec3(0));
    EXPECT_EQ(box.counts.highMm, glm::dvec3(9, 17, 33));
    EXPECT_EQ(surfaceOf(full, 5.001).counts.triangles, 0u);
    // a slope, cut by boxes through anything: what is above it is known
    const HeldVolume slope(glm::ivec3(40, 12, 12), [](const glm::ivec3& v) { return v.x + 0.5; });
    for (const auto& [low, high] : {std::pair{glm::dvec3(3, 2, 1), glm::dvec3(30, 9, 8)},
                                    {glm::dvec3(3.3, 2.5, 1.7), glm::dvec3(30.21, 9.5, 8.4)},
                                    {glm::dvec3(18.9, 4.1, 4.2), glm::dvec3(21.3, 4.4, 4.3)},
                                    {glm::dvec3(-7, 2, -1e300), glm::dvec3(1e9, 9, 8)}}) {
        const Found found = surfaceOf(slope, 20.25, {}, VoxelBox{low, high});
        const glm::dvec3 from = glm::max(low, glm::dvec3(20.25, 0, 0)),
                         to = glm::min(high, glm::dvec3(40, 12, 12)), side = to - from;
        EXPECT_NEAR(found.counts.volumeMm3, side.x * side.y * side.z, 0.006 * side.x * side.y * side.z);
        EXPECT_GE(found.counts.lowMm.y, from.y - 1e-12);
        EXPECT_LE(found.counts.highMm.x, to.x + 1e-12);
        EXPECT_NEAR(found.counts.highMm.x, to.x, 1e-12);
    }
}

TEST(SurfaceMesh, LevelsAreThoseOfTheStore) {
    const HeldVolume ball = ballOf(30);
    for (int level = 0; level < 4; ++level) {
        const Found found = surfaceOf(ball, 0, {}, {}, level);
        const double expected = 4 * kPi * 27000 / 3;
        EXPECT_NEAR(found.counts.volumeMm3, expected, 0.002 * std::pow(4, level) * expected) << level;
        EXPECT_EQ(shapeOf(found.mesh).euler, 2);
        EXPECT_EQ(placesOf(surfaceOf(ball, 0, {}, {}, level, true).mesh), placesOf(found.mesh));
    }
    for (int level = 0; level < kLevelCount; ++level) // any extent, to one sample that lies beyond the volume
        for (const int n : {1, 2, 5, 9, 33, 37}) {
            const HeldVolume full(glm::ivec3(n, 3, 4), [](const glm::ivec3&) { return 1.0; });
            EXPECT_NEAR(surfaceOf(full, 1, {}, {}, level).counts.volumeMm3, 12 * n, 0.04 * n)
                << n << " " << level;
        }
}

TEST(SurfaceMesh, WorkIsThatOfTheSurface) {
    // a small ball in a large volume, and one twice as large
    std::uint64_t before = 0;
    for (const double radius : {12.0, 24.0}) {
        const HeldVolume volume(glm::ivec3(160), [radius](const glm::ivec3& v) {
            return std::max(-3.0, radius - glm::length(middleOf(v) - 80.0));
        });
        const Found found = surfaceOf(volume, 0);
        const double tiles = 4 * kPi * radius * radius / 64; // of area, one for each that it goes through
        EXPECT_LT(static_cast<double>(found.counts.cellsSeen), 4 * 512 * tiles);
        EXPECT_EQ(found.counts.cells, 163u * 163u * 163u);
        if (before > 0) {
            EXPECT_LT(found.counts.cellsSeen, 5 * before);
        }
        before = found.counts.cellsSeen;
        EXPECT_LE(found.counts.chunksDecoded, radius == 12 ? 8u : 27u) << "of 125";
        EXPECT_EQ(placesOf(surfaceOf(volume, 0, {}, {}, 0, true).mesh), placesOf(found.mesh));
    }
}

TEST(SurfaceMesh, MemoryDependsOnTheVolumeAlone) {
    const HeldVolume volume = foam({100, 90, 60}); // 12 chunks of 128 KiB at most eight of which are held
    const SurfaceLattice lattice(volume.info(), wholeOf(volume), 0, "test");
    SurfaceRequest request;
    request.value = 0.5, request.threads = 1;
    const std::size_t floor = surfaceFloorBytes(volume.info(), lattice, 1);
    MemoryBudget least("RAM", "--ram", floor);
    HeldMesh mesh;
    extractSurface(volume, lattice, volume.ranges(), request, least, mesh);
    EXPECT_LE(least.peakBytes(), floor);
    EXPECT_EQ(placesOf(mesh), placesOf(surfaceOf(volume, 0.5).mesh));
    MemoryBudget less("RAM", "--ram", floor - 1);
    EXPECT_THROW(extractSurface(volume, lattice, volume.ranges(), request, less, mesh), InputError);
    EXPECT_EQ(less.usedBytes(), 0u);
}

TEST(SurfaceMesh, RefusesWhatNumbersCannotHold) {
    const HeldVolume ball = ballOf(8);
    SurfaceRequest request;
    request.mostPoints = surfaceOf(ball, 0).counts.points;
    EXPECT_NO_THROW(surfaceOf(ball, 0, request));
    --request.mostPoints;
    const auto saying = [](const auto& run) -> std::string {
        try {
            run();
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_THAT(saying([&] { surfaceOf(ball, 0, request); }),
                HasSubstr("which numbers of 32 bits do not tell apart"));
    VolumeInfo far = ball.info();
    far.patientFromVoxel = glm::scale(glm::dmat4(1), glm::dvec3(1e-4));
    far.patientFromVoxel[3] = {5000, 0, 0, 1};
    EXPECT_THAT(saying([&] { SurfaceLattice(far, wholeOf(ball), 0, "v.zarr"); }),
                HasSubstr("v.zarr: expected a volume whose places in the patient fit numbers of 32 bits"));
    EXPECT_THAT(saying([&] {
                    SurfaceLattice(ball.info(), {glm::dvec3(30), glm::dvec3(60)}, 0, "--crop");
                }),
                HasSubstr("--crop: expected a box that holds some of the volume, found none along axis x"));
}

TEST(SurfaceMesh, PointsFarFromTheOriginStayApart) {
    glm::dmat4 affine = glm::scale(glm::dmat4(1), glm::dvec3(0.05)); // a specimen in a large room
    affine[3] = {900, -900, 950, 1};
    const HeldVolume volume(
        glm::ivec3(20), [](const glm::ivec3& v) { return static_cast<double>((v.x * v.y + v.z) % 3 - 1); },
        affine);
    const Found found = surfaceOf(volume, 0); // faultOf() looks at areas in 32 bits
    std::set<std::array<float, 3>> places;
    for (const glm::dvec3& p : found.mesh.points)
        places.insert({static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    EXPECT_EQ(places.size(), found.mesh.points.size());
}

struct Plane {
    int low, high;
    double weight, place;
};
void expectPlanes(const SurfaceLattice& lattice, int axis, const std::vector<Plane>& expected) {
    const std::vector<LatticePlane>& planes = lattice.planes(axis);
    ASSERT_EQ(planes.size(), expected.size());
    EXPECT_EQ(lattice.extent()[axis], static_cast<int>(expected.size()));
    for (std::size_t i = 0; i < planes.size(); ++i) {
        EXPECT_EQ(planes[i].low, expected[i].low) << i;
        EXPECT_EQ(planes[i].high, expected[i].high) << i;
        EXPECT_NEAR(planes[i].weight, expected[i].weight, 1e-12) << i;
        EXPECT_NEAR(planes[i].place, expected[i].place, 1e-12) << i;
        const int plane = static_cast<int>(i);
        EXPECT_EQ(lattice.isOutside(axis, plane), i == 0 || i + 1 == planes.size());
    }
}

/// At samples, on the faces, and 1/1024 of a sample inside of these.
TEST(SurfaceLattice, HasThePlanesOfSamplesAndTwoAtEachEnd) {
    VolumeInfo info;
    info.extentVoxels = {5, 7, 6};
    info.patientFromVoxel = glm::scale(glm::dmat4(1), glm::dvec3(2, 1, 1.5));
    const double e = 1.0 / 1024;
    const SurfaceLattice fine(info, {glm::dvec3(-3, 1.3, 0.5), glm::dvec3(5, 3.8, 99)}, 0, "test");
    expectPlanes(fine, 0,
                 {{0, 1, 0, 0},
                  {0, 1, 0, e},
                  {0, 0, 0, 0.5},
                  {1, 1, 0, 1.5},
                  {2, 2, 0, 2.5},
                  {3, 3, 0, 3.5},
                  {4, 4, 0, 4.5},
                  {4, 4, 0, 5 - e},
                  {4, 4, 0, 5}});
    expectPlanes(fine, 1,
                 {{0, 1, 0.8, 1.3},
                  {0, 1, 0.8 + e, 1.3 + e},
                  {1, 1, 0, 1.5},
                  {2, 2, 0, 2.5},
                  {3, 3, 0, 3.5},
                  {3, 4, 0.3 - e, 3.8 - e},
                  {3, 4, 0.3, 3.8}});
    // no sample nearer to a face than twice as much
    expectPlanes(fine, 2,
                 {{0, 1, 0, 0.5},
                  {0, 1, e, 0.5 + e},
                  {1, 1, 0, 1.5},
                  {2, 2, 0, 2.5},
                  {3, 3, 0, 3.5},
                  {4, 4, 0, 4.5},
                  {5, 5, 0, 5.5},
                  {5, 5, 0, 6 - e},
                  {5, 5, 0, 6}});
    const SurfaceLattice coarse(info, {glm::dvec3(0), glm::dvec3(5, 7, 6)}, 1, "test");
    expectPlanes(
        coarse, 0,
        {{0, 1, 0, 0}, {0, 1, 0, 2 * e}, {0, 0, 0, 1}, {1, 1, 0, 3}, {1, 2, 1 - e, 5 - 2 * e}, {2, 2, 0, 5}});
    // a crossing keeps from the ends of its edge; on a face it is there
    const auto along = [&](int plane, double low, double high) {
        return fine.crossing({2, plane, 3}, 1, low, high).y;
    };
    EXPECT_NEAR(along(3, -1, 3), 2.75, 1e-12);
    EXPECT_NEAR(along(3, 3, -1), 3.25, 1e-12);
    EXPECT_NEAR(along(3, -1, 0), 3.5 - e, 1e-12);
    EXPECT_NEAR(along(3, 0, -1), 2.5 + e, 1e-12);
    EXPECT_EQ(along(0, -1, 3), 1.3);
    EXPECT_EQ(along(5, 3, -1), 3.8);
    EXPECT_NEAR(fine.crossing({2, 3, 3}, 1, -1, 3).x, 2 * 0.5, 1e-12);
    EXPECT_NEAR(fine.crossing({2, 3, 3}, 1, -1, 3).z, 1.5 * 2.5, 1e-12);
}

/// Four steps of numbers of 32 bits, as far from the origin, are a sixteenth of a sample at most.
TEST(SurfaceLattice, SamplesMayBeFarFromTheOriginInProportion) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(4);
    for (const double share : {0.97, 1.03}) {
        const double spacing = 16 * 4 * 100 * std::ldexp(1.0, -23) / share;
        info.patientFromVoxel = glm::scale(glm::dmat4(1), glm::dvec3(1, spacing, 2));
        info.patientFromVoxel[3] = {0, 100 - 4 * spacing, 0, 1};
        const auto make = [&] { SurfaceLattice(info, {glm::dvec3(0), glm::dvec3(4)}, 0, "test"); };
        if (share < 1) {
            EXPECT_NO_THROW(make());
        } else {
            EXPECT_THROW(make(), InputError);
        }
    }
    // and a box has eight of the least parts at least
    info.patientFromVoxel = glm::dmat4(1);
    for (const double edge : {7.9 / 1024, 8.1 / 1024}) {
        const auto make = [&] {
            SurfaceLattice(info, {glm::dvec3(1), glm::dvec3(3, 3, 1 + edge)}, 0, "test");
        };
        if (edge > 8.0 / 1024) {
            EXPECT_NO_THROW(make());
        } else {
            EXPECT_THROW(make(), InputError);
        }
    }
}

} // namespace
} // namespace tessera::test
