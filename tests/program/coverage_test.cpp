// tests/program/coverage_test.cpp: `tessera coverage` from outside: its sentence, its report, and refusals.
#include "core/animation/path.h"
#include "tests/support/program_fixture.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

TEST_F(Program, CoverageTellsWhatAFlightSees) {
    ASSERT_EQ(run("phantom torso --size 120x90x140 -o t.zarr -q").exitCode, 0);
    ASSERT_EQ(run("centreline t.zarr --from=-67,-33,-155 --to=0,38,-199 -o colon.json -q").exitCode, 0);
    const Outcome there = run("coverage t.zarr --path colon.json --every 5 -o unseen.json");
    ASSERT_EQ(there.exitCode, 0) << there.problems;
    EXPECT_THAT(there.out, HasSubstr("seen: "));
    EXPECT_THAT(there.out, HasSubstr(" cm2 of wall; "));
    EXPECT_THAT(there.problems, HasSubstr("wrote unseen.json"));
    const auto report = nlohmann::json::parse(readAll(folder_ / "unseen.json"));
    const auto both =
        nlohmann::json::parse(run("coverage t.zarr --path colon.json --every 5 --both-ways --json -q").out);
    EXPECT_EQ(report["cameras"].get<int>() * 2, both["cameras"].get<int>());
    EXPECT_EQ(report["wallMm2"], both["wallMm2"]);
    EXPECT_GT(both["share"].get<double>(), report["share"].get<double>());
    EXPECT_EQ(report["viewAngle"], 90);
    const auto ofSize = [&](const std::string& size) {
        return nlohmann::json::parse(
            run("coverage t.zarr --path colon.json --every 5 --json -q --size " + size).out);
    };
    const auto wide = ofSize("640x160"), tall = ofSize("160x640");
    EXPECT_EQ(wide["aspect"], 4);
    EXPECT_EQ(tall["aspect"], 0.25);
    EXPECT_GT(wide["share"].get<double>(), tall["share"].get<double>())
        << "the view's angle is the vertical one";
    ASSERT_FALSE(report["patches"].empty());
    EXPECT_GE(report["patches"].front()["areaMm2"], report["patches"].back()["areaMm2"]);

    EXPECT_EQ(report["lines"], 1);
    EXPECT_EQ(there.out.find("flight.route"), std::string::npos) << "all lines were flown";
    ASSERT_EQ(run("centreline t.zarr --from=0,8,180 --tree --generations 1 -o tree.json -q").exitCode, 0);
    const Outcome ofTree = run("coverage t.zarr --path tree.json --every 20");
    ASSERT_EQ(ofTree.exitCode, 0) << ofTree.problems;
    EXPECT_THAT(
        ofTree.out,
        HasSubstr("along 1 of " + std::to_string(loadPath(folder_ / "tree.json").lines.size()) + " lines"));
    EXPECT_THAT(ofTree.out, HasSubstr("flight.route"));

    const auto refused = [&](const std::string& words, const std::string& why) {
        const Outcome outcome = run("coverage " + words);
        EXPECT_EQ(outcome.exitCode, 2) << words;
        EXPECT_THAT(outcome.problems, HasSubstr(why)) << words;
    };
    ASSERT_EQ(run("phantom torso --size 60x45x70 -o other.zarr -q").exitCode, 0);
    refused("other.zarr --path colon.json", "colon.json: expected a path made in this volume");
    refused("t.zarr --path colon.json -o unseen.txt", "--output");
    Path bare = loadPath(folder_ / "colon.json");
    bare.lumen.reset();
    write("bare.json", pathJson(bare));
    refused("t.zarr --path bare.json", "found no \"lumen\"");
}

} // namespace
} // namespace tessera::test
