// tests/bricking/levels/visibility_test.cpp: the visibility of a brick. It is predicted behind other bricks,
// where the transmittance is known in closed form, and fed back from frames without flicker.
#include "bricking/levels/visibility.h"

#include "tests/support/bricking_selection_tools.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace tessera {
namespace {

using test::mixed;
using test::predictedOf;
using test::shearedInfo;
using test::uniform;
using test::unitInfo;
using test::whiteAbove150;

constexpr double kHalf =
    std::numbers::ln2 / kBrickExtent; // extinction: a brick lets half of the light through
constexpr double kUnit = 1.0 / 256;   // light is counted in whole units and rounded down
constexpr glm::ivec2 kOneRay(4, 4);   // a picture for which one ray is sent, in its middle

/// Parallel rays along a direction, the middle one through a point.
Camera along(const glm::dvec3& through, const glm::dvec3& direction) {
    Camera camera;
    camera.projection = Projection::parallel;
    camera.position = through - 500.0 * direction;
    camera.focalPoint = through;
    camera.parallelScale = 16;
    return camera;
}

/// Bricks in a row along y, those whose number is in [first, end) filled with 200, the rest with 0.
test::HashSource::Formula filled(int first, int end) {
    return [=](int, int y, int) { return y >= 32 * first && y < 32 * end ? 200 : 0; };
}

/// Within the unit that light is counted in, and never above.
void expectNear(const std::vector<float>& found, const std::vector<double>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t b = 0; b < found.size(); ++b) {
        EXPECT_LE(static_cast<double>(found[b]), expected[b] + 1e-6) << "brick " << b;
        EXPECT_GE(static_cast<double>(found[b]), expected[b] - kUnit) << "brick " << b;
    }
}

// -- predicted
// ------------------------------------------------------------------------------------------------------

TEST(PredictVisibility, AnOpaqueBrickHidesWhatIsBehindItAndNothingElse) {
    const glm::ivec3 extent(32, 96, 32);
    const LevelErrors e = predictedOf(extent, filled(1, 2), whiteAbove150(10));
    EXPECT_EQ(e.shows, (std::vector<std::uint8_t>{1, 1, 1})); // the outer ones by the layer around them
    for (const std::size_t brick : {0, 1, 2})                 // up to the rounding of sixteen weights
        EXPECT_NEAR(static_cast<double>(e.transmittances[brick]), brick == 1 ? 0 : 1, 1e-6);
    const auto from = [&](double y) {
        return predictVisibility(e, along({16, 48, 16}, {0, y, 0}), unitInfo(extent), {64, 64});
    };
    expectNear(from(1), {1, 1, kHiddenVisibility});
    expectNear(from(-1), {kHiddenVisibility, 1, 1});
    EXPECT_GE(from(1)[2], kHiddenVisibility);
    // Beside one another they hide nothing of one another.
    EXPECT_EQ(predictVisibility(e, along({16, 48, 16}, {1, 0, 0}), unitInfo(extent), {64, 192}),
              (std::vector<float>{1, 1, 1}));
}

TEST(PredictVisibility, WhatIsTransparentHidesNothing) {
    const glm::ivec3 extent(32, 96, 32);
    const LevelErrors e = predictedOf(
        extent, [](int, int, int) { return 100; }, whiteAbove150(10));
    EXPECT_EQ(e.shows, (std::vector<std::uint8_t>{0, 0, 0}));
    EXPECT_EQ(predictVisibility(e, along({16, 48, 16}, {0, 1, 0}), unitInfo(extent), {64, 64}),
              (std::vector<float>{1, 1, 1}));
}

