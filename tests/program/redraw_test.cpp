// tests/program/redraw_test.cpp: a picture is drawn again from its own manifest, to the bit; what differs is
// named.
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h"

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Redraw : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    void draw(const std::string& picture, const std::string& options = "") {
        const Outcome outcome =
            run("render s.zarr -q --preset auto --size 40x32 -o " + picture + " " + options);
        ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    }
    bool samePixels(const std::string& a, const std::string& b) const {
        const Image one = readImage(folder_ / a), other = readImage(folder_ / b);
        return one.size == other.size && one.pixels == other.pixels;
    }
    json manifestOf(const std::string& picture) const { return json::parse(readManifest(folder_ / picture)); }
    /// The same pixels with another manifest.
    void rewrite(const std::string& picture, const std::function<void(json&, Image&)>& change) {
        json manifest = manifestOf(picture);
        Image image = readImage(folder_ / picture);
        change(manifest, image);
        writeImage(folder_ / picture, image, manifest.dump());
    }
};

TEST_F(Redraw, IsEqualToTheBitInEveryFormat) {
    for (const char* ending : {".png", ".tif", ".exr"}) {
        const std::string picture = std::string("a") + ending, again = std::string("b") + ending;
        draw(picture);
        const Outcome outcome = run("redraw " + picture + " -o " + again);
        ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
        for (const char* line :
             {"data:     the same (volume 1, beside the picture; content ", "program:  the same (tessera ",
              "device:   the same (", "settings: the same\n", "pixels:   equal (40 x 32)\n"})
            EXPECT_THAT(outcome.out, HasSubstr(line)) << ending;
        EXPECT_TRUE(samePixels(picture, again)) << ending;
        json before = manifestOf(picture), now = manifestOf(again);
        EXPECT_EQ(before["scene"], now["scene"]);
        EXPECT_EQ(before["resident"], now["resident"]);
    }
}

// A figure of panels, of two scans as well: all of it, and what is changed in all of them.
TEST_F(Redraw, FiguresOfPanelsToo) {
    ASSERT_EQ(run("phantom ramp -q --size 20x20x20 -o other.zarr").exitCode, 0);
    draw("a.png", "--panel left,other.zarr --panel-letters --title Both --caption Words --scale-bar "
                  "--ram 200MiB --gap 3 --engine native");
    const Outcome outcome = run("redraw a.png");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("settings: the same\npixels:   equal (83 x"));
    fs::rename(folder_ / "other.zarr", folder_ / "elsewhere");
    fs::create_directory(folder_ / "away");
    fs::rename(folder_ / "elsewhere", folder_ / "away" / "x.zarr");
    EXPECT_EQ(run("redraw a.png").exitCode, 2) << "one of the scans is away";
    const Outcome named = run("redraw a.png --data away/x.zarr");
    ASSERT_EQ(named.exitCode, 0) << named.problems;
    EXPECT_THAT(named.out, HasSubstr("pixels:   equal"));
    const Outcome changed = run("redraw a.png -q --data away/x.zarr --with shading.ambient=0.4 -o b.png");
    ASSERT_EQ(changed.exitCode, 0) << changed.problems;
    EXPECT_THAT(changed.out, HasSubstr("panel 1, shading.ambient: "));
    EXPECT_THAT(changed.out, HasSubstr("panel 2, shading.ambient: "));
    EXPECT_THAT(run("info b.png").out, HasSubstr("panels:        2"));
    rewrite("a.png", [](json& manifest, Image&) { manifest["figure"]["columns"] = -1; });
    expectRefused("redraw a.png --data away/x.zarr", {"a.png", "figure"});
    rewrite("a.png", [](json& manifest, Image&) { manifest["panels"] = json::array(); });
    expectRefused("redraw a.png", {"a.png", "panels"});
}

