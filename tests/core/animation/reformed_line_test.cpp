// tests/core/animation/reformed_line_test.cpp: reformations of lines whose lengths, curvatures and
// projections are known in closed form.
#include "core/animation/reformed_line.h"

#include "core/base/error.h"
#include "core/scene/reformed_sheet.h"
#include "tests/support/curves.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

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
            EXPECT_LT(std::abs(twist), 0.01) << "radians over all of the line"; // torsion's would be 3.3
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

TEST(ReformedLine, NoPictureIsFromBehind) {
    for (double tilt = 0; tilt < 90; tilt += 4)
        for (double about = 0; about < 360; about += 30)
            for (const double way : {1.0, -1.0}) {
                const double a = glm::radians(tilt), b = glm::radians(about);
                const glm::dvec3 along(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b),
                                       way * std::cos(a));
                const FlightCurve line = curveOf(50, [&](double mm) { return mm * along; });
                const glm::dvec3 viewer = straightened(line, 0, {20, 1, 1}).rows.front().towards;
                if (tilt < 44) {
                    EXPECT_LT(viewer.y, -0.69) << tilt << " " << about << ": in front";
                } else if (tilt > 46) {
                    EXPECT_GT(viewer.z, 0.69) << tilt << " " << about << ": above";
                }
                const Reformation across = crossSection(line, 20, 0, {20, 1, 1});
                EXPECT_GT(glm::dot(across.rows.front().at - across.rows.back().at, viewer), 18);
            }
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

TEST(ReformedLine, CrossSectionsStandOnTheLine) {
    const FlightCurve line = twoHelixTurns();
    const std::vector<double> places = sectionPlaces(line, 7);
    ASSERT_EQ(places.size(), 7U);
    for (std::size_t n = 0; n < places.size(); ++n) {
        EXPECT_NEAR(places[n], line.lengthMm() * (static_cast<double>(n) + 0.5) / 7, 1e-9);
        for (const double degrees : {0.0, 50.0}) {
            const Reformation picture = crossSection(line, places[n], degrees, {20, 0.5, 2});
            expectFrames(picture);
            EXPECT_EQ(picture.size(), glm::ivec2(40, 40));
            EXPECT_TRUE(picture.isSection);
            const glm::dvec3 middle = 0.5 * (picture.rows[39].place(10) + picture.rows[40].place(10));
            EXPECT_LT(glm::distance(middle, line.at(places[n]).at), 1e-9);
            for (const ReformedRow& row : picture.rows) {
                EXPECT_LT(glm::distance(row.towards, line.tangent(places[n])), 2e-3) << "it looks back";
                EXPECT_EQ(row.alongMm, places[n]);
            }
            const glm::dvec3 down = glm::normalize(picture.rows.back().at - picture.rows.front().at);
            EXPECT_LT(glm::distance(glm::cross(picture.rows[0].across, -down), picture.rows[0].towards), 1e-9)
                << "not a mirror image";
            // The row of the straightened picture, whose viewer is on top.
            const Reformation along = straightened(line, degrees, {20, 0.5, 2});
            const auto nearest = std::ranges::min_element(
                along.rows, {}, [&](const ReformedRow& row) { return std::abs(row.alongMm - places[n]); });
            EXPECT_LT(glm::distance(nearest->across, picture.rows[0].across), 0.02);
            EXPECT_LT(glm::distance(nearest->towards, -down), 0.02);
        }
    }
    // Of a line from head to feet it is an axial slice as radiologists see it.
    const FlightCurve down = curveOf(50, [](double mm) { return glm::dvec3(0, 0, -mm); });
    const Reformation axial = crossSection(down, 20, 0, {20, 1, 1});
    EXPECT_LT(glm::distance(axial.rows[0].across, {1, 0, 0}), 1e-9) << "the patient's left at the right";
    EXPECT_LT(glm::distance(axial.rows[0].at - axial.rows[19].at, {0, -19, 0}), 1e-9) << "the front on top";
}

