// tests/viewer/paths/path_file_test.cpp: lines of points in files of other programs.
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "viewer/paths/path_file.h"
#include "viewer/paths/point_line.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace tessera {
namespace {

using ::testing::HasSubstr;

/// Files of one test.
class PathFile : public ::testing::Test {
  protected:
    std::filesystem::path file(const std::string& name, const std::string& text) {
        std::ofstream(folder_.path() / name, std::ios::binary) << text;
        return folder_.path() / name;
    }
    std::string refusal(const std::string& name, const std::string& text) {
        try {
            loadPathFile(file(name, text));
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr(name));
            return error.what();
        }
        return "taken";
    }
    ScratchFolder folder_;
};

/// The farthest of points from the line's nearest of its pieces.
double farthest(const std::vector<glm::dvec3>& points, const CentreLine& line) {
    double most = 0;
    for (const glm::dvec3& p : points) {
        double least = 1e300;
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const glm::dvec3 a = line.points[i], d = line.points[i + 1] - a;
            const double t = std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0);
            least = std::min(least, glm::length(p - a - t * d));
        }
        most = std::max(most, least);
    }
    return most;
}

std::string markup(const std::string& type, const std::string& more, const std::string& points) {
    return R"({"@schema": "x", "markups": [{"type": ")" + type + "\", " + more + R"("controlPoints": [)" +
           points + "]}]}";
}

TEST(PointLine, OfAnyPointsIsAPathThroughThem) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> place(-60, 60), step(-1, 1);
    for (int n = 0; n < 60; ++n) {
        PlacedPoints points;
        points.closed = n % 5 == 4;
        glm::dvec3 at(place(random), place(random), place(random));
        for (int k = 0; k < 3 + n % 17; ++k) {
            points.mm.push_back(at);
            points.radiusMm.push_back(2 + k % 3);
            const double far = n % 3 == 0 ? 0.7 : n % 3 == 1 ? 12 : 90;
            at += far * glm::dvec3(step(random), step(random), 1.3 + step(random));
        }
        Path path;
        path.lines.push_back(lineThrough(points, "points"));
        const CentreLine& line = path.lines.front();
        ASSERT_NO_THROW(checkPath(path, "points")) << n;
        EXPECT_LE(line.spacingMm, 1 + 1e-9);
        EXPECT_LT(farthest(points.mm, line), 0.5) << n; // corners are cut by half a millimetre
        EXPECT_NEAR(glm::length(line.points.front() - points.mm.front()), 0, 1e-9);
        EXPECT_NEAR(glm::length(line.points.back() - (points.closed ? points.mm.front() : points.mm.back())),
                    0, 1e-9);
        for (const double radius : line.radiusMm)
            EXPECT_TRUE(radius >= 2 && radius <= 4) << radius;
    }
}

TEST(PointLine, OfTwoPointsIsStraightAndOfACircleRound) {
    const CentreLine straight = lineThrough({{{0, 0, 0}, {0, 0, 0}, {30, 40, 0}}, {}, false}, "two");
    EXPECT_EQ(straight.points.size(), 51U);
    EXPECT_NEAR(straight.lengthMm(), 50, 1e-9);
    for (const glm::dvec3& p : straight.points)
        EXPECT_NEAR(4 * p.x, 3 * p.y, 1e-9);

    PlacedPoints circle;
    circle.closed = true;
    for (int k = 0; k < 24; ++k)
        circle.mm.emplace_back(50 * std::cos(k * std::numbers::pi / 12),
                               50 * std::sin(k * std::numbers::pi / 12), -7);
    const CentreLine round = lineThrough(circle, "circle");
    EXPECT_NEAR(round.lengthMm(), 100 * std::numbers::pi, 0.1);
    for (const glm::dvec3& p : round.points) { // the joint too
        EXPECT_NEAR(std::hypot(p.x, p.y), 50, 0.05);
        EXPECT_NEAR(p.z, -7, 1e-9);
    }
}

