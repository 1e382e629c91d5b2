// tests/program/annotations_test.cpp: figures from outside: every kind of file has the annotations and the
// manifest; what cannot have them is refused.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
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

/// The picture within a page, from its manifest on.
Image pictureOn(const Image& page, const json& annotations, const glm::ivec2& size) {
    const glm::ivec2 at(annotations["pictureAt"][0], annotations["pictureAt"][1]);
    EXPECT_EQ(json({page.size.x, page.size.y}), annotations["pageSize"]);
    Image picture(size);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            picture.at(x, y) = page.at(at.x + x, at.y + y);
    return picture;
}

// Beside the picture: its pixels are those without annotations, in every kind of file and however it is
// drawn.
TEST_F(AnnotationsOfPictures, StandBesideThePicture) {
    const glm::ivec2 size(240, 180);
    const std::string beside = kAll + "--margin all --margin-colour white ";
    for (const std::string more : {"", "--background transparent ", "--tiles 64 "})
        for (const std::string ending : {".png", ".tif", ".exr"}) {
            draw("plain" + ending, more);
            const json told = draw("a" + ending, more + beside);
            EXPECT_FALSE(told["annotations"].contains("leftOut")) << told["annotations"];
            const Image page = readImage(folder_ / ("a" + ending));
            EXPECT_EQ(pictureOn(page, told["annotations"], size).pixels,
                      readImage(folder_ / ("plain" + ending)).pixels)
                << more << ending;
            EXPECT_EQ(page.at(0, 0), glm::vec4(1)) << "the strips are white";
            EXPECT_EQ(told["scene"]["image"]["size"], json({240, 180}));
            const Outcome again = run("redraw a" + ending);
            EXPECT_EQ(again.exitCode, 0) << again.problems;
            EXPECT_THAT(again.out, HasSubstr("equal ("));
        }
    const json told = draw("a.png", beside);
    const double width = told["annotations"]["pageSize"][0], height = told["annotations"]["pageSize"][1];
    for (const std::string ending : {".pdf", ".svg"}) {
        EXPECT_EQ(draw("a" + ending, beside)["annotations"], told["annotations"]) << ending;
        EXPECT_EQ(run("redraw a" + ending).exitCode, 0) << ending;
    }
    std::ostringstream box;
    box << "/MediaBox [ 0 0 " << width * 72 / 150 << " " << height * 72 / 150 << " ]";
    EXPECT_THAT(readAll(folder_ / "a.pdf"), HasSubstr(box.str()));
    // Legends alone: a strip at the right.
    const json legends = draw("a.png", "--legend --scale-bar --margin legends");
    EXPECT_EQ(legends["annotations"]["pictureAt"], json({0, 0}));
    EXPECT_EQ(legends["annotations"]["pageSize"][1], 180);
    EXPECT_GT(legends["annotations"]["pageSize"][0], 240);
    draw("bar.png", "--scale-bar");
    EXPECT_EQ(pictureOn(readImage(folder_ / "a.png"), legends["annotations"], size).pixels,
              readImage(folder_ / "bar.png").pixels);
    // Nothing stands beside a picture that says nothing.
    draw("a.png", "--margin all");
    draw("plain.png", "");
    EXPECT_EQ(readImage(folder_ / "a.png").pixels, readImage(folder_ / "plain.png").pixels);
    expectRefused(kRender + "--margin left -o b.png", {"--margin", "legends"});
    expectRefused(kRender + "--margin-colour transparent -o b.png", {"--margin-colour", "background"});
    expectRefused(
        "render s.zarr --engine native --samples 1 --tiles 64 --size 32768x20 --title x --margin all "
        "--directions all -o b.png",
        {"--margin", "32768"});
}