// A line that wavers by a fifth of a mm, as one of a thin branch: its tangent does by 24 degrees, its rows
// hardly.
TEST(ReformedLine, RowsDoNotSwayWithTheNoiseOfALine) {
    const FlightCurve line = curveOf(
        60, [](double mm) { return glm::dvec3(0.2 * std::sin(2.2 * mm), 0, -mm); }, 0.5);
    double worst = 0, swayed = 0;
    for (const ReformedRow& row : straightened(line, 0, {20, 0.5, 1}).rows) {
        worst = std::max(worst, std::acos(std::min(1.0, glm::dot(row.across, glm::dvec3(1, 0, 0)))));
        swayed = std::max(swayed, std::acos(std::min(1.0, -line.tangent(row.alongMm).z)));
    }
    EXPECT_GT(glm::degrees(swayed), 12);
    EXPECT_LT(glm::degrees(worst), glm::degrees(swayed) / 3);
}

TEST(ReformedLine, PicturesLieApartInOneImage) {
    const FlightCurve line = curveOf(100, [](double mm) { return glm::dvec3(0, 0, -mm); });
    const ReformedPixels pixels{24, 1, 1};
    for (const int along : {0, 1, 3})
        for (const int sections : {0, 1, 2, 5, 13}) {
            if (along + sections == 0)
                continue;
            std::vector<Reformation> pictures;
            for (int n = 0; n < along; ++n)
                pictures.push_back(straightened(line, 30.0 * n, pixels));
            for (const double mm : sectionPlaces(line, sections))
                pictures.push_back(crossSection(line, mm, 0, pixels));
            const glm::ivec2 size = layOutPictures(pictures);
            EXPECT_EQ(size, sizeOf(pictures));
            if (along > 0) {
                EXPECT_EQ(size.y, 100) << "sections lie beside the line, as high as it at most";
            }
            for (std::size_t a = 0; a < pictures.size(); ++a) {
                const glm::ivec2 end = pictures[a].from + pictures[a].size();
                EXPECT_TRUE(pictures[a].from.x >= 0 && pictures[a].from.y >= 0 && end.x <= size.x &&
                            end.y <= size.y);
                for (std::size_t b = 0; b < a; ++b) {
                    const glm::ivec2 other = pictures[b].from + pictures[b].size() + kReformedGap;
                    EXPECT_TRUE(pictures[a].from.x >= other.x || pictures[a].from.y >= other.y ||
                                pictures[b].from.x >= end.x + kReformedGap ||
                                pictures[b].from.y >= end.y + kReformedGap)
                        << along << " " << sections << ": " << a << " and " << b;
                }
            }
        }
    std::vector<Reformation> many(200, crossSection(line, 3, 0, {1700, 0.5, 1}));
    EXPECT_THROW(layOutPictures(many), InputError);
}

TEST(ReformedLine, ADigestTellsLinesApart) {
    const std::string digest = digestOf(twoHelixTurns());
    EXPECT_EQ(digest.size(), 16U);
    EXPECT_EQ(digest, digestOf(twoHelixTurns()));
    EXPECT_NE(digest, digestOf(curveOf(4 * kPi * kHelixSpeed, [](double mm) {
                  return onReformedHelix(mm) + (mm > 100 && mm < 103 ? glm::dvec3(0.1, 0, 0) : glm::dvec3(0));
              })));
    EXPECT_NE(digest, digestOf(curveOf(4 * kPi * kHelixSpeed - 1, onReformedHelix)));
    // FNV-1a of 64 bits over places in micrometres, low bytes first, and over the length.
    const FlightCurve straight = curveOf(300.25, [](double mm) { return glm::dvec3(1.5, -mm, 0.25 * mm); });
    std::uint64_t hash = 0xcbf29ce484222325U;
    const auto add = [&](double mm) {
        const auto micrometres = static_cast<std::uint64_t>(std::llround(1000 * mm));
        for (int byte = 0; byte < 8; ++byte)
            hash = (hash ^ (micrometres >> (8 * byte) & 255)) * 0x100000001b3U;
    };
    const int places = static_cast<int>(std::ceil(straight.lengthMm())); // one a millimetre
    for (int n = 0; n <= places; ++n)
        for (int axis = 0; axis < 3; ++axis)
            add(straight.at(straight.lengthMm() * n / places).at[axis]);
    add(straight.lengthMm());
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    EXPECT_EQ(digestOf(straight), text) << "as manifests have it";
}

} // namespace
} // namespace tessera