// Whatever it was drawn with.
TEST_F(Redraw, IsEqualForAnyOptions) {
    for (const char* options :
         {"--samples 4 --verify none", "--view left --fit volume --engine mirror --no-check",
          "--mode maximum --value-colour transferFunction", "--slice axial --slab 5",
          "--light studio --samples 1", "--isosurface 300:ivory:0.5 --cut-plane 0,0,0,1,0,0",
          "--background transparent", "--tiles 64 --samples 2", "--ram 200MiB --gpu-memory 64MiB --step 1",
          "--max-error 0", "--projection parallel --mm-per-pixel 1.5 --scale-bar",
          "--light cinematic --samples 4 --seed 3", "--gl-device software --engine gpu --samples 1"}) {
        draw("a.png", options);
        const Outcome outcome = run("redraw a.png --json -q");
        ASSERT_EQ(outcome.exitCode, 0) << options << "\n" << outcome.problems;
        const json report = json::parse(outcome.out);
        EXPECT_EQ(report["pixels"]["equal"], true) << options << "\n" << outcome.out;
        EXPECT_EQ(report["settings"], json::array()) << options;
        EXPECT_EQ(report["device"], json::array()) << options;
    }
}

TEST_F(Redraw, LayersAreDrawnAgain) {
    draw("a.exr", "--light cinematic --samples 4 --layers all");
    ASSERT_EQ(run("redraw a.exr -o b.exr").exitCode, 0);
    EXPECT_EQ(manifestOf("a.exr")["layers"], manifestOf("b.exr")["layers"]);
    EXPECT_TRUE(samePixels("a.exr", "b.exr"));
}

TEST_F(Redraw, NothingIsKeptWithoutAnOutput) {
    draw("a.png");
    const std::string before = readAll(folder_ / "a.png");
    const auto count = [&] { return std::distance(fs::directory_iterator(folder_.path()), {}); };
    run("redraw a.png"); // makes the files of its messages
    const auto files = count();
    EXPECT_EQ(run("redraw a.png").exitCode, 0);
    EXPECT_EQ(count(), files);
    EXPECT_EQ(readAll(folder_ / "a.png"), before);
    expectRefused("redraw a.png -o a.png", {"-o", "another file"});
}

TEST_F(Redraw, NamesWhatDiffers) {
    draw("a.png");
    rewrite("a.png", [](json& manifest, Image&) {
        manifest["program"] = "tessera 0.0.1";
        manifest["commit"] = "0123456789ab";
        manifest["scene"]["shading"]["ambient"] = 0.75;
    });
    const Outcome outcome = run("redraw a.png -o b.png --with shading.diffuse=0.5 --ram 300MiB");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("program:  program: tessera 0.0.1, now tessera "));
    EXPECT_THAT(outcome.out, HasSubstr("program:  commit: 0123456789ab, now "));
    EXPECT_THAT(outcome.out, HasSubstr("settings: shading.diffuse: 0.8, now 0.5\n"));
    EXPECT_THAT(outcome.out, HasSubstr("settings: --ram: "));
    EXPECT_THAT(outcome.out, Not(HasSubstr("shading.ambient"))) << "it is as the manifest has it";
    EXPECT_THAT(outcome.out, HasSubstr(" of 1280 differ, rms 0."));
    EXPECT_EQ(manifestOf("b.png")["scene"]["shading"]["ambient"], 0.75);
}

TEST_F(Redraw, NamesAnotherEngineAndMeasurement) {
    draw("a.png", "--samples 1 --verify none");
    const Outcome outcome = run("redraw a.png --engine mirror");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("device:   engine: native, now mirror\n"));
    rewrite("a.png", [](json& manifest, Image&) {
        manifest.erase("options"); // as an older program wrote it
        manifest.erase("data");
        manifest.erase("commit");
    });
    const Outcome older = run("redraw a.png");
    EXPECT_EQ(older.exitCode, 0) << older.problems;
    EXPECT_THAT(older.out, HasSubstr("settings: the same\n"));
    EXPECT_THAT(older.out, HasSubstr("data:     the same (volume 1"));
    EXPECT_THAT(older.out, HasSubstr("pixels:   equal"));
}

// A difference that nothing explains is a failure.
TEST_F(Redraw, FailsWherePixelsDifferThoughNothingElseDoes) {
    draw("a.png");
    rewrite("a.png", [](json&, Image& image) { image.at(3, 4) = glm::vec4(1, 0, 1, 1); });
    const Outcome outcome = run("redraw a.png");
    EXPECT_EQ(outcome.exitCode, 1);
    EXPECT_THAT(outcome.out, HasSubstr("pixels:   1 of 1280 differ"));
    EXPECT_THAT(outcome.problems, HasSubstr("a.png: its pixels differ, though nothing that is known does"));
}

