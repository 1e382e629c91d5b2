// tests/program/options_test.cpp: values that mean nothing are refused, by every option that a command's help
// lists.
#include "tests/support/folders.h"
#include "tests/support/program_fixture.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <iomanip>
#include <map>
#include <regex>
#include <set>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kNoValues = {"0", "-1", "nan", "inf", "''", "1e400"};

/// A command that would do its work, and what of kNoValues some of its options may have.
struct Command {
    std::string name, words; // all that it needs besides the option
    std::map<std::string, std::set<std::string>> allowed;
};

const std::vector<Command>& commands() {
    const std::set<std::string> zero = {"0"}, numbers = {"0", "-1"};
    // Words that name a file or a folder: all but the empty one may be a name.
    const std::set<std::string> names = {"0", "-1", "nan", "inf", "1e400"};
    static const std::vector<Command> all = {
        {"import", "s.json out.zarr", {{"--file-level", zero}}},
        {"export", "s.zarr out.nrrd --force", {{"--level", zero}}},
        {"info", "s.zarr", {}},
        {"phantom", "sphere", {}},
        {"centreline",
         "s.zarr --from 0,0,0 -o out.json", // nothing of kNoValues ends in .json
         {{"--threshold", numbers}, {"--generations", zero}}},
        {"coverage", "s.zarr --path path.json", {{"--smallest", zero}}},
        {"mesh",
         "s.zarr made.ply --isosurface 100 --force",
         {{"--isosurface", numbers}, {"--level", zero}, {"--simplify", zero}, {"--min-volume", zero}}},
        {"render",
         "s.zarr --engine mirror --size 8x8 -o out.png",
         {{"--turn", {"-1"}},
          {"--max-error", zero},     // the finest levels that show
          {"--isosurface", numbers}, // values of the volume
          {"--seed", zero},
          {"--title", names},
          {"--caption", names},
          {"--gl-device", zero}}},
        {"view", "s.zarr", {}},
        {"validate", "s.zarr", {}},
        {"preset", "bone", {{"--output", names}, {"--keep", names}}},
        {"accuracy", "s.zarr", {{"--output", names}, {"--scans", names}, {"--gl-device", zero}}},
        {"bench lod", "", {{"--output", names}, {"--scans", names}, {"--gl-device", zero}}},
        {"bench memory", "", {{"--output", names}, {"--scans", names}, {"--gl-device", zero}}},
        {"bench picture", "", {{"--output", names}, {"--scans", names}, {"--gl-device", zero}}},
    };
    return all;
}

/// Options with a value, of a command's help.
std::vector<std::string> optionsIn(const std::string& help) {
    const std::regex valued("^ +(-[a-z],)?(--[a-z-]+) (?!Excludes:)[A-Z:].*");
    std::vector<std::string> options;
    std::istringstream lines(help);
    std::smatch found;
    for (std::string line; std::getline(lines, line);)
        if (std::regex_match(line, found, valued))
            options.push_back(found[2].str());
    return options;
}

/// The names of all options of a command's help, short ones left out.
std::vector<std::string> namesIn(const std::string& help) {
    const std::regex named("^ +(?:-[a-z],)?(--[a-z-]+).*");
    std::vector<std::string> names;
    std::istringstream lines(help);
    std::smatch found;
    for (std::string line; std::getline(lines, line);)
        if (std::regex_match(line, found, named) && found[1] != "--help")
            names.push_back(found[1].str());
    return names;
}

/// The first cells of the tables of options in a page's section, one after another.
std::string optionCells(const std::string& page, const std::string& section) {
    const std::size_t begin = page.find("# " + section + "\n");
    EXPECT_NE(begin, std::string::npos) << section;
    std::istringstream lines(page.substr(begin, page.find("\n## ", begin) - begin));
    std::string cells;
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with("| `-"))
            cells += line.substr(0, line.find(" | ")) + " ";
    return cells;
}

