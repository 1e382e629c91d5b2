// tests/core/animation/path_test.cpp: paths read strictly and written back without loss, the published
// schema, and routes over branches.
#include "core/animation/path.h"
#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "tests/support/folders.h"

#include <cmath>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

namespace tessera {
namespace {

using nlohmann::json;

/// A trunk along x and a branch that leaves it at 3 mm; all that a path can say.
json whole() {
    json points = json::array(), radius = json::array(), branch = json::array(), narrow = json::array();
    for (int i = 0; i < 6; ++i) {
        points.push_back({i, 0, 0});
        radius.push_back(4);
        branch.push_back({3, 0.5 * i, 0});
        narrow.push_back(2.5);
    }
    return {{"tesseraPath", 1},
            {"volume", {{"contentHash", "abc"}, {"size", {64, 48, 32}}}},
            {"lumen", {{"threshold", -600.5}, {"side", "below"}}},
            {"framesPerSecond", 12.5},
            {"lines",
             {{{"name", "trunk"}, {"count", 6}, {"spacing", 1}, {"points", points}, {"radius", radius}},
              {{"count", 6},
               {"spacing", 0.5},
               {"points", branch},
               {"radius", narrow},
               {"parent", 0},
               {"leavesAt", 3}}}},
            {"keyframes",
             {{{"time", 0.01},
               {"easing", "smooth"},
               {"look", {{"yaw", 20}, {"pitch", -10}, {"offset", {1, 2}}}},
               {"transferFunction", "bone"}},
              {{"place", 2.5},
               {"lighting", {{"finestLevel", 1}}},
               {"cuts", {{"planes", {{{"point", {0, 0, 0}}, {"normal", {0, 1, 0}}}}}}},
               {"transferFunction", {{"scalarOpacity", {{0, 0}, {100, 1}}}}}}}},
            {"flight",
             {{"route", {0, 1}},
              {"backwards", false},
              {"from", 0.5},
              {"to", 5},
              {"speed", 10},
              {"viewAngle", 130},
              {"lookAhead", 4},
              {"clearance", 0.75}}}};
}

Path pathOf(const json& document) {
    return parsePath(document.dump(), "p.json");
}

std::string refusal(const json& document) {
    try {
        pathOf(document);
    } catch (const InputError& e) {
        return e.what();
    }
    return "accepted";
}

TEST(Path, IsReadAndWrittenWithoutLoss) {
    const Path path = pathOf(whole());
    ASSERT_EQ(path.lines.size(), 2U);
    EXPECT_EQ(path.lines[1].parent, 0U);
    EXPECT_EQ(path.lines[1].leavesAtMm, 3);
    EXPECT_EQ(path.lines[1].lengthMm(), 2.5);
    EXPECT_EQ(path.lumen, (Lumen{-600.5, Lumen::Side::below}));
    EXPECT_EQ(path.volume->extentVoxels, glm::ivec3(64, 48, 32));
    EXPECT_EQ(path.keyframes[0].look, (LookAround{20, -10, {1, 2}}));
    EXPECT_EQ(path.keyframes[0].easing, Easing::smooth);
    EXPECT_EQ(path.flight->route, (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(path.framesPerSecond, 12.5);
    const std::string text = pathJson(path);
    EXPECT_EQ(pathJson(parsePath(text, "again")), text);
    EXPECT_EQ(parsePath(text, "again").lines, path.lines);
}

// The reason why a line may lie outside, and its first place: in the file, and in words for whoever is about
// to fly.
TEST(Path, DoubtsAboutTheLumenAreKeptAndSaid) {
    json document = whole();
    EXPECT_EQ(doubtText(*pathOf(document).lumen), "");
    for (const json& more :
         {json{{"leaks", true}}, json{{"leaks", true}, {"leavesAt", 3.5}}, json{{"unsure", true}}}) {
        json doubtful = document;
        doubtful["lumen"].update(more);
        const Path path = pathOf(doubtful);
        EXPECT_EQ(parsePath(pathJson(path), "again").lumen, path.lumen) << more;
        EXPECT_NE(path.lumen, pathOf(document).lumen) << more;
        const std::string words = doubtText(*path.lumen);
        EXPECT_NE(words, "") << more;
        EXPECT_EQ(words.find("at 3.5 mm") != std::string::npos, more.contains("leavesAt")) << words;
    }
    EXPECT_EQ(linesText(pathOf(document).lines), "2 branches of 7.5 mm, 2.5 mm to 4 mm from the wall");
}

/// Errors are refused with their place, the expected value and the one found.
TEST(Path, StrictReading) {
    struct Row {
        const char* pointer;
        json value; // null: the key goes
        std::vector<const char*> says;
    };
    const std::vector<Row> rows = {
        {"/tesseraPath", 2, {"$.tesseraPath", "found 2"}},
        {"/colour", 1, {"$", "a known key", "colour"}},
        {"/flight/sped", 1, {"$.flight", "sped", "nearest: \"speed\""}},
        {"/lines/0/count", 7, {"$.lines[0].points", "7", "a list of 6"}},
        {"/lines/0/count", nullptr, {"$.lines[0]", "count"}},
        {"/lines/0/radius", {1, 2, 3}, {"$.lines[0].radius", "each of 6 points", "found 3"}},
        {"/lines/0/radius/2", -1, {"$.lines[0].radius[2]", "-1"}},
        {"/lines/0/points/2", {2, 0}, {"$.lines[0].points[2]", "[x, y, z]"}},
        {"/lines/0/points/2", {2, "x", 0}, {"$.lines[0].points[2][1]", "number"}},
        {"/lines/0/points/2", {1e9, 0, 0}, {"$.lines[0].points[2][0]", "1000000000"}},
        {"/lines/0/points/2", {2.5, 0, 0}, {"$.lines[0].points[2]", "about 1 mm", "1.5 mm"}},
        {"/lines/0/spacing", 2.5, {"$.lines[0].points[1]", "about 2.5 mm", "found 1 mm"}},
        {"/lines/0/spacing", 0, {"$.lines[0].spacing"}},
        {"/lines/1/parent", 1, {"$.lines[1].parent", "earlier line", "found 1"}},
        {"/lines/1/parent", nullptr, {"$.lines[1]", "\"parent\" and \"leavesAt\""}},
        {"/lines/1/leavesAt", 6, {"$.lines[1].leavesAt", "0 to 5 mm", "found 6"}},
        {"/lines/1/leavesAt", 50000, {"$.lines[1].leavesAt"}},
        {"/flight/route", {0, 0}, {"$.flight.route", "child", "line 0"}},
        {"/flight/route", {2}, {"$.flight.route", "below 2", "found 2"}},
        {"/flight/route", json::array(), {"$.flight.route", "at least one"}},
        {"/flight/to", 7, {"$.flight", "0 to 5.5 mm"}},
        {"/flight/viewAngle", 171, {"$.flight.viewAngle", "170", "171"}},
        {"/flight/speed", 0, {"$.flight.speed"}},
        {"/keyframes/0/time", nullptr, {"$.keyframes[0]", "\"time\" and \"place\"", "neither"}},
        {"/keyframes/0/place", 1, {"$.keyframes[0]", "both"}},
        {"/keyframes/1/place", 0.4, {"$.keyframes[1].place", "0.5 to 5"}},
        {"/keyframes/1/place", 0.5, {"$.keyframes[1]", "after the keyframe before", "found 0 s"}},
        {"/keyframes/0/easing", "slow", {"$.keyframes[0].easing", "through, smooth, linear", "slow"}},
        {"/keyframes/0/camera", {{"position", {0, 0, 0}}, {"focalPoint", {1, 0, 0}}}, {"[0]", "\"look\""}},
        {"/keyframes/1", {{"time", 1}}, {"$.keyframes[1]", "a camera, a look", "none"}},
        {"/flight", nullptr, {"$.keyframes[0]", "\"camera\" where no line is flown"}},
        {"/lumen/side", "inside", {"$.lumen.side", "below", "above"}},
        {"/volume/size", {1, 2}, {"$.volume.size"}},
        {"/framesPerSecond", 0, {"$.framesPerSecond"}},
    };
    for (const Row& row : rows) {
        json document = whole();
        const json::json_pointer at(row.pointer);
        if (row.value.is_null())
            document.at(at.parent_pointer()).erase(at.back());
        else
            document[at] = row.value;
        const std::string text = refusal(document);
        EXPECT_THAT(text, testing::HasSubstr("p.json")) << row.pointer;
        EXPECT_THAT(text, testing::HasSubstr("expected")) << row.pointer;
        for (const char* part : row.says)
            EXPECT_THAT(text, testing::HasSubstr(part)) << row.pointer;
    }
    json one = whole();
    one["lines"] = {{{"count", 1}, {"spacing", 1}, {"points", {{0, 0, 0}}}, {"radius", {1}}}};
    EXPECT_THAT(refusal(one), testing::HasSubstr("at least 2 points, found 1"));
    json away = whole();
    for (json& point : away["lines"][1]["points"])
        point[2] = 5.1;
    EXPECT_THAT(refusal(away), testing::HasSubstr("inside its parent's lumen"));
    EXPECT_THAT(refusal({{"tesseraPath", 1}}), testing::HasSubstr("\"lines\" or \"keyframes\""));
    EXPECT_THROW(parsePath("{\"tesseraPath\": 1, \"lines\": [{\"spacing\": 1e999}]}", "p"), InputError);
    const std::string good = whole().dump();
    for (std::size_t n = 0; n < good.size(); n += 31)
        EXPECT_THROW(parsePath(good.substr(0, n), "p"), InputError);
    EXPECT_THROW(loadPath("/no/such/path.json"), InputError);
    Path bad = pathOf(whole());
    bad.lines[0].points[3].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(checkPath(bad, "p"), InputError);
}

/// What no file can say is refused at its place too.
TEST(Path, SpacingsAndRadiiAreNumbersOfMillimetres) {
    const double infinite = std::numeric_limits<double>::infinity();
    const auto said = [](const std::function<void(Path&)>& change) -> std::string {
        Path path = pathOf(whole());
        change(path);
        try {
            checkPath(path, "p");
        } catch (const InputError& error) {
            return error.what();
        }
        return "no refusal";
    };
    for (const double bad : {0.0, -1.0, infinite, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_THAT(said([&](Path& path) { path.lines[0].spacingMm = bad; }),
                    testing::HasSubstr("$.lines[0].spacing: expected a positive number of mm"));
    for (const double bad : {-0.1, infinite})
        EXPECT_THAT(said([&](Path& path) { path.lines[1].radiusMm[4] = bad; }),
                    testing::HasSubstr("$.lines[1].radius[4]: expected a number of mm from 0 on"));
    EXPECT_EQ(said([](Path& path) { path.lines[0].radiusMm[0] = 0; }), "no refusal");
    // Chords of a half and of all of the spacing are even; shorter and longer ones are not.
    const auto moved = [&](double x) { return said([&](Path& path) { path.lines[0].points[5].x = 4 + x; }); };
    EXPECT_EQ(moved(0.5), "no refusal");
    EXPECT_EQ(moved(1.0009), "no refusal");
    EXPECT_THAT(moved(0.49), testing::HasSubstr("points[5]: expected about 1 mm from the point before"));
    EXPECT_THAT(moved(1.0011), testing::HasSubstr("points[5]"));
}

TEST(Path, RouteTurnsIntoTheBranchWhereItLeaves) {
    const Path path = pathOf(whole());
    const std::vector<RoutePoint> route = routeOf(path.lines, path.flight->route);
    // 0, 1, 2 along x, then the branch from (3, 0, 0) on
    ASSERT_EQ(route.size(), 9U);
    EXPECT_EQ(route[2].at, glm::dvec3(2, 0, 0));
    EXPECT_EQ(route[3].at, glm::dvec3(3, 0, 0));
    EXPECT_EQ(route[3].alongMm, 3);
    EXPECT_EQ(route[3].radiusMm, 2.5);
    EXPECT_EQ(route.back().at, glm::dvec3(3, 2.5, 0));
    EXPECT_EQ(route.back().alongMm, 5.5);
    EXPECT_EQ(routeOf(path.lines, {0}).back().alongMm, 5);
}

} // namespace
} // namespace tessera