// Frames of a film have one size; panels have strips of one width.
TEST_F(AnnotationsOfPictures, StandBesideFramesAndPanels) {
    const glm::ivec2 size(240, 180);
    const std::string words = "--scale-bar --directions letters --legend --title A_title --margin all ";
    ASSERT_EQ(run(kRender + "--turn 90 --frames 3 -o film " + words).exitCode, 0);
    ASSERT_EQ(run(kRender + "--turn 90 --frames 3 -o plain").exitCode, 0);
    for (const std::string frame : {"/frame-000000.png", "/frame-000001.png", "/frame-000002.png"}) {
        const json told = json::parse(readManifest(folder_ / ("film" + frame)));
        EXPECT_EQ(pictureOn(readImage(folder_ / ("film" + frame)), told["annotations"], size).pixels,
                  readImage(folder_ / ("plain" + frame)).pixels);
        EXPECT_EQ(run("redraw film" + frame + " --data s.zarr").exitCode, 0);
    }
    const std::string panels = "--panel left --panel camera.view=anterior;annotations.labelLegend=false "
                               "--panel superior --columns 2 --gap 10 ";
    draw("plain.png", panels);
    const json figure = draw("a.png", panels + words + "--caption Each --panel-letters ")["figure"];
    const Image page = readImage(folder_ / "a.png"), plain = readImage(folder_ / "plain.png");
    const json& strips = figure["strips"];
    const glm::ivec2 cell = size + glm::ivec2(strips[0].get<int>() + strips[1].get<int>(),
                                              strips[2].get<int>() + strips[3].get<int>());
    for (int n = 0; n < 3; ++n) {
        const glm::ivec2 at(n % 2, n / 2);
        const glm::ivec2 from =
            at * (cell + 10) + glm::ivec2(strips[0], strips[2]) + glm::ivec2(0, figure["above"].get<int>());
        const glm::ivec2 before = at * (size + 10);
        std::size_t others = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                others += page.at(from.x + x, from.y + y) != plain.at(before.x + x, before.y + y) ? 1 : 0;
        EXPECT_EQ(others, 0u) << "panel " << n;
    }
    const Outcome again = run("redraw a.png");
    EXPECT_EQ(again.exitCode, 0) << again.problems;
    const Outcome other = run("redraw a.png -o b.png --with annotations.margin=none");
    EXPECT_EQ(other.exitCode, 0) << other.problems;
    draw("over.png", panels + "--scale-bar --directions letters --legend --title A_title --caption Each "
                              "--panel-letters ");
    EXPECT_EQ(readImage(folder_ / "b.png").pixels, readImage(folder_ / "over.png").pixels);
    // As keys of a scene, in a table.
    write("style.json", R"({"tesseraScene": 1, "volumes": [{"path": "s.zarr"}], "image": {"size": [240, 180]},
        "annotations": {"legend": true, "title": "{id}", "margin": "all", "marginColour": "#ffffff"}})");
    write("t.csv", "id,annotations.margin\na,\nb,legends\nc,none\n");
    const Outcome batch = run("batch t.csv --scene style.json -o {id}-row.png --no-check");
    ASSERT_EQ(batch.exitCode, 0) << batch.problems;
    EXPECT_EQ(readImage(folder_ / "c-row.png").size, size);
    EXPECT_EQ(readImage(folder_ / "b-row.png").size.y, size.y);
    EXPECT_GT(readImage(folder_ / "b-row.png").size.x, size.x);
    EXPECT_GT(readImage(folder_ / "a-row.png").size.y, size.y);
    EXPECT_THAT(run("batch t.csv --scene style.json -o {id}-row.png --no-check").out,
                HasSubstr("3 unchanged"));
}

// Layers of an .exr lie as its picture does.
TEST_F(AnnotationsOfPictures, LayersHaveTheStripsOfTheirPicture) {
    const std::string layers = "--light cinematic --samples 2 --layers depth,albedo --size 60x50 ";
    const Outcome outcome = run("render s.zarr --engine native --preset auto --no-check " + layers +
                                "--title A --margin all --json -o a.exr");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    const json told = json::parse(outcome.out);
    EXPECT_EQ(run("render s.zarr --engine native --preset auto --no-check -o b.exr " + layers).exitCode, 0);
    const Image page = readImage(folder_ / "a.exr"), plain = readImage(folder_ / "b.exr");
    EXPECT_EQ(pictureOn(page, told["annotations"], plain.size).pixels, plain.pixels);
    EXPECT_THAT(readAll(folder_ / "a.exr"), HasSubstr(std::string("depth.Z") + '\0'));
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
