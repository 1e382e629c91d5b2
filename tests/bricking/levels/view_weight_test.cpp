// tests/bricking/levels/view_weight_test.cpp: a brick's weight in the camera's view, against rays through
// every pixel.
#include "tests/support/bricking_selection_tools.h"

#include <cmath>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <limits>

namespace tessera {
namespace {

using test::plainInfo;
using test::shearedInfo;
using test::uniform;

/// Pixels whose ray meets a brick: 16 rays a pixel, jittered, because edges may lie along the grid.
std::vector<double> areasByRays(const Camera& camera, const VolumeInfo& info, const glm::ivec2& size) {
    const glm::ivec3 bricks = brickGrid(info.extentVoxels);
    std::vector<double> areas(cellCount(bricks));
    const RayPlane plane = rayPlane(camera, info, size);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    constexpr int kFine = 4;
    for (int y = 0; y < kFine * size.y; ++y)
        for (int x = 0; x < kFine * size.x; ++x) {
            const std::uint64_t seed = 2 * static_cast<std::uint64_t>(y * kFine * size.x + x);
            const PatientRay ray =
                pixelRay(plane, {(x + uniform(seed)) / kFine, (y + uniform(seed + 1)) / kFine}, size);
            const glm::dvec3 base(voxelFromPatient * glm::dvec4(ray.base, 1));
            const glm::dvec3 along(glm::dmat3(voxelFromPatient) * ray.direction);
            for (int k = 0; k < bricks.z; ++k)
                for (int j = 0; j < bricks.y; ++j)
                    for (int i = 0; i < bricks.x; ++i) {
                        double near = ray.minT, far = std::numeric_limits<double>::infinity();
                        const glm::ivec3 first = glm::ivec3(i, j, k) * 32;
                        const glm::ivec3 end = glm::min(first + 32, info.extentVoxels);
                        for (int axis = 0; axis < 3; ++axis) {
                            const double a = (first[axis] - base[axis]) / along[axis],
                                         b = (end[axis] - base[axis]) / along[axis];
                            near = std::max(near, std::min(a, b));
                            far = std::min(far, std::max(a, b));
                        }
                        if (near < far)
                            areas[linearIndex({i, j, k}, bricks)] += 1.0 / (kFine * kFine);
                    }
        }
    return areas;
}

TEST(ViewWeights, AreasAreThoseThatRaysFind) {
    const VolumeInfo info = shearedInfo();
    const glm::ivec2 size(61, 43);
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(70.3, 41.7, 33.1, 1));
    std::vector<Camera> cameras = {fitCamera(info, ::tessera::View::anterior, Projection::perspective, size),
                                   fitCamera(info, ::tessera::View::left, Projection::parallel, size)};
    for (const double angle : {30.0, 130.0, 170.0}) {
        Camera inside;
        inside.position = middle;
        inside.focalPoint = middle + glm::dvec3(1, 0.4, 0.2);
        inside.viewAngle = angle;
        cameras.push_back(inside);
    }
    Camera close = cameras[0];
    close.focalPoint += glm::dvec3(40, 0, 30);
    close.viewAngle = 12;
    cameras.push_back(close); // most of the volume outside
    Camera away = cameras[0];
    away.focalPoint = 2.0 * away.position - away.focalPoint;
    cameras.push_back(away);
    for (std::size_t n = 0; n < cameras.size(); ++n) {
        const ViewWeights w = viewWeights(cameras[n], info, size);
        const std::vector<double> expected = areasByRays(cameras[n], info, size);
        ASSERT_EQ(w.area.size(), expected.size());
        EXPECT_EQ(w.pixels, 61 * 43);
        std::size_t seen = 0;
        for (std::size_t b = 0; b < expected.size(); ++b) {
            const double area = static_cast<double>(w.area[b]);
            if (expected[b] > 0) {
                // The uncertainty along the outline of 16 rays a pixel.
                EXPECT_NEAR(area, expected[b], 0.5 + 0.05 * expected[b]) << "camera " << n << " brick " << b;
                ++seen;
            }
            EXPECT_LE(area, w.pixels);
            EXPECT_GE(area, 0);
            for (const int threads : {1, 3})
                ASSERT_EQ(viewWeights(cameras[n], info, size, threads).area[b], w.area[b]);
        }
        if (n + 1 == cameras.size()) {
            EXPECT_EQ(seen, 0u);
            for (const float area : w.area)
                EXPECT_EQ(area, 0); // looking away: nothing, not even by blending
        } else {
            EXPECT_GT(seen, 0u);
        }
    }
}

TEST(ViewWeights, FinestLevelIsWhatAPixelShows) {
    VolumeInfo info = plainInfo({320, 32, 32}, ValueType::i16);
    info.patientFromVoxel = patientFromVoxelOf({0.5, 0.5, 0.5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    Camera parallel;
    parallel.projection = Projection::parallel;
    parallel.position = {160, -1000, 16};
    parallel.focalPoint = {160, 0, 16};
    parallel.parallelScale = 200; // 100 pixels over 400 mm: 4 mm a pixel
    for (const std::uint8_t level : viewWeights(parallel, info, {100, 100}).finest)
        EXPECT_EQ(level, 2);
    parallel.parallelScale = 199.9; // a hair less than 4 mm
    for (const std::uint8_t level : viewWeights(parallel, info, {100, 100}).finest)
        EXPECT_EQ(level, 1);
    parallel.parallelScale = 1e5;
    for (const std::uint8_t level : viewWeights(parallel, info, {100, 100}).finest)
        EXPECT_EQ(level, 5);

    VolumeInfo thick = info; // a pixel's content is judged by the longest edge of a voxel
    thick.patientFromVoxel[2] *= 4;
    parallel.parallelScale = 400; // 8 mm a pixel, 4 mm slices
    for (const std::uint8_t level : viewWeights(parallel, thick, {100, 100}).finest)
        EXPECT_EQ(level, 1);

    // Beside a picture that a brick fills exactly: what is blended into it, half a brick wide, counts a
    // quarter.
    parallel.parallelScale = 16;
    parallel.focalPoint.x = parallel.position.x = 32 + 16;
    const ViewWeights one = viewWeights(parallel, info, {64, 64});
    EXPECT_NEAR(one.area[1], 64 * 64, 1);
    for (const std::size_t beside : {0u, 2u})
        EXPECT_NEAR(one.area[beside], 0.25 * 0.5 * 64 * 64, 1);
    EXPECT_EQ(one.area[3], 0);

    // Looking along x from the front face: a pixel grows with the distance; 2 tan(45) / 200 mm per mm.
    Camera ahead;
    ahead.position = {-100, 16, 16};
    ahead.focalPoint = {100, 16, 16};
    ahead.viewAngle = 90;
    const ViewWeights w = viewWeights(ahead, info, {200, 200});
    for (int i = 0; i < 10; ++i) {
        const double depth = 100 + 32.0 * i, pixel = depth / 100;
        const double tangent = 16 * std::sqrt(2.0) / depth; // the nearest corners
        const double across = pixel / std::sqrt(1 + tangent * tangent);
        EXPECT_EQ(w.finest[static_cast<std::size_t>(i)],
                  std::max(0, static_cast<int>(std::floor(std::log2(across)))))
            << i;
    }
    // At the edge of a wide view: 400 mm away a pixel is 11 mm in the middle and 5 mm where it is 64 degrees
    // off.
    VolumeInfo wide = plainInfo({32, 1600, 32}, ValueType::i16);
    wide.patientFromVoxel = info.patientFromVoxel;
    Camera across;
    across.position = {-400, 800, 16};
    across.focalPoint = {0, 800, 16};
    across.viewAngle = 140;
    const ViewWeights row = viewWeights(across, wide, {200, 200});
    for (int j = 0; j < 50; ++j) {
        const double aside = std::max(std::abs(32 * j - 800), std::abs(32 * j + 32 - 800));
        const double tangent = std::hypot(aside, 16) / 400; // of the corner that is farthest from the middle
        const double pixel = 400 * std::tan(glm::radians(70.0)) / 100 / std::sqrt(1 + tangent * tangent);
        EXPECT_EQ(row.finest[static_cast<std::size_t>(j)], static_cast<int>(std::floor(std::log2(pixel))))
            << j;
    }
    // Inside, all that is beside or behind is as fine as it can be.
    Camera inside = ahead;
    inside.position = {100, 16, 16};
    inside.focalPoint = {200, 16, 16};
    inside.viewAngle = 130;
    const ViewWeights near = viewWeights(inside, info, {200, 200});
    EXPECT_EQ(near.finest[3], 0);
    EXPECT_EQ(near.area[3], 200 * 200);
    EXPECT_EQ(near.area[0], 0); // behind
    EXPECT_GT(near.finest[9], 0);
}

} // namespace
} // namespace tessera