TEST_F(Redraw, DataAreFoundByTheirContent) {
    draw("a.png");
    const json store = manifestOf("a.png")["store"];
    const std::string hash = store["contentHash"];
    fs::create_directory(folder_ / "away");
    fs::rename(folder_ / "s.zarr", folder_ / "away" / "t.zarr");
    expectRefused("redraw a.png",
                  {"a.png", "volume 1", hash, "40 x 33 x 24 voxels", store["type"], "--data"});
    EXPECT_THAT(run("redraw a.png --data away/t.zarr").out,
                HasSubstr("data:     the same (volume 1, --data; content " + hash + ")"));
    ASSERT_EQ(run("phantom sphere --size 40x33x25 -o other.zarr").exitCode, 0);
    expectRefused("redraw a.png", {hash}); // what lies beside it is something else
    const Outcome other = run("redraw a.png --data other.zarr");
    EXPECT_EQ(other.exitCode, 0) << other.problems;
    EXPECT_THAT(other.out, HasSubstr("data:     volume 1, --data: content " + hash + ", now "));
    expectRefused("redraw a.png --data other.zarr --data away/t.zarr", {"--data", "one more"});
    expectRefused("redraw a.png --data missing.zarr", {"missing.zarr", "volume 1", "nothing there"});
    ASSERT_EQ(run("phantom sphere --size 40x33x24 -o here.zarr").exitCode, 0); // the same voxels
    EXPECT_THAT(run("redraw a.png").out,
                HasSubstr("the same (volume 1, beside the picture; content " + hash));
}

TEST_F(Redraw, WithChangesOneThing) {
    draw("a.png");
    draw("left.png", "--view left");
    ASSERT_EQ(run("redraw a.png -o b.png --with camera.view=left -q").exitCode, 0);
    EXPECT_TRUE(samePixels("b.png", "left.png"));
    draw("slice.png", "--mode maximum --window 100,400");
    ASSERT_EQ(run("redraw slice.png -o c.png --with window=[50,300] --with image.size=20x16 -q").exitCode, 0);
    EXPECT_EQ(manifestOf("c.png")["scene"]["window"], json({50, 300}));
    EXPECT_EQ(manifestOf("c.png")["scene"]["image"]["size"], json({20, 16}));
    EXPECT_THAT(run("redraw slice.png --with image.size=20x16").out,
                HasSubstr("not compared: their sizes differ, 40 x 32 and 20 x 16"));
    expectRefused("redraw a.png --with shading.ambiet=0.5", {"--with", "shading.ambient"});
    expectRefused("redraw a.png --with shading.ambient=7", {"--with shading.ambient", "7"});
    expectRefused("redraw a.png --with shading.ambient", {"--with", "KEY=VALUE"});
    expectRefused("redraw a.png --with volumes[0].path=other.zarr", {"--with", "--data"});
}

// A slice's camera is of its plane: another plane has its own.
TEST_F(Redraw, WithAnotherSliceIsThatSlice) {
    draw("axial.png", "--slice axial:10");
    for (const std::string slice :
         {"axial:-20", "coronal:10", "sagittal:5", "oblique:0,0,0,0,0.7,0.7", "oblique:1,2,3,1,2,2"}) {
        draw("asked.png", "--slice " + slice);
        ASSERT_EQ(run("redraw axial.png -q -o b.png --with slice=" + slice).exitCode, 0) << slice;
        EXPECT_TRUE(samePixels("b.png", "asked.png")) << slice;
    }
    // A camera that looks along the normal stays, with its scale.
    ASSERT_EQ(run("redraw axial.png -q -o near.png --with camera.parallelScale=150").exitCode, 0);
    ASSERT_EQ(run("redraw near.png -q -o b.png --with slice=axial:-20").exitCode, 0);
    EXPECT_EQ(manifestOf("b.png")["scene"]["camera"]["parallelScale"], 150);
    EXPECT_FALSE(samePixels("b.png", "near.png"));
}

