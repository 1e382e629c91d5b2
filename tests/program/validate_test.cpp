// tests/program/validate_test.cpp: `tessera validate` from outside: its lines and its exit codes.
#include "tests/support/program_fixture.h"

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class ValidateProgram : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    void flip(const std::string& name, std::streamoff at) const {
        std::fstream file(folder_ / name, std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(at);
        const int byte = file.get();
        file.seekp(at);
        file.put(static_cast<char>(byte ^ 4));
    }
};

TEST_F(ValidateProgram, TellsOfFaultsByLinesAndExitCode) {
    Outcome outcome = run("validate s.zarr");
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.problems, HasSubstr("s.zarr: nothing is wrong"));
    flip("s.zarr/1/c/0/0/0", 30);
    flip("s.zarr/stats/cell_max/c/0/0/0", 30);
    const std::string damaged = readAll(folder_ / "s.zarr/1/c/0/0/0");
    outcome = run("validate s.zarr");
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 2) << outcome.out;
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("s.zarr/1/c/0/0/0: level 1 chunk (0,0,0): expected checksum"),
                                   HasSubstr("s.zarr/stats/cell_max/c/0/0/0: expected checksum")));
    EXPECT_THAT(outcome.problems, HasSubstr("tessera: s.zarr: 2 faults\n"));
    EXPECT_EQ(readAll(folder_ / "s.zarr/1/c/0/0/0"), damaged);
    outcome = run("validate s.zarr --repair");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("made again"));
    EXPECT_THAT(outcome.problems, HasSubstr("2 faults; all were made again"));
    EXPECT_EQ(run("validate s.zarr --thorough").exitCode, 0);
    flip("s.zarr/0/c/0/0/0", 30);
    outcome = run("validate s.zarr --repair");
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_THAT(outcome.out, HasSubstr("stays: level 0 is made by an import alone"));
}

TEST_F(ValidateProgram, RefusesWhatIsNoStore) {
    expectRefused("validate nothing.zarr", {"nothing.zarr"});
    fs::create_directory(folder_ / "photos");
    expectRefused("validate photos", {"photos", "expected a store of Tessera"});
    expectRefused("validate s.zarr --ram 1000", {"--ram"});
}

TEST_F(ValidateProgram, ADamagedChunkIsDrawnFromACoarserLevelAndTold) {
    const std::string draw = "render s.zarr --size 32x32 --engine native --preset bone-1 --json -o ";
    const Outcome whole = run(draw + "whole.png");
    ASSERT_EQ(whole.exitCode, 0) << whole.problems;
    EXPECT_EQ(whole.out.find("damagedChunks"), std::string::npos);
    EXPECT_EQ(run(draw + "same.png --allow-damaged").exitCode, 0);
    flip("s.zarr/0/c/0/0/0", 30);
    const Outcome outcome = run(draw + "damaged.png -q --explain --allow-damaged");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_TRUE(exists("damaged.png"));
    EXPECT_THAT(outcome.problems,
                AllOf(HasSubstr("tessera: 1 damaged chunk was drawn from a coarser level: "),
                      HasSubstr("s.zarr/0/c/0/0/0: level 0 chunk (0,0,0): expected checksum"),
                      HasSubstr("tessera validate")));
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("\"damagedChunks\""), HasSubstr("\"drawnFromLevel\": 1"),
                                   HasSubstr("level 0 chunk (0,0,0) is damaged and drawn from level 1")));
    const Outcome refused = run(draw + "refused.png");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_THAT(refused.problems,
                AllOf(HasSubstr("level 0 chunk (0,0,0): expected checksum"), HasSubstr("--allow-damaged")));
    EXPECT_FALSE(exists("refused.png"));
    for (int level = 1; level < 6; ++level)
        fs::remove(folder_ / ("s.zarr/" + std::to_string(level) + "/c/0/0/0"));
    EXPECT_EQ(run(draw + "none.png --allow-damaged").exitCode, 2);
}

} // namespace
} // namespace tessera::test