TEST(PredictVisibility, LightFallsByThePowerOfThePath) {
    const glm::ivec3 extent(32, 128, 32);
    const LevelErrors e = predictedOf(extent, filled(1, 3), whiteAbove150(kHalf));
    EXPECT_NEAR(static_cast<double>(e.transmittances[1]), 0.5, 1e-5);
    expectNear(predictVisibility(e, along({16, 48, 16}, {0, 1, 0}), unitInfo(extent), {64, 64}),
               {1, 1, 0.5, 0.25});
    // From within: a quarter of a brick before the eye, what lies behind it unseen and not called hidden.
    Camera inside;
    inside.position = {16, 56, 16};
    inside.focalPoint = {16, 60, 16};
    expectNear(predictVisibility(e, inside, unitInfo(extent), kOneRay),
               {1, 1, std::pow(0.5, 0.25), std::pow(0.5, 1.25)});
    // Obliquely, from (8, 0) through (32, 24) and (40, 32): 24 sqrt(2) voxels of the first brick.
    const glm::ivec3 square(64, 64, 32);
    const LevelErrors corner = predictedOf(
        square, [](int x, int y, int) { return x < 32 && y < 32 ? 200 : 0; }, whiteAbove150(kHalf));
    const double left = std::pow(0.5, 0.75 * std::numbers::sqrt2);
    expectNear(predictVisibility(corner, along({8, 0, 16}, {1, 1, 0}), unitInfo(square), kOneRay),
               {1, left, 1, left}); // no ray meets the third
}

/// The definition, brick by brick, without walking: the rays that are sent, their paths sorted by distance.
std::vector<double> slowVisibility(const LevelErrors& errors, const Camera& camera, const VolumeInfo& info,
                                   const glm::ivec2& size) {
    const glm::ivec3 bricks = errors.bricks;
    const glm::ivec2 rays = size / 4;
    const RayPlane plane = rayPlane(camera, info, size);
    const glm::dmat4 voxelFromPatient = glm::inverse(info.patientFromVoxel);
    std::vector<double> sums(cellCount(bricks)), counts(cellCount(bricks));
    struct Path {
        double near, length;
        std::size_t brick;
    };
    for (int y = 0; y < rays.y; ++y)
        for (int x = 0; x < rays.x; ++x) {
            const PatientRay ray =
                pixelRay(plane, glm::dvec2(size) * (glm::dvec2(x, y) + 0.5) / glm::dvec2(rays), size);
            const glm::dvec3 base(voxelFromPatient * glm::dvec4(ray.base, 1));
            const glm::dvec3 direction(glm::dmat3(voxelFromPatient) * ray.direction);
            std::vector<Path> paths;
            for (std::size_t b = 0; b < sums.size(); ++b) {
                const glm::dvec3 first(gridPosition(b, bricks) * kBrickExtent);
                double near = ray.minT, far = std::numeric_limits<double>::infinity();
                for (int axis = 0; axis < 3; ++axis) {
                    const double s = (first[axis] - base[axis]) / direction[axis],
                                 t = (first[axis] + kBrickExtent - base[axis]) / direction[axis];
                    near = std::max(near, std::min(s, t));
                    far = std::min(far, std::max(s, t));
                }
                if (near < far)
                    paths.push_back({near, (far - near) * glm::length(direction) / kBrickExtent, b});
            }
            std::sort(paths.begin(), paths.end(),
                      [](const Path& a, const Path& b) { return a.near < b.near; });
            double light = 1;
            for (const Path& path : paths) {
                sums[path.brick] += light;
                ++counts[path.brick];
                light *= std::pow(static_cast<double>(errors.transmittances[path.brick]), path.length);
            }
        }
    for (std::size_t b = 0; b < sums.size(); ++b)
        sums[b] = counts[b] > 0 ? std::max(sums[b] / counts[b], static_cast<double>(kHiddenVisibility)) : 1;
    return sums;
}