// Another projection shows the same at the focal point, with or without a scale of its own.
TEST_F(Redraw, WithAnotherProjectionHasTheSameSize) {
    draw("a.png");
    const auto cameraOf = [&](const std::string& picture) { return manifestOf(picture)["scene"]["camera"]; };
    const json before = cameraOf("a.png");
    double far = 0;
    for (int axis = 0; axis < 3; ++axis)
        far += std::pow(before["position"][axis].get<double>() - before["focalPoint"][axis].get<double>(), 2);
    const double half = std::sqrt(far) * std::tan(before["viewAngle"].get<double>() * std::acos(-1.0) / 360);
    ASSERT_EQ(run("redraw a.png -q -o b.png --with camera.parallelProjection=true").exitCode, 0);
    EXPECT_NEAR(cameraOf("b.png")["parallelScale"].get<double>(), half, 1e-9 * half);
    ASSERT_EQ(run("redraw b.png -q -o c.png --with camera.parallelProjection=false").exitCode, 0);
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(cameraOf("c.png")["position"][axis].get<double>(), before["position"][axis].get<double>(),
                    1e-6);
    ASSERT_EQ(run("redraw a.png -q -o d.png --with camera.parallelProjection=true "
                  "--with camera.parallelScale=50")
                  .exitCode,
              0);
    EXPECT_EQ(cameraOf("d.png")["parallelScale"], 50);
    ASSERT_EQ(run("redraw b.png -q -o e.png --with camera.parallelProjection=true").exitCode, 0);
    EXPECT_TRUE(samePixels("b.png", "e.png"));
    json scene = manifestOf("a.png")["scene"]; // the same by --projection
    scene["volumes"][0]["path"] = "s.zarr";
    write("free.json", scene.dump());
    ASSERT_EQ(run("render free.json -q -o f.png --projection parallel").exitCode, 0);
    EXPECT_TRUE(samePixels("b.png", "f.png"));
}

// Texts are words, or JSON.
TEST_F(Redraw, WithTextsAsSetTakesThem) {
    draw("a.png", "--title old --caption of");
    draw("new.png", "--set annotations.title=\"new\" --set annotations.caption=");
    for (const std::string title : {"annotations.title=\"new\"", "annotations.title=new"})
        for (const std::string caption : {"annotations.caption=", "annotations.caption=\"\""}) {
            ASSERT_EQ(run("redraw a.png -q -o b.png --with " + title + " --with " + caption).exitCode, 0);
            EXPECT_TRUE(samePixels("b.png", "new.png")) << title << caption;
            EXPECT_EQ(manifestOf("b.png")["scene"]["annotations"]["title"], "new");
        }
}

TEST_F(Redraw, RefusesWhatHasNoManifest) {
    writeImage(folder_ / "bare.png", Image(glm::ivec2(4, 4)), "");
    expectRefused("redraw bare.png", {"bare.png", "without its manifest"});
    writeImage(folder_ / "words.png", Image(glm::ivec2(4, 4)), "a holiday");
    expectRefused("redraw words.png", {"words.png"});
    writeImage(folder_ / "other.png", Image(glm::ivec2(4, 4)), "{\"by\":\"another\"}");
    expectRefused("redraw other.png", {"other.png", "another description"});
    writeImage(folder_ / "next.png", Image(glm::ivec2(4, 4)), "{\"tesseraManifest\":2}");
    expectRefused("redraw next.png", {"next.png", "version 1"});
    expectRefused("redraw missing.png", {"missing.png"});
    // Hostile manifests are refused or drawn, and read no file that they name.
    draw("a.png");
    const std::string whole = manifestOf("a.png").dump();
    for (const char* key : {"scene", "store", "budgets", "options", "engine", "layers", "tiles", "data"})
        for (const char* value : {"7", "\"x\"", "[[]]", "{\"x\":[]}", "null"}) {
            json manifest = json::parse(whole);
            manifest[key] = json::parse(value);
            writeImage(folder_ / "h.png", Image(glm::ivec2(4, 4)), manifest.dump());
            const int code = run("redraw h.png -q").exitCode;
            EXPECT_TRUE(code == 0 || code == 1 || code == 2) << key << " " << value << ": " << code;
        }
}

