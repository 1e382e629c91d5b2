// tests/core/scene/scale_bar_test.cpp: a bar is as long as it says, whatever the camera: of a round length,
// and not longer than a quarter of the picture.
#include "core/scene/measurement.h"

#include <algorithm>
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

// White ends as far apart as the bar is long; beyond it and its text nothing is touched.
TEST(ScaleBar, IsDrawnAtTheLowerRight) {
    for (const glm::ivec2 size :
         {glm::ivec2(512, 512), glm::ivec2(1920, 1080), glm::ivec2(90, 70), glm::ivec2(8, 6)})
        for (const double mmPerPixel : {0.137, 0.9, 31.0}) {
            Image image(size);
            const glm::vec4 before(0.25f, 0.5f, 0.125f, 0.5f);
            std::fill(image.pixels.begin(), image.pixels.end(), before);
            const ScaleBar bar = scaleBarOf(mmPerPixel, size.x);
            drawScaleBar(image, bar);
            // The lowest row that is white is the lower end of both marks.
            int lowest = size.y - 1;
            const auto isWhite = [&](int x, int y) { return image.at(x, y) == glm::vec4(1); };
            const auto whites = [&](int y) {
                std::vector<int> all;
                for (int x = 0; x < size.x; ++x)
                    if (isWhite(x, y))
                        all.push_back(x);
                return all;
            };
            while (lowest > 0 && whites(lowest).empty())
                --lowest;
            if (size.x < 50)
                continue; // it need not fit, and does no harm
            const std::vector<int> marks = whites(lowest);
            ASSERT_FALSE(marks.empty());
            EXPECT_NEAR(marks.back() + 1 - marks.front(), bar.pixels, 0.5001) << size.x << " " << mmPerPixel;
            EXPECT_LT(static_cast<std::size_t>(marks.size()), bar.pixels)
                << "two marks, nothing between them";
            int touched = size.x;
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x)
                    if (image.at(x, y) != before) {
                        touched = std::min(touched, x);
                        EXPECT_GT(y, size.y / 2);
                        EXPECT_EQ(image.at(x, y).a, 1);
                    }
            EXPECT_GT(touched, size.x / 8);
        }
}

} // namespace
} // namespace tessera
