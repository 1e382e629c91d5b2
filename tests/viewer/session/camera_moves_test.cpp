// tests/viewer/session/camera_moves_test.cpp: the effect of a hand on a camera, seen by the rays of pixels:
// the point that was under a pixel is where the hand took it.
#include "viewer/session/view_geometry.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

const glm::ivec2 kSize(400, 300);

VolumeInfo volumeInfo() {
    VolumeInfo info;
    info.extentVoxels = {100, 120, 80};
    info.patientFromVoxel = glm::dmat4(1);
    return info;
}

Camera oblique(Projection projection) {
    Camera camera;
    camera.projection = projection;
    camera.position = {300, -400, 250};
    camera.focalPoint = {40, 50, 60};
    camera.viewUp = {0.2, 0.1, 1};
    camera.viewAngle = 40;
    camera.parallelScale = 90;
    return camera;
}

/// The distance of a point from the ray through a place of the picture, mm.
double distanceFromRay(const Camera& camera, const glm::dvec2& pixel, const glm::dvec3& point) {
    const PatientRay ray = pixelRay(rayPlane(camera, volumeInfo(), kSize), pixel, kSize);
    return glm::length(glm::cross(point - ray.base, ray.direction));
}

/// The point at the focal point's depth that a place of the picture shows.
glm::dvec3 pointAt(const Camera& camera, const glm::dvec2& pixel) {
    const PatientRay ray = pixelRay(rayPlane(camera, volumeInfo(), kSize), pixel, kSize);
    const glm::dvec3 forward = glm::normalize(camera.focalPoint - camera.position);
    return ray.base + ray.direction * (glm::dot(camera.focalPoint - ray.base, forward) /
                                       glm::dot(ray.direction, forward));
}

// The content of a picture fits one of any other proportion: at the same depth, as far to each side and as
// high.
TEST(HeldBy, HoldsAllThatWasSeen) {
    for (const Projection projection : {Projection::perspective, Projection::parallel}) {
        const Camera camera = oblique(projection);
        for (const glm::ivec2& to : {glm::ivec2(400, 300), glm::ivec2(300, 400), glm::ivec2(1000, 300),
                                     glm::ivec2(80, 600), glm::ivec2(800, 600)}) {
            const Camera held = heldBy(camera, kSize, to);
            const double before = halfHeightMm(camera), now = halfHeightMm(held);
            EXPECT_GE(now, before * (1 - 1e-12));
            EXPECT_GE(now * to.x / to.y, before * kSize.x / kSize.y * (1 - 1e-12));
            EXPECT_NEAR(std::max(before, before * kSize.x / kSize.y * to.y / to.x), now, 1e-9 * now)
                << "and no more than that";
            EXPECT_EQ(held.position, camera.position);
        }
    }
}

class CameraMoves : public ::testing::TestWithParam<Projection> {};

TEST_P(CameraMoves, OrbitKeepsTheFocalPointAndItsDistance) {
    const Camera before = oblique(GetParam());
    Camera camera = before;
    for (int n = 0; n < 500; ++n)
        camera = orbited(camera, {0.03, -0.05 + 0.0002 * n});
    EXPECT_EQ(camera.focalPoint, before.focalPoint);
    EXPECT_NEAR(focalDistanceMm(camera), focalDistanceMm(before), 1e-9 * focalDistanceMm(before));
    EXPECT_NEAR(glm::dot(camera.viewUp, camera.position - camera.focalPoint), 0, 1e-6);
    EXPECT_NO_THROW(camera.validate("camera"));
}

TEST_P(CameraMoves, OrbitGoesToTheRightAndUp) {
    const Camera before = oblique(GetParam());
    const glm::dmat3 axes = patientFromCamera(before);
    const double quarter = glm::radians(90.0), distance = focalDistanceMm(before);
    const Camera right = orbited(before, {quarter, 0}), up = orbited(before, {0, quarter});
    EXPECT_LT(glm::length(right.position - (before.focalPoint + distance * axes[0])), 1e-9 * distance);
    EXPECT_LT(glm::length(up.position - (before.focalPoint + distance * axes[1])), 1e-9 * distance);
    // Over the pole and further: no flip.
    const Camera over = orbited(before, {0, 2 * quarter});
    EXPECT_LT(glm::length(over.viewUp + axes[1]), 1e-9);
}

