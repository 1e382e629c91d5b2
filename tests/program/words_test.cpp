// tests/program/words_test.cpp: users' words for colours, lengths and commands are understood. A picture
// without a requested part says why: whole sentences, with the volume's own numbers.
#include "core/image/image_file.h"
#include "tests/support/program_fixture.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Words : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    static std::string render(const std::string& more) {
        return "render s.zarr -o a.png --preset auto --engine mirror --size 16x16 " + more;
    }
    nlohmann::json sceneOf(const std::string& more) {
        const Outcome outcome = run(render("--json -q " + more));
        EXPECT_EQ(outcome.exitCode, 0) << more << "\n" << outcome.problems;
        return outcome.exitCode == 0 ? nlohmann::json::parse(outcome.out)["scene"] : nlohmann::json();
    }
};

TEST_F(Words, ColoursHaveTheNamesOfCss) {
    EXPECT_EQ(sceneOf("--background red")["image"]["background"], "#ff0000");
    EXPECT_EQ(sceneOf("--background Gray")["image"]["background"], "#808080");
    EXPECT_EQ(sceneOf("--background grey")["image"]["background"], "#808080");
    EXPECT_EQ(sceneOf("--background transparent")["image"]["background"], "transparent");
    EXPECT_EQ(sceneOf("--isosurface 10:red:0.5")["isosurfaces"],
              sceneOf("--isosurface 10:#FF0000:0.5")["isosurfaces"]);
    expectRefused(render("--background rde"), {"--background", "#rrggbb", "nearest: \"red\""});
    expectRefused(render("--isosurface 10:ivry"), {"--isosurface", "nearest: \"ivory\""});
    expectRefused(render("--isosurface 10:transparent"), {"--isosurface", "\"transparent\""});
}

TEST_F(Words, LengthsMayHaveTheirUnit) {
    EXPECT_EQ(sceneOf("--slice axial --slab 5mm")["slice"], sceneOf("--slice axial --slab 5")["slice"]);
    EXPECT_EQ(sceneOf("--slice coronal:1.5mm --slab 2mm:maximum")["slice"],
              sceneOf("--slice coronal:1.5 --slab 2:maximum")["slice"]);
    EXPECT_EQ(sceneOf("--crop=-5mm,5mm,-5,5,-5mm,5mm")["cuts"], sceneOf("--crop=-5,5,-5,5,-5,5")["cuts"]);
    expectRefused(render("--slice axial --slab mm"), {"--slab"});
    expectRefused(render("--slice axial --slab 5cm"), {"--slab", "5cm"});
    expectRefused("centreline s.zarr --from 0,0 -o a.json", {"--from", "x,y,z"});
    expectRefused("centreline s.zarr --from 0,0,0,0 -o a.json", {"--from", "x,y,z"});
    expectRefused("centreline s.zarr --from 0mm,0mm,1e9mm -o a.json", {"--from", "x,y,z"});
    expectRefused("centreline s.zarr --from 0,0,0 --spacing 500mm -o a.json", {"--spacing", "0.05 to 100"});
    // Understood: what is refused is the store.
    expectRefused("centreline none.zarr --from 0mm,0mm,0mm --spacing 2mm -o a.json", {"none.zarr"});
    expectRefused("coverage none.zarr --path p.json --every 2mm --farthest 90mm --smallest 9mm2",
                  {"none.zarr"});
}

TEST_F(Words, ACommandsOwnCommandsAreNamed) {
    expectRefused("cache clean", {"list, clear, path", "\"clean\"", "nearest: \"clear\""});
    EXPECT_EQ(run("cache -q list").exitCode, 0);
}

// The phantom is 256 mm long along each axis, around the origin.
TEST_F(Words, ASliceBesideTheVolumeIsRefusedWithItsRange) {
    expectRefused(render("--slice axial:400"), {"--slice", "z from -128 to 128 mm", "axial:400"});
    expectRefused(render("--slice coronal:-129"), {"--slice", "y from -128 to 128 mm", "coronal:-129"});
    expectRefused(render("--slice sagittal:129 --slab 1.9"), {"x from -128 to 128 mm"});
    expectRefused(render("--slice oblique:200,200,200,1,1,1"),
                  {"x from -128", "y from", "z from -128 to 128 mm"});
    EXPECT_FALSE(exists("a.png"));
    for (const char* taken : {"--slice axial:128", "--slice sagittal:129 --slab 2.1", "--slice axial:0"})
        EXPECT_EQ(run(render(taken)).exitCode, 0) << taken;
    write("scene.json", R"({"tesseraScene":1,"volumes":[{"path":"s.zarr","transferFunction":"auto"}],
        "mode":"slice","slice":{"plane":"axial","position":199}})");
    expectRefused("render scene.json -o a.png", {"scene.json: $.slice", "z from -128 to 128 mm"});
}

TEST_F(Words, AnIsosurfaceOfNoValueIsNamed) {
    const Outcome beside = run(render("--isosurface 5000 --isosurface 10"));
    EXPECT_EQ(beside.exitCode, 0) << beside.problems;
    EXPECT_THAT(beside.problems, AllOf(HasSubstr("isosurface 5000"), HasSubstr("its values go from"),
                                       Not(HasSubstr("isosurface 10:"))));
    const Outcome alone = run(render("--mode isosurface --isosurface 5000"));
    EXPECT_EQ(alone.exitCode, 0) << alone.problems;
    EXPECT_THAT(alone.problems, AllOf(HasSubstr("blank: none of the isosurfaces' values is among the "
                                                "volume's, which go from"),
                                      HasSubstr("--isosurface ")));
}

