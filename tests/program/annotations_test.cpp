// tests/program/annotations_test.cpp: figures from outside: every kind of file has the annotations and the
// manifest; what cannot have them is refused.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class AnnotationsOfPictures : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    json draw(const std::string& out, const std::string& options) {
        const Outcome outcome = run(kRender + options + " --json -o " + out);
        EXPECT_EQ(outcome.exitCode, 0) << options << "\n" << outcome.problems;
        return outcome.exitCode == 0 ? json::parse(outcome.out) : json();
    }
    const std::string kRender =
        "render s.zarr --engine native --preset auto --no-check --samples 1 --size 240x180 "
        "--projection parallel ";
    const std::string kAll =
        "--scale-bar --directions all --legend --title Sphere --caption words --error-caption "
        "--dpi 150 ";
};

TEST_F(AnnotationsOfPictures, AreInEveryKindOfFile) {
    const json plain = draw("plain.exr", "");
    EXPECT_FALSE(plain.contains("annotations"));
    for (const std::string ending : {".png", ".tif", ".exr", ".pdf", ".svg"}) {
        const json told = draw("a" + ending, kAll);
        EXPECT_EQ(told["annotations"]["dpi"], 150);
        EXPECT_FALSE(told["annotations"]["fonts"].empty());
        EXPECT_EQ(told["legend"].size(), 1u);
        const double scale = told["scene"]["camera"]["parallelScale"];
        EXPECT_NEAR(told["scaleBar"]["mm"].get<double>() / told["scaleBar"]["pixels"].get<double>(),
                    2 * scale / 180, 1e-9);
        const json kept = json::parse(run("info a" + ending + " --json").out);
        EXPECT_EQ(kept["annotations"], told["annotations"]) << ending;
        EXPECT_EQ(kept["scaleBar"], told["scaleBar"]);
        EXPECT_EQ(kept["notice"], "not for diagnosis");
    }
    EXPECT_EQ(readImage(folder_ / "plain.exr").pixels, readImage(folder_ / "a.exr").pixels)
        << "beside a layer the picture is as it was";
    for (const char* channel : {"annotations.A", "annotations.R"})
        EXPECT_THAT(readAll(folder_ / "a.exr"), HasSubstr(std::string(channel) + '\0'));
    EXPECT_THAT(readAll(folder_ / "a.svg"), HasSubstr(">Sphere</text>"));
    EXPECT_THAT(readAll(folder_ / "a.svg"), HasSubstr("measured error: not<"));
    EXPECT_THAT(readAll(folder_ / "a.pdf"), HasSubstr("/MediaBox [ 0 0 115.2 86.4 ]"));
    EXPECT_THAT(readAll(folder_ / "a.png"), HasSubstr(std::string("pHYs\0\0\x17\x12\0\0\x17\x12\x01", 13)))
        << "5906 pixels a metre";
    EXPECT_THAT(readAll(folder_ / "plain.exr"), Not(HasSubstr("annotations.")));
    draw("b.png", "");
    EXPECT_THAT(readAll(folder_ / "b.png"), Not(HasSubstr("pHYs")));
    EXPECT_THAT(run("info a.pdf").out, HasSubstr("engine native"));
}

TEST_F(AnnotationsOfPictures, ThatHaveNoRoomAreTold) {
    const Outcome outcome = run("render s.zarr --engine native --size 40x30 " + kAll + "--json -o a.png");
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_THAT(outcome.problems, HasSubstr("not in the picture: "));
    EXPECT_FALSE(json::parse(outcome.out)["annotations"]["leftOut"].empty());
}

TEST_F(AnnotationsOfPictures, AreOnFramesOfFilms) {
    ASSERT_EQ(run(kRender + "--turn 90 --frames 2 --scale-bar -o film").exitCode, 0);
    ASSERT_EQ(run(kRender + "--turn 90 --frames 2 -o plain").exitCode, 0);
    for (const std::string frame : {"/frame-000000.png", "/frame-000001.png"}) {
        EXPECT_TRUE(json::parse(readManifest(folder_ / ("film" + frame))).contains("scaleBar"));
        EXPECT_NE(readImage(folder_ / ("film" + frame)).pixels,
                  readImage(folder_ / ("plain" + frame)).pixels);
    }
}

TEST_F(AnnotationsOfPictures, AreRefusedWhereThereIsNothingToSay) {
    expectRefused(kRender + "--label-legend -o a.png", {"--label-legend", "labels"});
    expectRefused(kRender + "--measurements -o a.png", {"--measurements"});
    expectRefused(kRender + "--legend --mode absorption -o a.png", {"--legend"});
    expectRefused(kRender + "-o a.pdf --tiles 64", {"a.pdf", ".png"});
    expectRefused(kRender + "-o a.gif", {"a.gif", ".pdf or .svg"});
    expectRefused(kRender + "-o a.pdf --layers all", {"--layers", ".exr"});
    expectRefused(kRender + "-o film.pdf --turn 90", {"film.pdf", "a folder for frames"});
    expectRefused(kRender + "--directions up -o a.png", {"--directions", "letters"});
    EXPECT_FALSE(exists("a.png"));
    EXPECT_FALSE(exists("a.pdf"));
}

// Volumes have their numbers in the scene, those that do not show as well.
TEST_F(AnnotationsOfPictures, LegendsNumberTheScenesVolumes) {
    write("three.json", R"({"tesseraScene": 1, "volumes": [{"path": "s.zarr", "opacity": 0},
        {"path": "s.zarr"}, {"path": "s.zarr"}]})");
    const Outcome outcome =
        run("render three.json -q --engine native --size 180x160 --legend --json -o three.svg");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    const std::string page = readAll(folder_ / "three.svg");
    EXPECT_THAT(page, HasSubstr(">volume 2"));
    EXPECT_THAT(page, HasSubstr(">volume 3"));
    EXPECT_THAT(page, Not(HasSubstr(">volume 1")));
}

} // namespace
} // namespace tessera::test