#if TESSERA_WITH_IMPORT
// Neither is named by its path, which may name a patient.
TEST_F(Redraw, MeshesAndSourcesAreFoundByTheirContent) {
    std::string voxels;
    for (int n = 0; n < 12 * 10 * 8; ++n)
        voxels += static_cast<char>(n % 200);
    write("doe.raw", voxels);
    write("doe.json", R"({"data":"doe.raw","extent":[12,10,8],"type":"uint8","spacing":[1,1,1]})");
    const std::string mesh = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                             "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                             "end_header\n0 0 0\n8 0 0\n0 8 6\n3 0 1 2\n";
    write("jane.ply", mesh);
    fs::create_directory(folder_ / "p");
    ASSERT_EQ(run("render doe.json -q --preset auto --size 24x24 --mesh jane.ply -o p/a.png").exitCode, 0);
    const std::string text = readManifest(folder_ / "p" / "a.png");
    EXPECT_THAT(text, Not(HasSubstr("doe")));
    EXPECT_THAT(text, Not(HasSubstr("jane")));
    expectRefused("redraw p/a.png", {"mesh 1", ".ply", "--data"});
    const Outcome found = run("redraw p/a.png --data jane.ply");
    EXPECT_EQ(found.exitCode, 0) << found.problems;
    EXPECT_THAT(found.out, HasSubstr("(volume 1, the cache of imports; content "));
    EXPECT_THAT(found.out, HasSubstr("(mesh 1, --data; content "));
    EXPECT_THAT(found.out, HasSubstr("pixels:   equal"));
    fs::copy(folder_ / "jane.ply", folder_ / "p" / "renamed.ply");
    EXPECT_THAT(run("redraw p/a.png").out, HasSubstr("(mesh 1, beside the picture; content "));
    ASSERT_EQ(run("cache clear -q").exitCode, 0);
    expectRefused("redraw p/a.png", {"volume 1", "12 x 10 x 8 voxels", "uint8"});
    const Outcome source = run("redraw p/a.png --data doe.json");
    EXPECT_THAT(source.out, HasSubstr("the same (volume 1, --data; content ")) << source.problems;
    const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\n"
                               "sizes: 12 10 8\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                               "space origin: (0,0,0)\nencoding: raw\nendian: little\n\n";
    std::string labels;
    for (int n = 0; n < 12 * 10 * 8; ++n)
        labels += n % 12 > 5 ? '\1' : '\0';
    write("doe.nrrd", header + voxels);
    write("jane.nrrd", header + labels);
    ASSERT_EQ(run("render doe.nrrd --labels jane.nrrd -q --preset auto --size 24x24 -o p/l.png").exitCode, 0);
    EXPECT_THAT(readManifest(folder_ / "p" / "l.png"), Not(HasSubstr("jane")));
    for (const char* given : {"", " --data doe.nrrd --data jane.nrrd"}) {
        const Outcome labelled = run("redraw p/l.png" + std::string(given));
        EXPECT_THAT(labelled.out, HasSubstr("the same (labels of volume 1, ")) << labelled.problems;
        EXPECT_THAT(labelled.out, HasSubstr("pixels:   equal"));
    }
    write("p/renamed.ply", mesh + "\n");
    write("jane.ply", mesh.substr(0, mesh.size() - 30) + "8 0 0\n0 8 5\n3 0 1 2\n");
    expectRefused("redraw p/a.png", {"mesh 1"});
}
#endif

constexpr const char* kBranchedPath = R"({"tesseraPath":1,"lines":[
 {"name":"Jane","count":3,"spacing":10,"points":[[0,0,14],[0,0,4],[0,0,-6]],"radius":[9,9,9]},
 {"name":"Doe","count":3,"spacing":5,"points":[[0,0,4],[3,0,0],[6,0,-4]],"radius":[9,9,9],"parent":0,"leavesAt":10},
 {"count":3,"spacing":5,"points":[[0,0,4],[-3,0,0],[-6,0,-4]],"radius":[9,9,9],"parent":0,"leavesAt":10}],
 "flight":{"route":[0,2],"from":1.5}})";

