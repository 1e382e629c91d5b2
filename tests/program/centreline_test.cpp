// tests/program/centreline_test.cpp: `tessera centreline` and the phantom's curves, from outside: a path that
// others read back, and refusals.
#include "core/animation/path.h"
#include "tests/support/program_fixture.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

TEST_F(Program, CentrelineWritesAPathAlongTheKnownCurve) {
    ASSERT_EQ(run("phantom torso --size 120x90x140 -o t.zarr --curves curves.json -q").exitCode, 0);
    const auto curves = nlohmann::json::parse(readAll(folder_ / "curves.json"));
    EXPECT_EQ(curves["phantom"], "torso");
    EXPECT_EQ(curves["colon"]["polyps"].size(), 10u);
    EXPECT_GT(curves["airways"].size(), 900u);
    EXPECT_FALSE(curves["colon"].contains("collapsed"));

    const Outcome made = run("centreline t.zarr --from=8,-20,73 --to=2,-4,-80 --spacing 2 -o aorta.json");
    ASSERT_EQ(made.exitCode, 0) << made.problems;
    EXPECT_THAT(made.problems, HasSubstr("lumen: above "));
    EXPECT_THAT(made.problems, HasSubstr("wrote aorta.json: a path of 3"));
    const Path path = loadPath(folder_ / "aorta.json");
    ASSERT_EQ(path.lines.size(), 1u);
    EXPECT_LE(path.lines[0].spacingMm, 2);
    ASSERT_TRUE(path.volume);
    EXPECT_EQ(path.volume->extentVoxels, glm::ivec3(120, 90, 140));
    ASSERT_TRUE(path.lumen);
    EXPECT_EQ(path.lumen->side, Lumen::Side::above);

    const Outcome tree = run("centreline t.zarr --from=0,8,180 --tree --generations 2 -o tree.json");
    ASSERT_EQ(tree.exitCode, 0) << tree.problems;
    EXPECT_GT(loadPath(folder_ / "tree.json").lines.size(), 4u);

    // the same path by any number of runs and budgets
    ASSERT_EQ(
        run("centreline t.zarr --from=8,-20,73 --to=2,-4,-80 --spacing 2 --ram 24MiB -o again.json").exitCode,
        0);
    EXPECT_EQ(readAll(folder_ / "again.json"), readAll(folder_ / "aorta.json"));
}

TEST_F(Program, CentrelineRefusesWhatItCannotDo) {
    ASSERT_EQ(run("phantom torso-collapsed --size 120x90x140 -o c.zarr --curves curves.json -q").exitCode, 0);
    EXPECT_TRUE(nlohmann::json::parse(readAll(folder_ / "curves.json"))["colon"].contains("collapsed"));
    const auto refused = [&](const std::string& words, const std::string& why) {
        const Outcome outcome = run("centreline " + words + " -o out.json");
        EXPECT_EQ(outcome.exitCode, 2) << words << "\n" << outcome.problems;
        EXPECT_THAT(outcome.problems, HasSubstr(why)) << words;
        EXPECT_FALSE(fs::exists(folder_ / "out.json"));
    };
    refused("c.zarr --from=-67,-33,-155 --to=0,38,-199", "mm apart");
    refused("c.zarr --from=-67,-33 --to=0,38,-199", "--from: expected a point as x,y,z");
    refused("c.zarr --from=-67,-33,-155 --to=0,38,1e9", "--to: expected a point as x,y,z");
    refused("c.zarr --from=-67,-33,-155 --to=0,38,999", "--to: expected a point in the volume");
    refused("c.zarr --from=-67,-33,-155 --through=0,0,0", "--through: expected --to as well");
    refused("c.zarr --from=-67,-33,-155 --to=0,38,-199 --tree", "--tree: expected --from alone");
    refused("c.zarr --from=-67,-33,-155 --ram 200KiB", "--ram");
    refused("nowhere.zarr --from=-67,-33,-155", "nowhere.zarr");
    const Outcome none = run("phantom sphere --size 8x8x8 -o s.zarr --curves c.json");
    EXPECT_EQ(none.exitCode, 2);
    EXPECT_THAT(none.problems,
                HasSubstr("--curves: expected a torso, which has curves, found phantom sphere"));
    EXPECT_FALSE(fs::exists(folder_ / "s.zarr"));
}

} // namespace
} // namespace tessera::test
