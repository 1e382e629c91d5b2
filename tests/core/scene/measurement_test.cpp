// tests/core/scene/measurement_test.cpp: measurements against triangles and circles that are known by
// construction.
#include "core/scene/measurement.h"

#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

namespace tessera {
namespace {

/// Anywhere in space, turned.
glm::dvec3 placed(const glm::dvec3& p) {
    const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 0.7, glm::normalize(glm::dvec3(1, -2, 0.5)));
    return glm::dvec3(turn * glm::dvec4(p, 0)) + glm::dvec3(-310, 95, 1200);
}

TEST(Measurements, DistancesAndAngles) {
    EXPECT_NEAR(valueOf({MeasurementKind::distance, {placed({0, 0, 0}), placed({3, 4, 12})}}), 13, 1e-9);
    for (const double degrees : {0.0, 1e-5, 30.0, 90.0, 179.99999, 180.0}) {
        const double a = glm::radians(degrees);
        const Measurement m{
            MeasurementKind::angle,
            {placed({5, 0, 0}), placed({0, 0, 0}), placed({7 * std::cos(a), 7 * std::sin(a), 0})}};
        EXPECT_NEAR(valueOf(m), degrees, 1e-6) << degrees;
    }
    for (const double arm : {1.0, 2.0}) // of any length but none
        EXPECT_NEAR(valueOf({MeasurementKind::angle, {{arm, 0, 0}, {0, 0, 0}, {0, 3 - arm, 0}}}), 90, 1e-9);
    EXPECT_TRUE(std::isnan(valueOf({MeasurementKind::angle, {{1, 0, 0}, {1, 0, 0}, {2, 0, 0}}})));
    EXPECT_TRUE(std::isnan(valueOf({MeasurementKind::angle, {{2, 0, 0}, {1, 0, 0}, {1, 0, 0}}})));
    EXPECT_TRUE(std::isnan(valueOf({MeasurementKind::distance, {{1, 0, 0}}})));
}

TEST(Measurements, CirclesThroughThreePlaces) {
    const glm::dvec3 centre(4, -7, 2);
    const auto on = [&](double angle) {
        return placed(centre + 11.0 * glm::dvec3(std::cos(angle), std::sin(angle), 0));
    };
    for (const double second : {0.02, 1.0, 2.5, 4.0}) {
        const Measurement m{MeasurementKind::circle, {on(0), on(second), on(second + 1.1)}};
        EXPECT_NEAR(valueOf(m), 11, 1e-6) << second;
        EXPECT_LT(glm::length(circleCentre(m) - placed(centre)), 1e-6) << second;
    }
    const Measurement line{MeasurementKind::circle, {{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}};
    EXPECT_TRUE(std::isinf(valueOf(line)));
    EXPECT_EQ(circleCentre(line), glm::dvec3(2, 2, 2));
    EXPECT_EQ(describe(line), "no circle: a line");
}

TEST(Measurements, AreToldInMillimetres) {
    EXPECT_EQ(describe({MeasurementKind::distance, {{0, 0, 0}, {0, 12.34, 0}}}), "12.3 mm");
    EXPECT_EQ(describe({MeasurementKind::angle, {{1, 0, 0}, {0, 0, 0}, {0, 3, 0}}}), "90.0°");
    EXPECT_EQ(describe({MeasurementKind::circle, {{10, 0, 0}, {0, 10, 0}, {-10, 0, 0}}}),
              "radius 10.0 mm, area 314 mm²");
    EXPECT_EQ(describe({MeasurementKind::distance, {}}), "not whole");
}

} // namespace
} // namespace tessera