// Along lines: reformations and unfolded walls have their line in their manifest, and no name of it.
TEST_F(Redraw, PicturesAlongLines) {
    write("jane.json", kBranchedPath);
    const std::string small = " --mm-per-pixel 1";
    for (const std::string& options :
         {"--straighten" + small,
          std::string("--straighten --angle 33.3 --mm-per-pixel 0.7 --slab 4:maximum"),
          "--straighten --angles 3" + small,
          "--straighten --sections 5 --angles 2 --directions letters" + small,
          "--sections 3 --angle 12.3" + small, "--curved --sections 2 --angle 4" + small, "--curved" + small,
          "--curved --direction 1,0.3,0.1 --across 17.25" + small, "--curved --view 20,30" + small,
          std::string("--unfold --engine native --size 32x20"),
          std::string("--unfold --engine mirror --ram 300MiB")}) {
        write("line.json", kBranchedPath);
        const Outcome drawn = run("render s.zarr --path line.json -q -o p.exr " + options);
        ASSERT_EQ(drawn.exitCode, 0) << options << drawn.problems;
        for (const char* name : {"Jane", "Doe", "line.json"})
            EXPECT_THAT(readManifest(folder_ / "p.exr"), Not(HasSubstr(name))) << options;
        EXPECT_EQ(manifestOf("p.exr")["path"]["lines"].size(), 2U) << "those of the flight";
        fs::remove(folder_ / "line.json");
        for (const char* picture : {"p.exr", "q.exr"}) { // and one that was drawn again
            const Outcome outcome = run(std::string("redraw ") + picture + " -o " +
                                        (picture == std::string("p.exr") ? "q.exr" : "r.exr"));
            ASSERT_EQ(outcome.exitCode, 0) << options << outcome.problems;
            EXPECT_THAT(outcome.out, HasSubstr("settings: the same\npixels:   equal")) << options;
        }
        EXPECT_TRUE(samePixels("p.exr", "r.exr")) << options;
        const Outcome changed = run("redraw p.exr --with shading.ambient=0.9 --with window=0,4000");
        EXPECT_EQ(changed.exitCode, 0) << changed.problems;
        EXPECT_THAT(changed.out, HasSubstr(" differ, rms 0.")) << options;
        const Outcome other = run("redraw p.exr --path jane.json");
        EXPECT_THAT(other.out, HasSubstr("settings: the same\npixels:   equal")) << options << other.problems;
    }
}

TEST_F(Redraw, NamesAnotherPathOfAPictureAlongALine) {
    write("line.json", kBranchedPath);
    std::string turned = kBranchedPath;
    turned.replace(turned.find("[0,2]"), 5, "[0,1]");
    write("turned.json", turned);
    for (const char* options : {"--straighten", "--unfold --engine native"}) {
        const Outcome drawn = run(std::string("render s.zarr --path line.json -q -o p.exr ") + options);
        ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
        const json manifest = manifestOf("p.exr");
        const std::string digest =
            manifest[manifest.contains("unfolded") ? "unfolded" : "reformation"]["lineHash"];
        const Outcome other = run("redraw p.exr --path turned.json");
        EXPECT_EQ(other.exitCode, 0) << other.problems;
        EXPECT_THAT(other.out, HasSubstr("settings: path: " + digest + ", now ")) << options;
        rewrite("p.exr", [](json& changed, Image&) { changed["path"]["flight"]["from"] = 2; });
        EXPECT_THAT(run("redraw p.exr").out, HasSubstr("settings: path: " + digest + ", now ")) << options;
        rewrite("p.exr", [](json& changed, Image&) { changed.erase("path"); }); // as of an older program
        expectRefused("redraw p.exr", {"p.exr", "--path"});
        EXPECT_THAT(run("redraw p.exr --path line.json").out, HasSubstr("pixels:   equal")) << options;
        rewrite("p.exr", [](json& changed, Image&) { changed["path"] = {{"tesseraPath", 1}, {"lines", 7}}; });
        expectRefused("redraw p.exr", {"p.exr", "lines"});
    }
    ASSERT_EQ(run("render s.zarr --path line.json --straighten -q -o p.png").exitCode, 0);
    EXPECT_THAT(run("info p.png").out, HasSubstr("reformation:   straightened\n"));
    expectRefused("redraw p.png --with image.size=20x20", {"--with", "image.size"});
    expectRefused("redraw p.png --with mode=maximum", {"--with", "mode"});
    expectRefused("redraw p.png --engine native", {"--engine"});
    const json whole = manifestOf("p.png");
    for (const char* key : {"widthMm", "mmPerPixel", "form", "anglesDegrees", "lineHash"})
        for (const char* value : {"-1", "\"x\"", "[[]]", "1e300", "null"}) {
            json manifest = whole;
            manifest["reformation"][key] = json::parse(value);
            writeImage(folder_ / "h.png", Image(glm::ivec2(4, 4)), manifest.dump());
            const int code = run("redraw h.png -q").exitCode;
            EXPECT_TRUE(code == 0 || code == 2) << key << " " << value << ": " << code;
        }
    draw("a.png");
    expectRefused("redraw a.png --path line.json", {"--path", "an unfolded wall or a reformation"});
}

