// Figures of several panels: what they hold, where it lies, one scale for all, and what is refused.
#include "core/image/image_file.h"
#include "tests/support/program_fixture.h"

#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;

class Panels : public Program {
  protected:
    static constexpr const char* kHow = " -q --engine native --preset auto --no-check --samples 1 ";

    void SetUp() override {
        Program::SetUp();
        ASSERT_EQ(run("phantom torso -q --size 40x40x56 -o s.zarr").exitCode, 0);
    }
    /// The manifest of a figure that is written to f.exr.
    json figure(const std::string& options) {
        const Outcome done = run("render s.zarr --size 48x40 --json -o f.exr" + (kHow + options));
        EXPECT_EQ(done.exitCode, 0) << done.problems;
        return json::parse(done.out);
    }
    static double distanceOf(const json& camera) {
        const auto at = [&](const char* key) {
            return glm::dvec3(camera[key][0], camera[key][1], camera[key][2]);
        };
        return glm::length(at("position") - at("focalPoint"));
    }
};

// A panel is the picture of its own manifest's camera, to the bit, at its place.
TEST_F(Panels, EachIsThePictureOfItsCamera) {
    const json told = figure("--panel anterior,left --panel 30,10 --panel mode=maximum --columns 3 --gap 5");
    ASSERT_EQ(told["panels"].size(), 4u);
    const Image whole = readImage(folder_ / "f.exr");
    EXPECT_EQ(whole.size, glm::ivec2(3 * 48 + 2 * 5, 2 * 40 + 5));
    EXPECT_EQ(json::parse(readManifest(folder_ / "f.exr"))["panels"], told["panels"]);
    for (int n = 0; n < 4; ++n) {
        SCOPED_TRACE(n);
        json scene = told["panels"][static_cast<std::size_t>(n)]["scene"];
        scene["volumes"][0]["path"] = (folder_ / "s.zarr").string();
        write("one.json", scene.dump());
        ASSERT_EQ(run("render one.json -q --engine native --no-check -o one.exr").exitCode, 0);
        const Image one = readImage(folder_ / "one.exr");
        int differ = 0;
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 48; ++x)
                differ += one.at(x, y) != whole.at(n % 3 * 53 + x, n / 3 * 45 + y);
        EXPECT_EQ(differ, 0);
    }
    EXPECT_EQ(told["panels"][3]["mode"], "maximum");
}

// What pictures of one volume show and those of several do not.
TEST_F(Panels, ShowAllThatAPictureOfOneVolumeDoes) {
    for (const char* what : {"--isosurface 200 --mode isosurface", "--crop-voxels 5,30,5,30,5,40",
                             "--integrator linear", "--light cinematic"})
        EXPECT_EQ(
            figure(std::string("--panel anterior,left --set quality.samples=2 ") + what)["panels"].size(), 2u)
            << what;
}

// A word of --set is the option of its name, in a panel too.
TEST_F(Panels, WordsAreTheirOptions) {
    const json told = figure("--slice axial --panel slice=axial:-20 --panel slice=coronal:5 --panel "
                             "preset=bone-1;mode=composite --panel light=studio;mode=composite");
    const auto sceneOf = [&](const std::string& options) {
        const Outcome done =
            run("render s.zarr --size 48x40 --json -q --engine native --no-check --samples 1 -o one.exr " +
                options);
        EXPECT_EQ(done.exitCode, 0) << done.problems;
        return json::parse(done.out)["scene"];
    };
    EXPECT_EQ(told["panels"][0]["scene"]["slice"], sceneOf("--preset auto --slice axial:-20")["slice"]);
    EXPECT_EQ(told["panels"][1]["scene"]["slice"], sceneOf("--preset auto --slice coronal:5")["slice"]);
    EXPECT_EQ(told["panels"][2]["scene"]["volumes"][0]["transferFunction"],
              sceneOf("--preset bone-1")["volumes"][0]["transferFunction"]);
    EXPECT_EQ(told["panels"][3]["scene"]["lighting"], sceneOf("--preset auto --light studio")["lighting"]);
    const std::string refused = run("render s.zarr -o a.png --set preset=Bone").problems;
    EXPECT_NE(refused.find("--set preset: expected one of"), std::string::npos) << refused;
}

// The largest of the scales that the panels would have, in either projection.
TEST_F(Panels, OneScaleIsTheLargestOfAll) {
    for (const char* projection : {"parallel", "perspective"}) {
        SCOPED_TRACE(projection);
        const std::string sides = std::string("--panel superior,anterior,left --projection ") + projection;
        const json own = figure(sides + " --fit-each")["panels"], shared = figure(sides)["panels"];
        const bool parallel = std::string(projection) == "parallel";
        const auto scale = [&](const json& panel) {
            const json& camera = panel["scene"]["camera"];
            return parallel ? camera["parallelScale"].get<double>() : distanceOf(camera);
        };
        double largest = 0, smallest = 1e9;
        for (const json& panel : own) {
            largest = std::max(largest, scale(panel));
            smallest = std::min(smallest, scale(panel));
        }
        EXPECT_LT(smallest, 0.99 * largest); // the torso is no cube
        for (const json& panel : shared)
            EXPECT_NEAR(scale(panel), largest, 1e-9 * largest);
    }
}

