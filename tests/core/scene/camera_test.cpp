// Cameras in patient space: which side faces the viewer, where left is, that everything fits, and that rays
// of a far camera stay exact.
#include "core/scene/camera.h"

#include "core/base/error.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <vector>

namespace tessera {
namespace {

VolumeInfo ctVolume() {
    VolumeInfo info;
    info.extentVoxels = {100, 80, 120};
    info.patientFromVoxel = patientFromVoxelOf({-50, -40, 10}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1.5});
    return info;
}

/// The pixel of a patient point, by intersecting the ray plane.
glm::dvec2 project(const RayPlane& plane, const glm::dvec3& point, const glm::ivec2& size) {
    glm::dvec3 at = point;
    if (plane.perspective) {
        const glm::dvec3 eye = plane.centre - plane.toCentre;
        at = eye +
             (point - eye) * (glm::dot(plane.toCentre, plane.forward) / glm::dot(point - eye, plane.forward));
    }
    const glm::dvec3 offset = at - plane.centre;
    const double x = glm::dot(offset, plane.right) / glm::dot(plane.right, plane.right);
    const double y = glm::dot(offset, plane.up) / glm::dot(plane.up, plane.up);
    return {0.5 * (x + 1) * size.x, 0.5 * (1 - y) * size.y};
}

class EveryView : public testing::TestWithParam<std::tuple<View, Projection>> {};

TEST_P(EveryView, ShowsTheWholeVolume) {
    const VolumeInfo info = ctVolume();
    for (const glm::ivec2 size : {glm::ivec2(512, 512), glm::ivec2(640, 200), glm::ivec2(200, 640)}) {
        const Camera camera = fitCamera(info, std::get<0>(GetParam()), std::get<1>(GetParam()), size);
        camera.validate("test");
        const RayPlane plane = rayPlane(camera, info, size);
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 voxel =
                glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, (corner >> 1) & 1, corner >> 2);
            const glm::dvec2 pixel =
                project(plane, glm::dvec3(info.patientFromVoxel * glm::dvec4(voxel, 1)), size);
            EXPECT_GT(pixel.x, 0) << size.x;
            EXPECT_LT(pixel.x, size.x);
            EXPECT_GT(pixel.y, 0);
            EXPECT_LT(pixel.y, size.y);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Views, EveryView,
                         testing::Combine(testing::Values(View::anterior, View::posterior, View::left,
                                                          View::right, View::superior, View::inferior),
                                          testing::Values(Projection::perspective, Projection::parallel)));

// Boxes anywhere in space: all of each inside the picture, and the picture full but for its margin, along the
// tighter axis from edge to edge.
TEST_P(EveryView, FitsWhatItIsGiven) {
    const VolumeInfo info = ctVolume();
    for (const glm::ivec2 size : {glm::ivec2(512, 512), glm::ivec2(640, 200), glm::ivec2(200, 640)}) {
        ViewFit fit(std::get<0>(GetParam()), std::get<1>(GetParam()), size);
        EXPECT_TRUE(fit.empty());
        const ViewAxes& axes = fit.axes();
        const std::vector<std::pair<glm::dvec3, glm::dvec3>> boxes = {
            {{-40, 12, 150}, {3, 1, 2}}, {{70, 20, -90}, {9, 4, 1}}, {{10, -35, 60}, {0.5, 0.5, 25}}};
        for (const auto& [centre, half] : boxes) {
            EXPECT_TRUE(!fit.empty() || !fit.holds(centre, half));
            fit.add(centre, half);
            EXPECT_TRUE(fit.holds(centre, half));
        }
        const Camera camera = fit.camera();
        camera.validate("test");
        const RayPlane plane = rayPlane(camera, info, size);
        glm::dvec2 low(1e9), high(-1e9);
        for (const auto& [centre, half] : boxes)
            for (int corner = 0; corner < 8; ++corner) {
                const glm::dvec3 p =
                    centre + half * (2.0 * glm::dvec3(corner & 1, (corner >> 1) & 1, corner >> 2) - 1.0);
                const glm::dvec2 pixel =
                    project(plane, axes.right * p.x + axes.up * p.y + axes.towards * p.z, size);
                low = glm::min(low, pixel / glm::dvec2(size));
                high = glm::max(high, pixel / glm::dvec2(size));
            }
        const double margin = 0.5 - 0.5 / 1.03;
        const glm::dvec2 room = glm::min(low, 1.0 - high);
        EXPECT_NEAR(std::min(room.x, room.y), margin, 1e-9) << size.x;
        EXPECT_GE(std::max(room.x, room.y), margin - 1e-9) << size.x;
        const int tight = room.x < room.y ? 0 : 1;
        EXPECT_NEAR(low[tight], margin, 1e-9);
        EXPECT_NEAR(high[tight], 1 - margin, 1e-9);
    }
}

TEST(Camera, LeftAndRightAsRadiologistsExpect) {
    const VolumeInfo info = ctVolume();
    const glm::ivec2 size(100, 100);
    const glm::dvec3 middle(0, 0, 100);
    const auto at = [&](View view, const glm::dvec3& p) {
        return project(rayPlane(fitCamera(info, view, Projection::parallel, size), info, size), p, size);
    };
    const glm::dvec3 left(20, 0, 0), posterior(0, 20, 0), superior(0, 0, 20); // LPS
    EXPECT_GT(at(View::anterior, middle + left).x, at(View::anterior, middle).x);
    EXPECT_LT(at(View::posterior, middle + left).x, at(View::posterior, middle).x);
    EXPECT_GT(at(View::left, middle + posterior).x, at(View::left, middle).x);
    EXPECT_LT(at(View::right, middle + posterior).x, at(View::right, middle).x);
    for (const View view : {View::anterior, View::posterior, View::left, View::right})
        EXPECT_LT(at(view, middle + superior).y, at(view, middle).y); // up in the picture
    EXPECT_GT(at(View::superior, middle + posterior).y, at(View::superior, middle).y);
    EXPECT_LT(at(View::superior, middle + left).x, at(View::superior, middle).x);
    EXPECT_GT(at(View::inferior, middle + left).x, at(View::inferior, middle).x);
}

TEST(Camera, RayBasesStayNearTheVolumeFromAMillionMillimetres) {
    const VolumeInfo info = ctVolume();
    Camera camera;
    camera.position = {0, -1e6, 100};
    camera.focalPoint = {0, 0, 100};
    camera.viewAngle = 0.01;
    const RayPlane plane = rayPlane(camera, info, {64, 64});
    for (const glm::dvec2 pixel : {glm::dvec2(0.5, 0.5), glm::dvec2(32, 32), glm::dvec2(63.5, 10.5)}) {
        const PatientRay ray = pixelRay(plane, pixel, {64, 64});
        EXPECT_LT(glm::length(ray.base - glm::dvec3(0, 0, 100)), 300);
        EXPECT_NEAR(glm::length(ray.direction), 1, 1e-12);
        EXPECT_LT(glm::length(ray.base + ray.minT * ray.direction - camera.position), 1e-6);
    }
}

// The ray of a pixel passes where project() says that the pixel is: from the left edge, 0, to the right, the
// size.
TEST(Camera, RaysOfPixelsFillThePicture) {
    const VolumeInfo info = ctVolume();
    const glm::ivec2 size(30, 20);
    for (const Projection projection : {Projection::perspective, Projection::parallel}) {
        const RayPlane plane = rayPlane(fitCamera(info, View::left, projection, size), info, size);
        for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(0.5, 19.5), glm::dvec2(30, 20)}) {
            const PatientRay ray = pixelRay(plane, pixel, size);
            for (const double t : {0.0, 40.0})
                EXPECT_LT(glm::length(project(plane, ray.base + t * ray.direction, size) - pixel), 1e-9)
                    << pixel.x << " " << t;
        }
    }
}