// Whoever made a picture does not say how much memory is taken here.
TEST_F(Redraw, TakesNoMoreMemoryThanTheDefault) {
    for (const char* budget : {"ram", "gpuMemory"}) {
        draw("a.png", "--ram 200MiB");
        rewrite("a.png", [&](json& manifest, Image&) {
            manifest["budgets"][budget]["limitBytes"] = std::uint64_t{1} << 63;
        });
        const std::string option = budget == std::string("ram") ? "--ram" : "--gpu-memory";
        const Outcome outcome = run("redraw a.png -o b.png");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
        EXPECT_THAT(outcome.problems, HasSubstr("of " + option + "; it is drawn with "));
        EXPECT_LE(manifestOf("b.png")["budgets"][budget]["limitBytes"].get<std::uint64_t>(), 1U << 30);
        EXPECT_THAT(run("redraw a.png " + option + " 200MiB").problems, Not(HasSubstr("it is drawn with")));
    }
    draw("a.png", "--panel left,right");
    rewrite("a.png", [](json& manifest, Image&) {
        for (json& panel : manifest["panels"])
            panel["budgets"]["ram"]["limitBytes"] = std::uint64_t{1} << 40;
    });
    const Outcome panels = run("redraw a.png -o b.png");
    EXPECT_EQ(panels.exitCode, 0) << panels.problems;
    EXPECT_THAT(panels.problems, HasSubstr("it is drawn with "));
    EXPECT_LE(manifestOf("b.png")["panels"][1]["budgets"]["ram"]["limitBytes"].get<std::uint64_t>(),
              1U << 30);
}

TEST_F(Redraw, RefusesTilesThatTheOptionRefuses) {
    draw("a.png");
    for (const char* side : {"-5", "1", "63", "16385", "1e300", "\"64\"", "18446744073709551615"}) {
        rewrite("a.png", [&](json& manifest, Image&) { manifest["options"]["tile"] = json::parse(side); });
        expectRefused("redraw a.png", {"a.png", "tiles of 64 to 16384 pixels"});
    }
    rewrite("a.png", [&](json& manifest, Image&) { manifest["options"] = json::array({1}); });
    expectRefused("redraw a.png", {"a.png", "manifest"});
}

// By their headers: what cannot be compared is not read.
TEST_F(Redraw, ComparesSizesBeforePixels) {
    draw("a.png");
    rewrite("a.png", [](json&, Image& image) { image = Image(glm::ivec2(300, 200)); });
    const std::string whole = readAll(folder_ / "a.png");
    write("a.png", whole.substr(0, whole.size() - 100));
    const Outcome outcome = run("redraw a.png");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_THAT(outcome.out, HasSubstr("not compared: their sizes differ, 300 x 200 and 40 x 32"));
}

TEST_F(Redraw, PagesAreComparedByTheirBytes) {
    for (const char* page : {"a.pdf", "a.svg"}) {
        const Outcome drawn =
            run(std::string("render s.zarr -q --preset auto --size 40x32 --ram 200MiB -o ") + page);
        if (drawn.problems.find("built without") != std::string::npos)
            GTEST_SKIP() << drawn.problems;
        const Outcome outcome = run(std::string("redraw ") + page + " -q");
        ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
        EXPECT_THAT(outcome.out, HasSubstr(" bytes of the page)")) << page;
        const Outcome changed = run(std::string("redraw ") + page + " -q --with shading.ambient=0.4");
        EXPECT_THAT(changed.out, HasSubstr(" bytes of the page differ")) << page;
        EXPECT_EQ(changed.exitCode, 0) << page;
        const std::string whole = readAll(folder_ / page);
        const std::size_t at = page == std::string("a.svg") ? whole.rfind("base64,") + 30 : 1000;
        write(page, whole.substr(0, at) + static_cast<char>(whole[at] ^ 1) + whole.substr(at + 1));
        EXPECT_EQ(run(std::string("redraw ") + page + " -q").exitCode, 1) << page;
        const Outcome other = run(std::string("redraw ") + page + " -q -o b.png");
        EXPECT_THAT(other.out,
                    HasSubstr("their formats differ, ." + std::string(page).substr(2) + " and .png"));
    }
}