TEST_P(CameraMoves, PanTakesWhatIsUnderThePointerAlong) {
    const Camera before = oblique(GetParam());
    const glm::dvec2 from(130, 90), by(45, -20);
    const glm::dvec3 point = pointAt(before, from);
    const Camera after = panned(before, glm::dvec2(by.x, by.y) / static_cast<double>(kSize.y));
    EXPECT_LT(distanceFromRay(after, from + by, point), 1e-6);
    EXPECT_GT(distanceFromRay(after, from, point), 1);
}

TEST_P(CameraMoves, ZoomKeepsWhatIsUnderThePointer) {
    const Camera before = oblique(GetParam());
    const glm::dvec2 at(310, 40), middle = 0.5 * glm::dvec2(kSize);
    const glm::dvec3 point = pointAt(before, at);
    const Camera after = zoomedAt(before, 1.7, (at - middle) / static_cast<double>(kSize.y));
    EXPECT_LT(distanceFromRay(after, at, point), 1e-6);
    EXPECT_NEAR(halfHeightMm(after), halfHeightMm(before) / 1.7, 1e-9 * halfHeightMm(before));
    // However long one turns the wheel.
    Camera camera = before;
    for (int n = 0; n < 2000; ++n)
        camera = zoomed(camera, n < 1000 ? 2 : 0.5);
    EXPECT_NO_THROW(camera.validate("camera"));
    EXPECT_GT(halfHeightMm(camera), 0);
}

TEST_P(CameraMoves, RollTurnsThePictureClockwise) {
    const Camera before = oblique(GetParam());
    const glm::dvec2 middle = 0.5 * glm::dvec2(kSize);
    const glm::dvec3 above = pointAt(before, middle + glm::dvec2(0, -100));
    EXPECT_LT(distanceFromRay(rolled(before, glm::radians(90.0)), middle + glm::dvec2(100, 0), above), 1e-6);
}

TEST_P(CameraMoves, OtherProjectionKeepsTheSizeAtTheFocalPoint) {
    const Camera before = oblique(GetParam());
    const Projection other =
        GetParam() == Projection::parallel ? Projection::perspective : Projection::parallel;
    const Camera after = projectedBy(before, other);
    EXPECT_EQ(after.projection, other);
    for (const glm::dvec2 pixel : {glm::dvec2(20, 30), glm::dvec2(390, 150)})
        EXPECT_LT(distanceFromRay(after, pixel, pointAt(before, pixel)), 1e-6);
    EXPECT_EQ(projectedBy(before, GetParam()), before);
}

TEST_P(CameraMoves, FlightGoesWhereItLooks) {
    const Camera before = oblique(GetParam());
    const glm::dvec3 forward = glm::normalize(before.focalPoint - before.position);
    const Camera ahead = flown(before, {0, 0, 25}, {0, 0});
    EXPECT_LT(glm::length(ahead.position - (before.position + 25.0 * forward)), 1e-9);
    EXPECT_LT(glm::length(ahead.focalPoint - (before.focalPoint + 25.0 * forward)), 1e-9);
    const glm::dmat3 axes = patientFromCamera(before);
    const Camera looks = flown(before, glm::dvec3(0), {glm::radians(90.0), 0});
    EXPECT_LT(glm::length(glm::normalize(looks.focalPoint - looks.position) - axes[0]), 1e-9)
        << "to the right";
    const Camera up = flown(before, glm::dvec3(0), {0, glm::radians(90.0)});
    EXPECT_LT(glm::length(glm::normalize(up.focalPoint - up.position) - axes[1]), 1e-9) << "up";
}

TEST_P(CameraMoves, SidesAndCentreAreWhatTheySay) {
    const Camera before = oblique(GetParam());
    const Camera left = seenFrom(before, View::left);
    EXPECT_LT(glm::length(glm::normalize(left.position - left.focalPoint) - viewAxes(View::left).towards),
              1e-12);
    EXPECT_NEAR(focalDistanceMm(left), focalDistanceMm(before), 1e-9);
    const Camera centred = centredOn(before, {10, 20, 30});
    EXPECT_EQ(centred.focalPoint, glm::dvec3(10, 20, 30));
    EXPECT_LT(glm::length(centred.position - centred.focalPoint - (before.position - before.focalPoint)),
              1e-9);
}

INSTANTIATE_TEST_SUITE_P(Both, CameraMoves, ::testing::Values(Projection::perspective, Projection::parallel));

} // namespace
} // namespace tessera