TEST(PredictVisibility, IsTheMeanOverRaysForAnyAffineAndCamera) {
    const VolumeInfo info = shearedInfo();
    const glm::ivec2 size(120, 88);
    LevelErrors e;
    e.bricks = brickGrid(info.extentVoxels);
    for (std::size_t b = 0; b < cellCount(e.bricks); ++b)
        e.transmittances.push_back(mixed(b) % 3 == 0 ? 1 : 0.05f + 0.9f * static_cast<float>(uniform(b)));
    const glm::dvec3 middle(info.patientFromVoxel * glm::dvec4(70.3, 41.7, 33.1, 1));
    Camera inside;
    inside.position = middle;
    inside.focalPoint = middle + glm::dvec3(1, 0.4, 0.2);
    inside.viewAngle = 110;
    Camera close = fitCamera(info, View::right, Projection::perspective, size);
    close.focalPoint += glm::dvec3(0, 40, 30);
    close.viewAngle = 8; // most bricks outside
    for (const Camera& camera :
         {fitCamera(info, View::anterior, Projection::perspective, size),
          fitCamera(info, View::superior, Projection::parallel, size), inside, close}) {
        const std::vector<float> found = predictVisibility(e, camera, info, size);
        const std::vector<double> expected = slowVisibility(e, camera, info, size);
        expectNear(found, expected);
        const auto between = std::count_if(expected.begin(), expected.end(),
                                           [](double seen) { return seen > 0.1 && seen < 0.9; });
        EXPECT_GT(between, 5); // or nothing was told apart
        for (const int threads : {1, 3})
            EXPECT_EQ(predictVisibility(e, camera, info, size, threads), found);
    }
}

TEST(PredictVisibility, LargePicturesDoNotOverflowItsSums) {
    const VolumeInfo info = unitInfo({32, 32, 32});
    LevelErrors e;
    e.bricks = {1, 1, 1};
    e.transmittances = {0.5f};
    Camera camera = along({16, 16, 16}, {0, 1, 0});
    camera.parallelScale = 8; // every ray meets the brick
    EXPECT_EQ(predictVisibility(e, camera, info, {16384, 16384}), std::vector<float>{1});
}

// -- fed back
// ------------------------------------------------------------------------------------------------------

TEST(VisibilityFactors, RiseAtOnceFallSlowlyAndDoNotFlicker) {
    Selection s;
    s.levels = {0, 5, 0, 0};
    const std::vector<SeenBrick> seen = {{25600, 100}, {0, 0}, {9, 100}, {3200, 100}},
                                 hidden(4, SeenBrick{0, 7}),
                                 jitter = {{20000, 100}, {15000, 100}, {0, 100}, {4000, 100}};
    const auto first = visibilityFactors(seen, s);
    EXPECT_EQ(first, (std::vector<float>{1, 1, kHiddenVisibility, 0.125f}));
    EXPECT_EQ(visibilityFactors(jitter, s, first), first);
    const auto next = visibilityFactors(hidden, s, first);
    EXPECT_EQ(next, (std::vector<float>{0.5f, kHiddenVisibility, kHiddenVisibility, 0.0625f}));
    auto later = next;
    for (int n = 0; n < 7; ++n)
        later = visibilityFactors(hidden, s, later);
    for (const float f : later)
        EXPECT_LE(f, 2 * kHiddenVisibility); // the dead band ends where hidden begins
    EXPECT_EQ(visibilityFactors(seen, s, later)[0], 1);
    EXPECT_EQ(visibilityFactors(std::vector<SeenBrick>(4, {UINT32_MAX, 1}), s)[0], 1);
}

TEST(VisibilityFactors, MoveBeyondTwiceAndHalfAndNotBefore) {
    const auto after = [](float last, std::uint32_t light, std::uint8_t level) {
        Selection s;
        s.levels = {level};
        const std::vector<SeenBrick> seen = {{light * SeenBrick::kLightOfRay, 128}};
        const std::vector<float> before = {last};
        return visibilityFactors(seen, s, before)[0];
    };
    EXPECT_EQ(after(0.25f, 64, 0), 0.25f); // just twice
    EXPECT_EQ(after(0.25f, 65, 0), 65.0f / 128);
    EXPECT_EQ(after(0.25f, 16, 0), 0.25f); // just half
    EXPECT_EQ(after(0.25f, 15, 0), 0.125f);
    EXPECT_EQ(after(0.25f, 15, kLevelCount - 1), 15.0f / 128); // a brick's mean is never lost
    EXPECT_EQ(after(0.25f, 15, Selection::kEmpty), 15.0f / 128);
}

} // namespace
} // namespace tessera
