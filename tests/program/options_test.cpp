// tests/program/options_test.cpp: values that mean nothing are refused, by every option of every command. The
// table is checked against what each command's help lists, so that no option is forgotten.
#include "tests/support/program_fixture.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <regex>
#include <set>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kNoValues = {"0", "-1", "nan", "inf", "''", "1e400"};

/// A command that would do its work, and its options with those of kNoValues that they may have.
struct Command {
    std::string name, words; // all that it needs besides the option
    std::map<std::string, std::set<std::string>> options;
};

const std::vector<Command>& commands() {
    const std::set<std::string> none, numbers = {"0", "-1"};
    // Words that name a file or a folder: all but the empty one may be a name.
    const std::set<std::string> names = {"0", "-1", "nan", "inf", "1e400"};
    static const std::vector<Command> all = {
        {"import",
         "s.json out.zarr",
         {{"--series", none}, {"--phase", none}, {"--unit", none}, {"--ram", none}}},
        {"info", "s.zarr", {{"--ram", none}}},
        {"phantom", "sphere", {{"--size", none}, {"--output", none}, {"--curves", none}, {"--ram", none}}},
        {"centreline",
         "s.zarr --from 0,0,0 -o out.json",
         {{"--from", none},
          {"--to", none},
          {"--through", none},
          {"--threshold", numbers},
          {"--generations", {"0"}},
          {"--spacing", none},
          {"--output", none}, // none of these ends in .json
          {"--ram", none},
          {"--series", none},
          {"--phase", none}}},
        {"coverage",
         "s.zarr --path path.json",
         {{"--path", none},
          {"--size", none},
          {"--view-angle", none},
          {"--every", none},
          {"--farthest", none},
          {"--smallest", {"0"}},
          {"--output", none}, // none of these ends in .json
          {"--ram", none},
          {"--series", none},
          {"--phase", none}}},
        {"render",
         "s.zarr --engine mirror --size 8x8 -o out.png",
         {{"--output", none}, // none of these ends in .png
          {"--size", none},         {"--preset", none},
          {"--light", none},        {"--view", none},
          {"--fit", none},          {"--projection", none},
          {"--mm-per-pixel", none}, {"--turn", {"-1"}},
          {"--background", none},   {"--engine", none},
          {"--step", none},         {"--max-error", {"0"}}, // the finest levels that show
          {"--first", none},        {"--edge-function", none},
          {"--sampling", none},     {"--isosurface", numbers}, // values of the volume
          {"--integrator", none},   {"--fetch", none},
          {"--samples", none},      {"--pixel-filter", none},
          {"--seed", {"0"}},        {"--verify", none},
          {"--gradient", none},     {"--gpu-memory", none},
          {"--ram", none},          {"--gl-device", {"0"}},
          {"--series", none},       {"--phase", none},
          {"--unit", none},         {"--mode", none},
          {"--window", none},       {"--value-colour", none},
          {"--slice", none},        {"--slab", none},
          {"--crop", none},         {"--crop-voxels", none},
          {"--cut-plane", none},    {"--keep", none},
          {"--path", none},         {"--frames", none},
          {"--fps", none},          {"--speed", none},
          {"--seconds", none},      {"--set", none}}},
        {"view",
         "s.zarr",
         {{"--size", none},
          {"--engine", none},
          {"--frame-ms", none},
          {"--script", none},
          {"--gpu-memory", none},
          {"--ram", none},
          {"--series", none},
          {"--phase", none}}},
        {"preset", "bone", {{"--output", names}, {"--format", none}, {"--range", none}, {"--keep", names}}},
        {"accuracy",
         "s.zarr",
         {{"--output", names},
          {"--only", none},
          {"--scans", names},
          {"--seconds", none},
          {"--integrators", none},
          {"--peers", none},
          {"--keep-scenes", none}, // without --all
          {"--size", none},
          {"--preset", none},
          {"--gpu-memory", none},
          {"--ram", none},
          {"--engine", none},
          {"--gl-device", {"0"}},
          {"--series", none}}},
        {"bench lod",
         "",
         {{"--output", names},
          {"--scans", names},
          {"--volumes", none},
          {"--ram", none},
          {"--engine", none},
          {"--gl-device", {"0"}},
          {"--only", none}}},
        {"bench memory",
         "",
         {{"--output", names},
          {"--scans", names},
          {"--volumes", none},
          {"--ram", none},
          {"--engine", none},
          {"--gl-device", {"0"}}}},
        {"bench picture",
         "",
         {{"--output", names},
          {"--scans", names},
          {"--volumes", none},
          {"--ram", none},
          {"--engine", none},
          {"--gl-device", {"0"}},
          {"--only", none}}},
    };
    return all;
}