TEST_F(Program, TheGuidesTablesHaveEveryOptionOnce) {
    for (const auto& [command, page, section] :
         std::vector<std::array<std::string, 3>>{{"centreline", "hollow-organs.md", "Centreline"},
                                                 {"coverage", "hollow-organs.md", "Coverage"},
                                                 {"mesh", "meshes.md", "Meshes of volumes"},
                                                 {"render", "pictures.md", "Render"},
                                                 {"redraw", "many-figures.md", "Redraw"},
                                                 {"batch", "many-figures.md", "Batch"},
                                                 {"view", "window.md", "The window"}}) {
        std::string cells = optionCells(readAll(sourceFolder() / "docs/guide" / page), section);
        if (command == "render") // options of films have a page of their own
            cells += optionCells(readAll(sourceFolder() / "docs/guide/films.md"), "Films");
        const std::vector<std::string> names = namesIn(run(command + " --help").out);
        EXPECT_GT(names.size(), 7u) << command;
        for (const std::string& name : names) {
            const std::regex alone(name + "(?![a-z-])");
            EXPECT_EQ(std::distance(std::sregex_iterator(cells.begin(), cells.end(), alone), {}), 1)
                << "tessera " << command << " " << name;
        }
    }
}

TEST_F(Program, ValuesThatMeanNothingAreRefusedByEveryOption) {
    makeSphere();
    write("s.json", "{}");
    for (const Command& command : commands()) {
        const std::vector<std::string> options = optionsIn(run(command.name + " --help").out);
        EXPECT_FALSE(options.empty()) << command.name;
        for (const auto& [option, allowed] : command.allowed)
            EXPECT_NE(std::find(options.begin(), options.end(), option), options.end()) << option;
        for (const std::string& option : options)
            for (const std::string& value : kNoValues) {
                const auto allowed = command.allowed.find(option);
                if (allowed != command.allowed.end() && allowed->second.count(value))
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
                                      command.name != "mesh" && command.name != "export" &&
                                      command.name != "validate" && option != "--output";
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
}

/// The number that a range's text has, such as 0.05, 1e6 or 1/64.
double numberOf(const std::string& text) {
    const std::size_t slash = text.find('/');
    return slash == std::string::npos ? std::stod(text)
                                      : std::stod(text.substr(0, slash)) / std::stod(text.substr(slash + 1));
}

std::string words(double number) {
    std::ostringstream text;
    text << std::setprecision(17) << number;
    return text.str();
}

// The ends that a refusal names are taken, and nothing beyond them is. Nothing is done: what commands need
// besides is missing.
TEST_F(Program, RangesOfOptionsAreWhatTheySay) {
    const std::string number = "(-?[0-9][0-9.e+]*(?:/[0-9]+)?)";
    const std::regex range("^tessera: (--[a-z-]+): expected [a-z0-9 ]*from " + number + " to " + number +
                           "[^0-9].*\n");
    std::size_t ranges = 0;
    for (const Command& command : commands()) {
        if (command.name == "accuracy" || command.name.starts_with("bench"))
            continue; // they need nothing besides
        for (const std::string& option : optionsIn(run(command.name + " --help").out)) {
            const auto refusalOf = [&, this](const std::string& value) {
                const std::string said =
                    run(command.name + (command.name == "view" ? " none.zarr " : " ") + option + "=" + value)
                        .problems;
                const bool isOfValue = said.starts_with("tessera: " + option + ": expected") &&
                                       said.find(", found \"" + value + "\"") != std::string::npos;
                return isOfValue ? said : std::string();
            };
            const std::string said = refusalOf("1e300");
            std::smatch found;
            if (!std::regex_match(said, found, range))
                continue;
            ++ranges;
            const std::string about = command.name + " " + option;
            const double low = numberOf(found[2]), high = numberOf(found[3]);
            for (const double taken : {low, high})
                EXPECT_EQ(refusalOf(words(taken)), "") << about;
            // Whole numbers and others.
            for (const double beyond :
                 {low - 1, high + 1, low - 1e-6 * (high - low), high + 1e-6 * (high - low)})
                EXPECT_NE(refusalOf(words(beyond)), "") << about << " " << beyond;
        }
    }
    EXPECT_GT(ranges, 20u);
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
             {"--view right", "--view left --set camera.view=right"},
             {"--set image.size=9x8", "--set image.size=[9,8]"},
             {"--mode mip --window 0,3", "--mode mip --set window=0,3"},
             {"--mode mip --value-colour preset", "--mode mip --set valueColour=transferFunction"},
             {"--unit HU", "--set volumes[0].unit=HU"}}) {
        ASSERT_EQ(run(render + "-o a.png " + option).exitCode, 0) << option;
        const Outcome other = run(render + "-o b.png " + set);
        ASSERT_EQ(other.exitCode, 0) << set << other.problems;
        EXPECT_EQ(readAll(folder_ / "a.png"), readAll(folder_ / "b.png")) << option << " is not " << set;
    }
    const std::string ofAnySize = "render s.zarr -q --preset auto --engine mirror --verify none ";
    EXPECT_EQ(run(ofAnySize + "-o b.png --size 9x8").exitCode, 0);
    EXPECT_EQ(run(render + "-o a.png --set image.size=9x8").exitCode, 0);
    EXPECT_EQ(readAll(folder_ / "a.png"), readAll(folder_ / "b.png"));
    expectRefused(render + "-o a.png --set image.size=9x0",
                  {"--set image.size: expected WIDTHxHEIGHT with numbers from 1 to 32768, found \"9x0\""});
    expectRefused(render + "-o a.png --set quality.samples=many",
                  {"--set quality.samples: expected auto or a whole number from 1 to 65536, found \"many\""});
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
    expectRefused(render + "-o a.png --step 1 --step 2", {"--step: expected once, found 2 times"});
}

