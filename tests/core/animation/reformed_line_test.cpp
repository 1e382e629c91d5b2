// tests/core/animation/reformed_line_test.cpp: reformations of lines whose lengths, curvatures and
// projections are known in closed form.
#include "core/animation/reformed_line.h"

#include "core/base/error.h"
#include "tests/support/curves.h"

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

namespace tessera {
namespace {

using test::curveOf;

constexpr double kPi = std::numbers::pi;

/// Of radius 30 mm, 8 mm a radian, about z; a whole number of turns.
constexpr double kHelixRadius = 30, kHelixRise = 8;
const double kHelixSpeed = std::hypot(kHelixRadius, kHelixRise); // mm a radian
glm::dvec3 onReformedHelix(double mm) {
    const double a = mm / kHelixSpeed;
    return {kHelixRadius * std::cos(a), kHelixRadius * std::sin(a), kHelixRise * a};
}
FlightCurve twoHelixTurns() {
    return curveOf(4 * kPi * kHelixSpeed, onReformedHelix);
}
glm::dvec3 onCircle(double mm) {
    return {25 * std::cos(mm / 25), 25 * std::sin(mm / 25), 0};
}

void expectFrames(const Reformation& picture) {
    for (const ReformedRow& row : picture.rows) {
        ASSERT_NEAR(glm::length(row.across), 1, 1e-9);
        ASSERT_NEAR(glm::length(row.towards), 1, 1e-9);
        ASSERT_NEAR(glm::dot(row.across, row.towards), 0, 1e-9);
    }
}

TEST(ReformedLine, AStraightenedHelixHasItsLengthAndNoTwist) {
    const FlightCurve line = twoHelixTurns();
    for (const double degrees : {0.0, 37.0, 90.0, 300.0})
        for (const int samples : {1, 3}) {
            const double step = 0.5 / samples;
            const Reformation picture = straightened(line, degrees, {40, 0.5, samples});
            EXPECT_EQ(picture.size().x, 80);
            EXPECT_NEAR(picture.size().y * 0.5, 4 * kPi * kHelixSpeed, 0.5 + 0.3);
            expectFrames(picture);
            double twist = 0;
            for (std::size_t y = 1; y < picture.rows.size(); ++y) {
                const ReformedRow &row = picture.rows[y], &before = picture.rows[y - 1];
                EXPECT_NEAR(glm::distance(row.at, before.at), step, 1e-3 * step);
                EXPECT_NEAR(row.lineMm, 20, 1e-12);
                const glm::dvec3 down = glm::normalize(row.at - before.at);
                EXPECT_NEAR(glm::dot(down, row.across), 0, 0.01); // half a step's turn
                twist += glm::dot(row.across - before.across, row.towards);
            }
            EXPECT_LT(std::abs(twist), 3e-3) << "radians over all of the line"; // torsion's would be 3.3
        }
}

TEST(ReformedLine, TheViewerTurnsClockwiseFromUp) {
    const FlightCurve line = curveOf(50, [](double mm) { return glm::dvec3(0, 0, -mm); });
    const auto first = [&](double degrees) { return straightened(line, degrees, {20, 1, 1}).rows.front(); };
    // Downwards: up is the front; so the picture is a coronal one, with the patient's left at the right.
    EXPECT_LT(glm::distance(first(0).towards, {0, -1, 0}), 1e-9);
    EXPECT_LT(glm::distance(first(0).across, {1, 0, 0}), 1e-9);
    EXPECT_LT(glm::distance(first(90).towards, glm::cross(glm::dvec3(0, 0, -1), glm::dvec3(0, -1, 0))), 1e-9);
    EXPECT_LT(glm::distance(first(180).across, {-1, 0, 0}), 1e-9) << "half a turn mirrors";
}

TEST(ReformedLine, RowsFoldAtTheCentreOfCurvature) {
    const FlightCurve line = curveOf(100, onCircle);
    // Up is z, so at 0 degrees the picture lies in the circle's plane.
    int right = 0, left = 0;
    for (const double degrees : {0.0, 180.0, 60.0, 90.0}) {
        const Reformation picture = straightened(line, degrees, {80, 1, 1});
        for (std::size_t y = 6; y + 6 < picture.rows.size(); ++y) {
            const ReformedRow& row = picture.rows[y];
            const double inwards = glm::dot(row.across, glm::normalize(-row.at)), radius = 25;
            if (inwards > 1e-3) {
                ++right;
                EXPECT_NEAR(row.highMm, radius / inwards, 0.03 * radius / inwards);
                EXPECT_EQ(row.lowMm, -std::numeric_limits<double>::infinity());
            } else if (inwards < -1e-3) {
                ++left;
                EXPECT_NEAR(row.lowMm, radius / inwards, 0.03 * radius / -inwards);
            }
            EXPECT_FALSE(row.folds(row.lineMm));
            if (std::abs(inwards) > 0.9) {
                EXPECT_TRUE(row.folds(row.lineMm + (inwards > 0 ? 30 : -30)));
                EXPECT_FALSE(row.folds(row.lineMm - (inwards > 0 ? 30 : -30)));
            }
        }
    }
    EXPECT_GT(right, 50);
    EXPECT_GT(left, 50);
}

/// The length of the line as the picture has it: down by a row, and across by the line's shift.
double lengthInPicture(const Reformation& picture) {
    double length = 0;
    const double step = picture.mmPerPixel / picture.samples;
    for (std::size_t y = 1; y < picture.rows.size(); ++y)
        length += std::hypot(step, picture.rows[y].lineMm - picture.rows[y - 1].lineMm);
    return length;
}

TEST(ReformedLine, AStretchedLineKeepsItsLengthAndAngles) {
    const FlightCurve line = twoHelixTurns();
    for (const glm::dvec3 direction :
         {glm::dvec3(0, 0, 2), glm::dvec3(1, 0, 0), glm::dvec3(0.3, -0.5, 0.8), glm::dvec3(-1, 0, 0)}) {
        const Stretched out = stretched(line, direction, {0, 0, 1}, {30, 0.25, 1});
        expectFrames(out.picture);
        EXPECT_NEAR(lengthInPicture(out.picture), 4 * kPi * kHelixSpeed, 0.01 * 4 * kPi * kHelixSpeed);
        EXPECT_TRUE(out.endOnTop);
        EXPECT_GT(out.picture.rows.front().at.z, out.picture.rows.back().at.z);
        double low = 1e9, high = -1e9;
        for (std::size_t y = 1; y < out.picture.rows.size(); ++y) {
            const ReformedRow &row = out.picture.rows[y], &before = out.picture.rows[y - 1];
            low = std::min(low, row.lineMm), high = std::max(high, row.lineMm);
            // Places below one another are as far apart as in the picture, and the picture is not mirrored.
            const glm::dvec3 down = row.place(7) - before.place(7);
            EXPECT_NEAR(glm::length(down), 0.25, 0.02);
            EXPECT_NEAR(glm::dot(down, row.across), 0, 1e-9);
            EXPECT_GT(glm::dot(glm::cross(down, row.across), row.towards), 0.2);
        }
        EXPECT_NEAR(0.5 * (low + high), 0.5 * 0.25 * out.picture.columns, 0.3) << "in the middle";
        EXPECT_GT(low, 14);
        EXPECT_GT(0.25 * out.picture.columns - high, 14);
    }
    // About the axis: rows are those of two circles, and the line goes straight across.
    const Stretched round = stretched(line, {0, 0, 1}, {0, 0, -1}, {30, 0.25, 1});
    EXPECT_FALSE(round.endOnTop);
    EXPECT_NEAR(0.25 * static_cast<double>(round.picture.rows.size()), 4 * kPi * kHelixRadius, 0.6);
    for (std::size_t y = 20; y < round.picture.rows.size(); y += 50)
        EXPECT_NEAR(round.picture.rows[y].lineMm - round.picture.rows[y - 20].lineMm,
                    5 * kHelixRise / kHelixRadius, 0.03);
}

TEST(ReformedLine, WhatNoPictureHasIsRefused) {
    const FlightCurve line = curveOf(50, [](double mm) { return glm::dvec3(0, 0, mm); });
    const auto message = [](const std::function<void()>& body) {
        try {
            body();
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    using ::testing::HasSubstr;
    EXPECT_THAT(message([&] {
                    (void)stretched(line, {0, 0, 1}, {0, 0, 1}, {30, 1, 1});
                }),
                HasSubstr("--direction: expected one at an angle to the line"));
    EXPECT_THAT(message([&] {
                    (void)stretched(line, {0, 0, 0}, {0, 0, 1}, {30, 1, 1});
                }),
                HasSubstr("--direction"));
    EXPECT_THAT(message([&] { (void)straightened(line, 0, {30, 1e-3, 1}); }), HasSubstr("32768"));
    EXPECT_THAT(message([&] { (void)straightened(line, 0, {1e6, 1, 1}); }), HasSubstr("32768"));
}

TEST(ReformedLine, ADigestTellsLinesApart) {
    const std::string digest = digestOf(twoHelixTurns());
    EXPECT_EQ(digest.size(), 16U);
    EXPECT_EQ(digest, digestOf(twoHelixTurns()));
    EXPECT_NE(digest, digestOf(curveOf(4 * kPi * kHelixSpeed, [](double mm) {
                  return onReformedHelix(mm) + (mm > 100 && mm < 103 ? glm::dvec3(0.1, 0, 0) : glm::dvec3(0));
              })));
    EXPECT_NE(digest, digestOf(curveOf(4 * kPi * kHelixSpeed - 1, onReformedHelix)));
}

} // namespace
} // namespace tessera