TEST_F(Program, ValuesThatMeanNothingAreRefusedByEveryOption) {
    makeSphere();
    write("s.json", "{}");
    for (const Command& command : commands())
        for (const auto& [option, allowed] : command.options)
            for (const std::string& value : kNoValues) {
                if (allowed.count(value))
                    continue;
                // Replaces the option where the command has it already: the parser takes one only.
                std::string words = command.words;
                const std::string shortName = option == "--output" ? "-o" : option;
                if (const std::size_t at = words.find(shortName + " "); at != std::string::npos)
                    words.erase(at, words.find(' ', at + shortName.size() + 1) - at);
                if (option == "--gl-device")
                    words = std::regex_replace(words, std::regex("--engine mirror"), "");
                const bool needsOut = command.name != "render" && command.name != "import" &&
                                      command.name != "info" && command.name != "view" &&
                                      command.name != "centreline" && command.name != "coverage" &&
                                      option != "--output";
                const std::string line =
                    command.name + " " + words + " " + option + "=" + (value == "''" ? "" : value) +
                    (needsOut ? " -o made" + std::string(command.name == "phantom" ? ".zarr" : "") : "");
                const std::string spaced = std::regex_replace(line, std::regex(option + "="),
                                                              option + (value == "''" ? " '' " : " "));
                const auto start = std::chrono::steady_clock::now();
                const Outcome outcome = run(value == "-1" ? line : spaced);
                EXPECT_EQ(outcome.exitCode, 2) << spaced << "\n" << outcome.problems;
                EXPECT_THAT(outcome.problems,
                            ::testing::AnyOf(HasSubstr(option), HasSubstr(": " + value + ": expected")))
                    << spaced;
                EXPECT_EQ(std::count(outcome.problems.begin(), outcome.problems.end(), '\n'), 1)
                    << outcome.problems;
                // Nor after work: a study draws for a minute before it writes.
                EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10)) << spaced;
            }
}

TEST_F(Program, ValuesThatMeanSomethingAreTaken) {
    makeSphere();
    const std::string render = "render s.zarr -q -o a.png --preset auto --engine mirror --size 8x8 ";
    for (const char* taken : {"--max-error 0", "--isosurface 0", "--isosurface=-1", "--step 0.015625"})
        EXPECT_EQ(run(render + taken).exitCode, 0) << taken;
}

// An option and the key that it is short for draw the same picture, and what is wrong is refused alike.
TEST_F(Program, AnOptionIsAKeyOfTheScene) {
    makeSphere();
    const std::string render = "render s.zarr -q --preset auto --engine mirror --size 12x12 --verify none ";
    for (const auto& [option, set] : std::vector<std::pair<std::string, std::string>>{
             {"--background red", "--set image.background=red"},
             {"--background #336699", "--set image.background=\"#336699\""},
             {"--step .5", "--set quality.stepVoxels=.5"},
             {"--edge-function nearest", "--set quality.edgeFunction=nearest"},
             {"--sampling naive", "--set quality.sampling=naive"},
             {"--integrator linear", "--set quality.integrator=linear"},
             {"--samples 4 --seed 7", "--set quality.samples=4 --set quality.seed=7"},
             {"--samples 4 --pixel-filter gaussian", "--samples 4 --set quality.pixelFilter=gaussian"},
             {"--fetch exact", "--set quality.fetch=exact"},
             {"--gradient sobel", "--set shading.gradient=sobel"},
             {"--no-shading", "--set shading.shade=false"},
             {"--no-skipping", "--set quality.skipping=false"},
             {"--mode mip --window 0,3", "--set mode=maximum --set window=[0,3]"},
             {"--view left --fit volume", "--set camera={\"view\":\"left\",\"fit\":\"volume\"}"},
             {"--isosurface 1:red", "--set isosurfaces[0]={\"value\":1,\"rgb\":[1,0,0]}"},
             {"--view right", "--view left --set camera.view=right"}}) {
        ASSERT_EQ(run(render + "-o a.png " + option).exitCode, 0) << option;
        const Outcome other = run(render + "-o b.png " + set);
        ASSERT_EQ(other.exitCode, 0) << set << other.problems;
        EXPECT_EQ(readAll(folder_ / "a.png"), readAll(folder_ / "b.png")) << option << " is not " << set;
    }
    expectRefused(render + "-o a.png --set shading.ambient=2",
                  {"--set shading.ambient: expected a number from 0 to 1, found 2"});
    expectRefused(render + "-o a.png --set shading.ambeint=1",
                  {"--set shading.ambeint", "nearest: \"ambient\""});
    expectRefused(render + "-o a.png --set ambeint=1", {"--set ambeint", "nearest: \"shading.ambient\""});
    expectRefused(render + "-o a.png --set shading", {"--set", "KEY=VALUE"});
    std::string deep = "quality";
    for (int i = 0; i < 30000; ++i)
        deep += ".a";
    expectRefused(render + "-o a.png --set " + deep + "=1",
                  {"--set", "expected a key of scenes, found \"quality.a.a"});
    expectRefused(render + "-o a.png --set mode=" + std::string(50000, '[') + std::string(50000, ']'),
                  {"--set: expected at most 16 nested levels"});
    expectRefused(render + "-o a.png --fetch exakt",
                  {"--fetch: expected one of hardware, exact, found \"exakt\"; nearest: \"exact\""});
}

TEST_F(Program, EmptyArgumentsAreRefused) {
    makeSphere();
    expectRefused("info ''", {"X", "found \"\""});
    expectRefused("import '' a.zarr", {"IN"});
    expectRefused("import s.zarr ''", {"OUT"});
    expectRefused("render s.zarr -o ''", {"--output"});
    expectRefused("render s.zarr -o a.png --isosurface 300:", {"--isosurface"});
}

// An option that is not in the table fails here: it takes a value, so some values mean nothing to it.
TEST_F(Program, TheTableOfOptionsIsWhole) {
    for (const Command& command : commands()) {
        std::istringstream help(run(command.name + " --help").out);
        const std::regex valued("^ +(-[a-z],)?(--[a-z-]+) (?!Excludes:)[A-Z:].*");
        std::smatch found;
        for (std::string line; std::getline(help, line);) {
            const bool isOption = std::regex_match(line, found, valued);
            EXPECT_TRUE(!isOption || command.options.count(found[2].str())) << command.name << ": " << line;
        }
    }
}

} // namespace
} // namespace tessera::test