// Scenes and volumes beside one another, in one scale; the gap has the background.
TEST_F(Panels, OtherVolumesAndScenes) {
    ASSERT_EQ(run("phantom sphere -q --size 24x24x24 -o b.zarr").exitCode, 0);
    write("b.json", R"({"tesseraScene": 1, "volumes": [{"path": "b.zarr"}], "camera": {"view": "left"}})");
    const std::string places =
        "--panel " + (folder_ / "s.zarr").string() + "," + (folder_ / "b.json").string();
    const json told = figure(places + " --background #ff0000 --gap 3");
    ASSERT_EQ(told["panels"].size(), 2u);
    EXPECT_NE(told["panels"][0]["store"]["contentHash"], told["panels"][1]["store"]["contentHash"]);
    const Image whole = readImage(folder_ / "f.exr");
    for (int y = 0; y < 40; ++y)
        EXPECT_EQ(whole.at(49, y), glm::vec4(1, 0, 0, 1));
}

// Panels have their own letters and words in their corners; words that all of them have stand once, beside
// them.
TEST_F(Panels, WordsAreWhereTheyBelong) {
    const std::string render =
        "render s.zarr --size 200x160 -o f.svg --json --panel left,right,anterior,superior ";
    const auto wordsOf = [&](const std::string& options) {
        const Outcome done = run(render + (kHow + options));
        EXPECT_EQ(done.exitCode, 0) << done.problems;
        const std::string svg = readAll(folder_ / "f.svg");
        std::map<std::string, std::vector<glm::dvec2>> words;
        for (std::size_t at = svg.find("<text "); at != std::string::npos; at = svg.find("<text ", at + 1)) {
            const auto number = [&](const char* key) {
                return std::stod(svg.substr(svg.find(key, at) + std::strlen(key)));
            };
            const std::size_t from = svg.find('>', at) + 1;
            words[svg.substr(from, svg.find('<', from) - from)].emplace_back(number(" x=\""),
                                                                             number(" y=\""));
        }
        return words;
    };
    for (const bool letters : {true, false}) {
        const auto words = wordsOf(letters ? "--panel-letters --title Both --gap 6" : "--title Both --gap 6");
        if (words.empty())
            GTEST_SKIP() << "a program without pages";
        ASSERT_EQ(words.at("Both").size(), 1U);
        const int above = json::parse(readManifest(folder_ / "f.svg"))["figure"]["above"];
        EXPECT_LT(words.at("Both")[0].y, above);
        EXPECT_GT(above, 5);
        for (int n = 0; n < 4; ++n) {
            const std::string letter(1, static_cast<char>('A' + n));
            ASSERT_EQ(words.count(letter), letters ? 1U : 0U) << letter;
            if (!letters)
                continue;
            const glm::dvec2 corner(n % 2 * 206, above + n / 2 * 166), at = words.at(letter)[0] - corner;
            EXPECT_TRUE(at.x > 0 && at.y > 0 && at.x < 25 && at.y < 35) << letter;
        }
    }
    const auto own = wordsOf("--scale-bar --caption Each --panel annotations.caption=Another --gap 6");
    EXPECT_EQ(own.at("Each").size(), 4U);
    EXPECT_EQ(own.at("Another").size(), 1U);
    EXPECT_EQ(json::parse(readManifest(folder_ / "f.svg"))["figure"]["below"], 0);
}

TEST_F(Panels, TheFigureIsPartOfTheBudget) {
    const std::string many = "render s.zarr -o f.png --size 1024x1024 --panel anterior,left,posterior";
    expectRefused(many + kHow + "--ram 64MiB", {"--ram", "the figure"});
}

TEST_F(Panels, WhatCannotBeIsRefused) {
    const std::string render = "render s.zarr -o f.png --size 16x16 ";
    expectRefused(render + "--panel sideways", {"--panel", "sideways", "anterior"});
    expectRefused(render + "--panel anterior, ", {"--panel"});
    expectRefused(render + "--panel image.size=20x20 --panel left", {"--panel", "one size"});
    expectRefused(render + "--panel nothing.here=2", {"nothing"});
    expectRefused(render + "--panel left --view left", {"--panel", "--view"});
    for (const char* option : {"--columns 2", "--gap 3", "--fit-each"})
        expectRefused(render + option, {"--panel"});
    expectRefused(render + "--panel left --tiles 64", {"--panel", "--tiles"});
    expectRefused(render + "--panel left --layers depth", {"--panel", "--layers"});
    expectRefused("render s.zarr -o frames --panel left --turn 90", {"--panel", "film"});
    expectRefused("render s.zarr -o f.png --size 20000x16 --panel left,right", {"--panel", "32768"});
    EXPECT_FALSE(fs::exists(folder_ / "f.png"));
}

} // namespace
} // namespace tessera::test