TEST(Camera, ThePlaneIsInFrontOfAnEyeWithinTheVolumeOrBeyond) {
    const VolumeInfo info = ctVolume();
    for (const double y : {-30.0, 0.0, 30.0, 500.0}) { // looking towards +y
        Camera camera;
        camera.position = {0, y, 100};
        camera.focalPoint = {0, y + 1, 100};
        const RayPlane plane = rayPlane(camera, info, {64, 64});
        EXPECT_GT(glm::dot(plane.toCentre, plane.forward), 10) << y;
        EXPECT_GT(pixelRay(plane, {10, 10}, {64, 64}).direction.y, 0) << y;
    }
}

TEST(Camera, RefusesWhatCannotBeDrawn) {
    Camera camera;
    camera.focalPoint = camera.position;
    EXPECT_THROW(camera.validate("scene.json"), InputError);
    camera = Camera{};
    camera.viewUp = {0, 1, 0}; // along the direction of view
    EXPECT_THROW(camera.validate("scene.json"), InputError);
    camera = Camera{};
    camera.viewUp = {0, 0, 1e-12}; // short, but a direction
    EXPECT_NO_THROW(camera.validate("scene.json"));
    camera = Camera{};
    camera.viewAngle = 180;
    EXPECT_THROW(camera.validate("scene.json"), InputError);
}