TEST(PointLine, OfUnevenPointsHasNoLoops) {
    // Two near points between far ones, where a curve of even parameters would turn back.
    const PlacedPoints points{{{0, 0, 0}, {50, 0, 0}, {50.5, 0.5, 0}, {100, 0, 0}}, {}, false};
    const CentreLine line = lineThrough(points, "uneven");
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
        EXPECT_GT(line.points[i + 1].x, line.points[i].x) << i;
}

TEST(PointLine, OfNoUsePointsIsRefused) {
    const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
    for (const std::vector<glm::dvec3>& mm : {std::vector<glm::dvec3>{},
                                              {{1, 2, 3}},
                                              {{1, 2, 3}, {1, 2, 3}},
                                              {{0, 0, 0}, {0, 0, 2e5}},
                                              {{0, 0, 0}, {0, inf, 0}},
                                              {{0, 0, 0}, {nan, 0, 0}},
                                              {{0, 0, 0}, {-2e7, 0, 0}}})
        EXPECT_THROW(lineThrough({mm, {}, false}, "points"), InputError);
    EXPECT_NO_THROW(lineThrough({{{0, 0, 0}, {0, 0, 9e4}}, {}, false}, "points"));
}

TEST_F(PathFile, SlicersMarkupsAreLinesInTheirCoordinates) {
    const std::string points =
        R"({"position": [1, 2, 3]}, {"position": [4, -2, 9], "positionStatus": "undefined"},
                                  {"position": [21.5, 2, 3], "positionStatus": "defined"})";
    for (const std::string type : {"Curve", "Line", "Fiducial"})
        for (const auto& [said, sign] : {std::pair<std::string, double>{"", 1},
                                         {R"("coordinateSystem": "LPS", )", 1},
                                         {R"("coordinateSystem": "RAS", )", -1},
                                         {R"("coordinateSystem": "0", )", -1},
                                         {R"("coordinateSystem": "1", "coordinateUnits": "mm", )", 1},
                                         {R"("coordinateUnits": ["mm", "UCUM", "millimeter"], )", 1}}) {
            const Path path = loadPathFile(file("c.mrk.json", markup(type, said, points)));
            ASSERT_EQ(path.lines.size(), 1U);
            const CentreLine& line = path.lines.front();
            EXPECT_NEAR(line.lengthMm(), 20.5, 1e-9);
            EXPECT_NEAR(glm::length(line.points.front() - glm::dvec3(sign * 1, sign * 2, 3)), 0, 1e-9);
            EXPECT_NEAR(glm::length(line.points.back() - glm::dvec3(sign * 21.5, sign * 2, 3)), 0, 1e-9);
            EXPECT_FALSE(path.lumen || path.volume || path.flight);
            EXPECT_NO_THROW(checkPath(path, "c"));
        }
    const Path closed = loadPathFile(file("o.mrk.json", markup("ClosedCurve", "", R"({"position": [0, 0, 0]},
        {"position": [9, 0, 0]}, {"position": [9, 9, 0]})")));
    EXPECT_NEAR(glm::length(closed.lines[0].points.front() - closed.lines[0].points.back()), 0, 1e-9);
}

TEST_F(PathFile, MarkupsThatAreNoLinesAreRefusedByWhatIsThere) {
    const std::string two = R"({"position": [1, 2, 3]}, {"position": [4, 5, 6]})";
    EXPECT_THAT(refusal("p.mrk.json", markup("Plane", "", two)), HasSubstr("Plane"));
    EXPECT_THAT(refusal("p.mrk.json", markup("Curve", "", R"({"position": [1, 2, 3]})")),
                HasSubstr("Curve of fewer"));
    EXPECT_THAT(refusal("p.mrk.json", R"({"markups": []})"), HasSubstr("no markup"));
    EXPECT_THAT(refusal("p.mrk.json", markup("Curve", R"("coordinateUnits": "cm", )", two)), HasSubstr("mm"));
    EXPECT_THAT(refusal("p.mrk.json", markup("Curve", R"("coordinateSystem": "IJK", )", two)),
                HasSubstr("coordinateSystem"));
    EXPECT_THAT(refusal("p.mrk.json", markup("Curve", "", R"({"position": [1, 2]}, {"position": [4, 5]})")),
                HasSubstr("position"));
    EXPECT_THAT(refusal("p.mrk.json", markup("Curve", "", R"({"position": [1, "2", 3]})")),
                HasSubstr("controlPoints[0].position[1]"));
}

TEST_F(PathFile, TablesAreLinesWithRadii) {
    const std::string lps = "x,y,z,radius\n1,2,3,4\n1,2,23,8\n";
    const CentreLine line = loadPathFile(file("a.csv", lps)).lines.at(0);
    EXPECT_NEAR(line.lengthMm(), 20, 1e-9);
    EXPECT_NEAR(line.radiusMm.at(10), 6, 1e-9);
    for (const std::string& same :
         {std::string("label;R;A;S;defined;Radius\nF-1;-1;-2;3;1;4\nF-2;7;7;7;0;1\nF-3;-1;-2;23;1;8\n"),
          std::string("\xef\xbb\xbfL,P,S,radius\r\n1.0,2e0,3,4\r\n\r\n\"1\",2,23,8"),
          std::string("radius\tz\ty\tx\n4\t3\t2\t1\n8\t23\t2\t1\n")})
        EXPECT_EQ(loadPathFile(file("b.csv", same)).lines.at(0), line) << same;
    EXPECT_EQ(loadPathFile(file("b.TSV", lps)).lines.at(0), line);
    EXPECT_EQ(loadPathFile(file("c.csv", "x,y,z\n1,2,3\n1,2,23\n")).lines.at(0).radiusMm,
              std::vector<double>(21, 0.0));
}

TEST_F(PathFile, BadTablesNameTheirLine) {
    EXPECT_THAT(refusal("t.csv", "x,y,w\n1,2,3\n1,2,4\n"), HasSubstr("x,y,w"));
    EXPECT_THAT(refusal("t.csv", "x,y,z\n1,2,3\n1,2,4mm\n"), HasSubstr("t.csv:3"));
    EXPECT_THAT(refusal("t.csv", "x,y,z\n1,2,3\n1,2,inf\n"), HasSubstr("inf"));
    EXPECT_THAT(refusal("t.csv", "x;y;z\n1;2;3\n1,5;2;4\n"), HasSubstr("a decimal comma is not read"));
    EXPECT_THAT(refusal("t.csv", "x,y,z\n1,2,3\n1,2,\n"), HasSubstr("\"\""));
    EXPECT_THAT(refusal("t.csv", "x,y,z,radius\n1,2,3,1\n1,2,4,-1\n"), HasSubstr("from 0 on"));
    EXPECT_THAT(refusal("t.csv", "x,y,z\n1,2,3\n"), HasSubstr("at least two"));
    EXPECT_THAT(refusal("t.csv", "x,y,z\n0,0,0\n0,0,200000\n"), HasSubstr("100000 mm"));
}

TEST_F(PathFile, DamagedFilesAreReadOrRefused) {
    const std::string files[] = {
        markup("Curve", R"("coordinateSystem": "RAS", "coordinateUnits": "mm", )",
               R"({"position": [1, 2, 3], "positionStatus": "defined"}, {"position": [4, 5e1, -6.5]})"),
        "label,r,a,s,defined,radius\nF-1,1,2,3,1,4\nF-2,1.5,20,-3,1,8\n"};
    std::mt19937 random(11);
    for (int n = 0; n < 1000; ++n) {
        std::string text = files[n % 2];
        const std::size_t at = random() % text.size();
        switch (random() % 4) {
        case 0:
            text.resize(at);
            break;
        case 1:
            text[at] = static_cast<char>(random());
            break;
        case 2:
            text.insert(at, text.substr(random() % text.size(), random() % 40));
            break;
        default:
            text.erase(at, 1 + random() % 9);
        }
        try {
            checkPath(loadPathFile(file(n % 2 == 0 ? "d.mrk.json" : "d.csv", text)), "d");
        } catch (const InputError&) {
        }
    }
}

TEST_F(PathFile, OurOwnPathsAreReadAsEver) {
    Path path;
    path.lines.push_back(lineThrough({{{0, 0, 0}, {0, 9, 30}}, {1, 2}, false}, "line"));
    EXPECT_EQ(pathJson(loadPathFile(file("p.json", pathJson(path)))), pathJson(path));
}

} // namespace
} // namespace tessera