// Before a window opens, and so also where none can.
TEST_F(Program, AWindowsKeysAreRefusedAsThoseOfAPicture) {
    makeSphere();
    write("scene.json", R"({"tesseraScene":1,"volumes":[{"path":"s.zarr"}],"isosurfaces":[{"value":1}]})");
    for (const std::string x : {"s.zarr", "scene.json", ""})
        for (const auto& [set, words] : std::vector<std::pair<std::string, std::vector<std::string>>>{
                 {"shading.ambient=2", {"--set shading.ambient: expected a number from 0 to 1, found 2"}},
                 {"shading.ambeint=1", {"--set shading.ambeint", "nearest: \"ambient\""}},
                 {"ambeint=1", {"--set ambeint", "nearest: \"shading.ambient\""}},
                 {"mode", {"--set", "KEY=VALUE"}},
                 {"mode=maxmum", {"--set mode", "nearest: \"maximum\""}}}) {
            expectRefused("view " + x + " --set mode=maximum --set " + set, words);
            if (!x.empty())
                expectRefused("render " + x + " -o a.png --set " + set, words);
        }
    // What a scene has decides what may follow it.
    expectRefused("view s.zarr --set isosurfaces[1].value=2", {"expected an item from 0 to 0, found [1]"});
    expectRefused("view scene.json --set isosurfaces[2].value=2",
                  {"expected an item from 0 to 1, found [2]"});
}

TEST_F(Program, EmptyArgumentsAreRefused) {
    makeSphere();
    expectRefused("info ''", {"X", "found \"\""});
    expectRefused("import '' a.zarr", {"IN"});
    expectRefused("import s.zarr ''", {"OUT"});
    expectRefused("render s.zarr -o ''", {"--output"});
    expectRefused("render s.zarr -o a.png --isosurface 300:", {"--isosurface"});
}

} // namespace
} // namespace tessera::test