// Turned about the patient's axis and up: sides at multiples of 90 degrees exactly, a right-handed frame
// between them.
TEST(Camera, AxesOfAngles) {
    const auto same = [](const ViewAxes& a, const ViewAxes& b) {
        return a.right == b.right && a.up == b.up && a.towards == b.towards;
    };
    EXPECT_TRUE(same(viewAxes(ViewAngles{0, 0}), viewAxes(View::anterior)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{90, 0}), viewAxes(View::left)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{-90, 0}), viewAxes(View::right)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{270, 0}), viewAxes(View::right)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{180, 0}), viewAxes(View::posterior)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{-360, 0}), viewAxes(View::anterior)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{180, 90}), viewAxes(View::superior)));
    EXPECT_TRUE(same(viewAxes(ViewAngles{0, -90}), viewAxes(View::inferior)));
    for (double turn = -360; turn <= 360; turn += 17)
        for (double rise = -90; rise <= 90; rise += 13) {
            const ViewAxes axes = viewAxes(ViewAngles{turn, rise});
            EXPECT_NEAR(glm::length(axes.up), 1, 1e-12);
            EXPECT_NEAR(glm::dot(axes.up, axes.towards), 0, 1e-12);
            EXPECT_NEAR(glm::length(glm::cross(axes.right, axes.up) - axes.towards), 0, 1e-12);
            EXPECT_NEAR(axes.towards.z, std::sin(glm::radians(rise)), 1e-12) << "the angle above the horizon";
            EXPECT_GE(axes.up.z, -1e-12) << "the head is up";
            if (std::abs(rise) < 89) {
                const glm::dvec2 flat = glm::normalize(glm::dvec2(axes.towards));
                EXPECT_NEAR(flat.x, std::sin(glm::radians(turn)), 1e-9) << "the patient's left";
                EXPECT_NEAR(flat.y, -std::cos(glm::radians(turn)), 1e-9) << "the front";
            }
        }
}

// The eye of a parallel view is four half heights before the nearest that it shows; it aims at the middle.
TEST(Camera, AParallelEyeIsInFrontOfEverything) {
    for (const View view : {View::anterior, View::left, View::inferior}) {
        ViewFit fit(view, Projection::parallel, {100, 50});
        fit.add({10, 20, 30}, {3, 4, 5});
        const Camera camera = fit.camera();
        EXPECT_NEAR(camera.parallelScale, 1.03 * 4, 1e-12) << "twice as wide as high";
        const ViewAxes& axes = fit.axes();
        EXPECT_NEAR(glm::dot(camera.position, axes.towards), 35 + 4 * 1.03 * 4, 1e-9);
        EXPECT_NEAR(glm::dot(camera.focalPoint, axes.towards), 30, 1e-9);
        for (const glm::dvec3& place : {camera.position, camera.focalPoint}) {
            EXPECT_NEAR(glm::dot(place, axes.right), 10, 1e-9);
            EXPECT_NEAR(glm::dot(place, axes.up), 20, 1e-9);
        }
        ViewFit other(view, Projection::parallel, {100, 50});
        other.add({-30, 20, 0}, {1, 1, 1});
        fit.add(other);
        EXPECT_TRUE(fit.holds({-30, 20, 0}, {1, 1, 1}));
        EXPECT_FALSE(fit.holds({-30, 20, 0}, {1.01, 1, 1}));
        EXPECT_NEAR(glm::dot(fit.camera().focalPoint, axes.towards), 17, 1e-9) << "between -1 and 35";
    }
}

} // namespace
} // namespace tessera
