// tests/core/scene/camera_frames_test.cpp: frames, rays and fits of cameras against their definitions.
#include "core/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace tessera {
namespace {

double apart(const glm::dvec3& a, const glm::dvec3& b) {
    return glm::length(a - b);
}

Camera someCamera(std::mt19937& random) {
    std::uniform_real_distribution<double> place(-300, 300);
    Camera camera;
    camera.position = {place(random), place(random), place(random)};
    camera.focalPoint = camera.position + glm::dvec3(place(random), place(random), place(random));
    camera.viewUp = {place(random), place(random), place(random)};
    camera.viewAngle = 10 + std::abs(place(random)) / 3;
    camera.parallelScale = 1 + std::abs(place(random));
    return camera;
}

VolumeInfo someVolume() {
    VolumeInfo info;
    info.extentVoxels = {100, 80, 120};
    info.patientFromVoxel = patientFromVoxelOf({-50, -40, 10}, {1, 0.2, 0}, {0, 1, 0.1}, {0, 0.3, 1.5});
    return info;
}

/// The axes are right-handed and unit, towards the viewer and as near to the given up as they can be.
TEST(CameraAxes, AreAFrameThatLooksAtTheFocalPoint) {
    std::mt19937 random(1);
    for (int i = 0; i < 200; ++i) {
        const Camera camera = someCamera(random);
        const glm::dmat3 axes = patientFromCamera(camera);
        EXPECT_LT(
            glm::length(axes * glm::dvec3(0, 0, 1) - glm::normalize(camera.position - camera.focalPoint)),
            1e-12);
        EXPECT_NEAR(glm::determinant(axes), 1, 1e-9);
        const glm::dmat3 product = glm::transpose(axes) * axes;
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column)
                EXPECT_NEAR(product[column][row], row == column ? 1 : 0, 1e-9);
        EXPECT_GT(glm::dot(axes[1], camera.viewUp), 0);
        EXPECT_NEAR(glm::dot(axes[0], camera.viewUp), 0, 1e-9 * glm::length(camera.viewUp));
        // It moves with the camera.
        Camera moved = camera;
        moved.position += glm::dvec3(7, 8, 9), moved.focalPoint += glm::dvec3(7, 8, 9);
        EXPECT_LT(apart(patientFromCamera(moved)[0], axes[0]), 1e-9);
    }
}

/// Rays of a picture: the middle one looks ahead; the upper edge has half the angle of view; left and right,
/// up and down are mirror images.
TEST(CameraRays, HaveTheAnglesOfTheCamera) {
    std::mt19937 random(2);
    const VolumeInfo info = someVolume();
    const glm::ivec2 size(64, 48);
    for (int i = 0; i < 60; ++i) {
        Camera camera = someCamera(random);
        const glm::dmat3 axes = patientFromCamera(camera);
        const RayPlane plane = rayPlane(camera, info, size);
        EXPECT_TRUE(plane.perspective);
        const PatientRay middle = pixelRay(plane, {32, 24}, size), top = pixelRay(plane, {32, 0}, size),
                         right = pixelRay(plane, {64, 24}, size), left = pixelRay(plane, {0, 24}, size);
        EXPECT_LT(apart(middle.direction, -axes[2]), 1e-9);
        EXPECT_NEAR(glm::degrees(std::acos(glm::dot(middle.direction, top.direction))), camera.viewAngle / 2,
                    1e-6);
        EXPECT_GT(glm::dot(top.direction, axes[1]), 0);
        EXPECT_GT(glm::dot(right.direction, axes[0]), 0);
        EXPECT_NEAR(glm::dot(right.direction, axes[0]), -glm::dot(left.direction, axes[0]), 1e-9);
        EXPECT_NEAR(glm::dot(right.direction, axes[0]) / glm::dot(right.direction, -axes[2]),
                    64.0 / 48 * std::tan(glm::radians(camera.viewAngle / 2)), 1e-6);
        for (const PatientRay& ray : {middle, top, right, left})
            EXPECT_LT(apart(ray.base + ray.minT * ray.direction, camera.position), 1e-6);
        // the plane is at the volume's middle, or a radius ahead
        const glm::dvec3 centre(info.patientFromVoxel * glm::dvec4(50, 40, 60, 1));
        double radius = 0;
        for (int n = 0; n < 8; ++n)
            radius = std::max(radius, apart(centre, glm::dvec3(info.patientFromVoxel *
                                                               glm::dvec4(100 * (n & 1), 80 * (n >> 1 & 1),
                                                                          120 * (n >> 2), 1))));
        const double ahead = std::max(glm::dot(centre - camera.position, plane.forward), radius);
        EXPECT_LT(apart(plane.centre, camera.position + ahead * plane.forward), 1e-6);
        camera.projection = Projection::parallel;
        const RayPlane flat = rayPlane(camera, info, size);
        EXPECT_FALSE(flat.perspective);
        const PatientRay a = pixelRay(flat, {32, 0}, size), b = pixelRay(flat, {32, 48}, size);
        EXPECT_LT(apart(a.direction, -axes[2]), 1e-9);
        EXPECT_NEAR(apart(a.base, b.base), 2 * camera.parallelScale, 1e-6);
        EXPECT_NEAR(apart(pixelRay(flat, {0, 5}, size).base, pixelRay(flat, {64, 5}, size).base),
                    2 * camera.parallelScale * 64 / 48, 1e-6);
        EXPECT_EQ(a.minT, -std::numeric_limits<double>::infinity());
    }
}

TEST(FittedCameras, HaveThirtyDegreesAndThreePercentOfMargin) {
    const VolumeInfo info = someVolume();
    const glm::dvec3 centre(info.patientFromVoxel * glm::dvec4(50, 40, 60, 1));
    for (const View view : {View::anterior, View::left, View::superior}) {
        const Camera camera = fitCamera(info, view, Projection::perspective, {300, 200});
        EXPECT_EQ(camera.viewAngle, 30);
        EXPECT_LT(apart(camera.focalPoint, centre), 1e-9);
        const ViewAxes axes = viewAxes(view);
        const Camera flat = fitCamera(info, view, Projection::parallel, {300, 200});
        double half = 0, tangent = 0;
        for (int n = 0; n < 8; ++n) {
            const glm::dvec3 p = glm::dvec3(info.patientFromVoxel *
                                            glm::dvec4(100 * (n & 1), 80 * (n >> 1 & 1), 120 * (n >> 2), 1)) -
                                 centre;
            half = std::max({half, std::abs(glm::dot(p, axes.up)), std::abs(glm::dot(p, axes.right)) / 1.5});
            const double depth = apart(camera.position, centre) - glm::dot(p, axes.towards);
            tangent = std::max({tangent, std::abs(glm::dot(p, axes.up)) / depth,
                                std::abs(glm::dot(p, axes.right)) / depth / 1.5});
        }
        EXPECT_NEAR(flat.parallelScale, 1.03 * half, 1e-9 * half);
        EXPECT_NEAR(std::tan(glm::radians(15.0)), 1.03 * tangent, 1e-9);
        EXPECT_NEAR(glm::dot(glm::normalize(flat.position - flat.focalPoint), axes.towards), 1, 1e-12);
    }
}

} // namespace
} // namespace tessera