TEST_F(Words, ABlankPictureSaysWhereTheVolumeIs) {
    write("scene.json", R"({"tesseraScene":1,"image":{"size":[16,16]},"volumes":[{"path":"s.zarr",
        "transferFunction":"auto"}],"camera":{"position":[0,-9000,0],"focalPoint":[0,-9999,0]}})");
    const std::string missed = run("render scene.json -o a.png --engine mirror -q").problems;
    EXPECT_THAT(missed,
                HasSubstr("the camera sees nothing of the volume, which lies in x from -128 to 128, y "
                          "from -128 to 128 and z from -128 to 128 mm; try: "));
    const std::string cut = run(render("-q --crop 190,199,190,199,190,199")).problems;
    EXPECT_THAT(cut, HasSubstr("the cuts leave nothing of the volume, which lies in x from -128 to 128"));
    const std::string inAir = run(render("-q --crop-voxels 0,1,0,1,0,1")).problems;
    EXPECT_THAT(inAir, HasSubstr("outside of the cuts"));
}

// A slice that is seen from its edge shows nothing: a side that an option names is refused, the scene's does
// not count.
TEST_F(Words, ASliceIsNotSeenFromItsEdge) {
    expectRefused(render("--slice axial:0 --view left"), {"--view", "a side that faces the slice", "left"});
    expectRefused(render("--slice sagittal:0 --view 0,90"), {"--view", "0,90"});
    EXPECT_EQ(run(render("--slice axial:0 --view superior")).exitCode, 0);
    EXPECT_EQ(run(render("--slice axial:0 --view 30,5")).exitCode, 0) << "from aside, but not from its edge";
    write(
        "scene.json",
        R"({"tesseraScene":1,"image":{"size":[24,24]},"volumes":[{"path":"s.zarr","transferFunction":"auto"}],
        "camera":{"view":"anterior"}})");
    const std::string how = " --engine mirror --no-check -q --size 24x24 -o ";
    EXPECT_EQ(run("render scene.json --slice axial:3" + how + "a.exr").exitCode, 0);
    EXPECT_EQ(run("render s.zarr --preset auto --slice axial:3" + how + "b.exr").exitCode, 0);
    EXPECT_EQ(readImage(folder_ / "a.exr").pixels, readImage(folder_ / "b.exr").pixels);
    EXPECT_EQ(run("render scene.json --slice coronal:3" + how + "a.exr").exitCode, 0);
    write(
        "edge.json",
        R"({"tesseraScene":1,"image":{"size":[24,24]},"volumes":[{"path":"s.zarr","transferFunction":"auto"}],
        "camera":{"view":"anterior"},"mode":"slice","slice":{"plane":"axial"}})");
    EXPECT_EQ(run("render s.zarr --preset auto --slice axial" + how + "b.exr").exitCode, 0);
    const Outcome edge = run("render edge.json -o a.exr --engine mirror --no-check");
    EXPECT_THAT(edge.problems, HasSubstr("the scene's side, anterior, sees the edge of the slice"));
    EXPECT_EQ(readImage(folder_ / "a.exr").pixels, readImage(folder_ / "b.exr").pixels);
    // Whatever says both.
    const std::string both = "render s.zarr --preset auto" + how + "c.exr ";
    for (const std::string sets :
         {"--set slice=axial:3 --view left", "--slice axial:3 --set camera.view=left",
          "--set slice=axial:3 --set camera.view=left"})
        expectRefused(both + sets, {"a side that faces the slice", "left"});
    expectRefused("render s.zarr --preset auto -q --no-check -o p.png --panel slice=axial:3;camera.view=left",
                  {"--set camera.view", "left"});
    // A camera of another plane.
    write("free.json", R"({"tesseraScene":1,"image":{"size":[24,24]},
        "volumes":[{"path":"s.zarr","transferFunction":"auto"}],
        "camera":{"position":[0,-900,900],"focalPoint":[0,0,0],"viewUp":[0,0,1]}})");
    EXPECT_EQ(run("render free.json --set slice=axial:3" + how + "a.exr").exitCode, 0);
    EXPECT_EQ(run("render s.zarr --preset auto --slice axial:3" + how + "b.exr").exitCode, 0);
    EXPECT_EQ(readImage(folder_ / "a.exr").pixels, readImage(folder_ / "b.exr").pixels);
}

// Slices that stand like axial and coronal ones are seen as radiology sees these, or it is told.
TEST_F(Words, AMirroredSliceIsTold) {
    for (const auto& [normal, told] : {std::pair("0,0,1", "from the head"),
                                       {"0.2,0.3,0.9", "from the head"},
                                       {"0,1,0", "from the back"},
                                       {"0,0,-1", ""},
                                       {"0,-1,0.2", ""},
                                       {"1,0,0", ""},
                                       {"-1,0,0", ""}}) {
        const std::string problems = run(render(std::string("--slice=oblique:0,0,0,") + normal)).problems;
        EXPECT_EQ(problems.find("the slice is seen from the") != std::string::npos, *told != 0) << normal;
        EXPECT_THAT(problems, HasSubstr(told));
    }
}

TEST_F(Words, OptionsOfLabelsNeedLabels) {
    for (const char* option : {"--show liver", "--label-fill 0.4", "--label-look tint"})
        expectRefused(render(option), {"expected labels beside the volume (--labels), found none"});
    expectRefused(render("--mode slice --window 40"), {"--window", "CENTRE,WIDTH or one of auto, brain"});
}

} // namespace
} // namespace tessera::test
