// tests/core/scene/scale_bar_test.cpp: a bar is as long as it says, whatever the camera: of a round length,
// and not longer than a quarter of the picture.
#include "core/scene/measurement.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

namespace tessera {
namespace {

/// The distance between the rays of two pixels on the plane through the focal point that faces the camera.
double apartAtTheCentre(const Camera& camera, const glm::ivec2& size, const glm::dvec2& a,
                        const glm::dvec2& b) {
    VolumeInfo info;
    info.extentVoxels = glm::ivec3(64);
    const RayPlane plane = rayPlane(camera, info, size);
    const auto meet = [&](const glm::dvec2& pixel) {
        const PatientRay ray = pixelRay(plane, pixel, size);
        const glm::dvec3 towards = patientFromCamera(camera)[2];
        const double t = glm::dot(camera.focalPoint - ray.base, towards) / glm::dot(ray.direction, towards);
        return ray.base + t * ray.direction;
    };
    return glm::length(meet(a) - meet(b));
}

TEST(ScaleBar, IsAsLongAsItSays) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int n = 0; n < 200; ++n) {
        Camera camera;
        camera.position = {300 * unit(random) - 150, -2000 * unit(random) - 5, 90 * unit(random)};
        camera.focalPoint = {9 * unit(random), 0, 5};
        camera.viewAngle = 5 + 140 * unit(random);
        camera.parallelScale = std::pow(10, 6 * unit(random) - 2);
        camera.projection = n % 2 ? Projection::parallel : Projection::perspective;
        const glm::ivec2 size(64 + static_cast<int>(1500 * unit(random)),
                              64 + static_cast<int>(900 * unit(random)));
        const ScaleBar bar = scaleBarOf(camera, size);
        const glm::dvec2 middle = 0.5 * glm::dvec2(size), half(bar.pixels / 2, 0);
        EXPECT_NEAR(apartAtTheCentre(camera, size, middle - half, middle + half), bar.mm, 1e-6 * bar.mm);
        EXPECT_LE(bar.pixels, 0.25 * size.x + 1e-9);
        EXPECT_GT(bar.pixels, 0.1 * size.x - 1e-9);
        EXPECT_EQ(bar.everywhere, camera.projection == Projection::parallel);
        EXPECT_EQ(bar.text().find("at the centre") == std::string::npos, bar.everywhere);
        const double digits = bar.mm / std::pow(10, std::floor(std::log10(bar.mm * 1.0001)));
        EXPECT_TRUE(std::abs(digits - 1) < 1e-9 || std::abs(digits - 2) < 1e-9 || std::abs(digits - 5) < 1e-9)
            << bar.mm;
    }
}

TEST(ScaleBar, NamesItsLength) {
    EXPECT_EQ((ScaleBar{50, 10, true}.text()), "50 mm");
    EXPECT_EQ((ScaleBar{0.2, 10, false}.text()), "0.2 mm at the centre");
    EXPECT_EQ((ScaleBar{20000, 10, true}.text()), "20 m");
    EXPECT_EQ(roundLength(49.9), 20);
    EXPECT_EQ(roundLength(50), 50);
    EXPECT_EQ(roundLength(0), 1);
}

} // namespace
} // namespace tessera