// What a stranger wrote does not reach the terminal as it is.
TEST_F(Redraw, NamesOfAManifestAreNoCommandsOfTheTerminal) {
    draw("a.png");
    const auto with = [&](const char* key, const json& value) {
        draw("a.png");
        rewrite("a.png", [&](json& manifest, Image&) { manifest["data"][0][key] = value; });
    };
    for (const char* hash : {"\x1b[31mRED", "0123456789abcde", "0123456789abcdefg", "0123456789ABCDEF"}) {
        with("contentHash", hash);
        expectRefused("redraw a.png", {"a.png", "contentHash"});
    }
    for (const json& extent : {json({1e300, 2, 3}), json({-1, 2, 3}), json({1, 2}), json(7)}) {
        with("extentVoxels", extent);
        EXPECT_EQ(run("redraw a.png").exitCode, 0) << extent;
    }
    with("type", "\x1b[31m\nRED");
    fs::remove_all(folder_ / "s.zarr");
    expectRefused("redraw a.png", {"a.png", "volume 1"});
}

// Whatever a stranger's figure says, it is refused before it takes room.
TEST_F(Redraw, FiguresOfStrangersAreRefused) {
    draw("a.png", "--panel left,anterior --title Both --engine native");
    const json own = manifestOf("a.png")["figure"];
    const std::vector<std::pair<const char*, json>> strange = {
        {"dpi", 0},          {"dpi", 1e9},           {"dpi", "many"},
        {"textPoints", -5},  {"textPoints", 1e-300}, {"title", std::string(1 << 20, 'x')},
        {"caption", 3},      {"columns", -1},        {"columns", 1.5},
        {"gap", 1u << 30},   {"above", 32768},       {"below", 5000000000},
        {"panelSize", {40}}, {"panelSize", nullptr}, {"oneScale", "yes"}};
    for (const auto& [key, value] : strange) {
        SCOPED_TRACE(std::string(key) + ": " + value.dump().substr(0, 40));
        rewrite("a.png", [&, key = key, value = value](json& manifest, Image&) {
            manifest["figure"] = own;
            manifest["figure"][key] = value;
        });
        expectRefused("redraw a.png", {"a.png", "expected \"figure\" as tessera writes it"});
    }
    rewrite("a.png", [&](json& manifest, Image&) {
        manifest["figure"] = own;
        const json panel = manifest["panels"][0];
        for (int n = 2; n <= 400; ++n)
            manifest["panels"].push_back(panel);
    });
    expectRefused("redraw a.png", {"a.png", "expected \"figure\" as tessera writes it"});
}

// What panels share changes in the figure, not in each of them: its words, and one scale.
TEST_F(Redraw, WithChangesWhatPanelsShare) {
    ASSERT_EQ(run("phantom torso -q --size 24x32x40 -o torso.zarr").exitCode, 0);
    ASSERT_EQ(run("render torso.zarr -q --preset auto --size 80x64 --panel torso.zarr,s.zarr --panel-letters "
                  "--title Both --projection parallel --engine native -o a.png")
                  .exitCode,
              0);
    EXPECT_EQ(manifestOf("a.png")["figure"]["letters"], true);
    const Outcome words =
        run("redraw a.png -q --with annotations.title=Other --with annotations.caption=Below "
            "--with annotations.dpi=120 -o b.png");
    ASSERT_EQ(words.exitCode, 0) << words.problems;
    EXPECT_THAT(words.out, HasSubstr("figure, title: Both, now Other"));
    EXPECT_THAT(words.out, HasSubstr("figure, dpi: 96"));
    const json changed = manifestOf("b.png");
    EXPECT_EQ(changed["figure"]["title"], "Other");
    EXPECT_EQ(changed["figure"]["caption"], "Below");
    EXPECT_GT(changed["figure"]["below"].get<int>(), 0);
    for (const json& panel : changed["panels"])
        EXPECT_EQ(panel["scene"].value("annotations", json::object()).value("title", ""), "");
    const Outcome seen = run("redraw a.png -q --with camera.view=left -o c.png");
    ASSERT_EQ(seen.exitCode, 0) << seen.problems;
    const json panels = manifestOf("c.png")["panels"];
    EXPECT_EQ(panels[0]["scene"]["camera"]["parallelScale"], panels[1]["scene"]["camera"]["parallelScale"]);
}

} // namespace
} // namespace tessera::test
