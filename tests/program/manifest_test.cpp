// tests/program/manifest_test.cpp: the result of options and scenes, as in the picture's manifest. Also
// `info` of volumes with a negative slope or a rotated affine.
#include "tests/support/program_fixture.h"
#if TESSERA_WITH_IMPORT
#include "tests/support/import_test_tools.h"
#endif

#include <cmath>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Manifest : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    /// The manifest of a small picture.
    /// @param input  and further options
    json of(const std::string& input) {
        const Outcome outcome = run("render " + input + " -o a.png --engine mirror --no-check --json -q");
        EXPECT_EQ(outcome.exitCode, 0) << input << "\n" << outcome.problems;
        return json::parse(outcome.out);
    }
    /// Of a scene with that camera, with further options.
    json ofScene(const std::string& camera, const std::string& options = "") {
        write("scene.json", R"({"tesseraScene":1,"volumes":[{"path":"s.zarr","transferFunction":"auto"}],)"
                            R"("image":{"size":[24,16]},"camera":)" +
                                camera + "}");
        return of("scene.json " + options);
    }
};

TEST_F(Manifest, AnotherViewKeepsProjectionAndFit) {
    const json parallel =
        ofScene(R"({"view":"anterior","fit":"volume","parallelProjection":true})", "--view left");
    EXPECT_EQ(parallel["scene"]["camera"]["parallelProjection"], true);
    EXPECT_EQ(parallel["scene"]["camera"],
              ofScene(R"({"view":"left","fit":"volume","parallelProjection":true})")["scene"]["camera"]);
    EXPECT_NE(parallel["scene"]["camera"],
              ofScene(R"({"view":"left","fit":"shown","parallelProjection":true})")["scene"]["camera"]);
}

// One scale for several pictures, whatever their size and side.
TEST_F(Manifest, MillimetresPerPixelAreTheScaleOfParallelPictures) {
    const std::string scale = "--projection parallel --mm-per-pixel 2.5 --size ";
    for (const char* camera : {R"({"view":"left"})", R"({"position":[0,-300,0],"focalPoint":[0,0,0]})"})
        for (const int height : {8, 24}) {
            const json manifest = ofScene(camera, scale + "16x" + std::to_string(height));
            EXPECT_DOUBLE_EQ(manifest["scene"]["camera"]["parallelScale"], 1.25 * height)
                << manifest["scene"]["camera"];
        }
    EXPECT_DOUBLE_EQ(of("s.zarr --preset auto --size 16x8 --slice axial --mm-per-pixel 3")["scene"]["camera"]
                                                                                          ["parallelScale"],
                     12);
    // A camera by side becomes parallel, but against its word; one that is spelled out stays what it is.
    EXPECT_DOUBLE_EQ(
        ofScene(R"({"view":"left"})", "--mm-per-pixel 2.5 --size 16x8")["scene"]["camera"]["parallelScale"],
        10);
    expectRefused("render scene.json -o b.png --mm-per-pixel 2 --projection perspective",
                  {"--mm-per-pixel", "parallel", "perspective"});
    ofScene(R"({"position":[0,-300,0],"focalPoint":[0,0,0]})"); // leaves scene.json
    expectRefused("render scene.json -o b.png --mm-per-pixel 2",
                  {"--mm-per-pixel", "parallel", "perspective"});
}

// In the volume's unit, from its least value to its largest, as `info` tells them.
TEST_F(Manifest, TellsWhatValuesTheVolumeHas) {
    const json info = json::parse(run("info s.zarr --json").out);
    EXPECT_LT(info["lowest"], -900);
    EXPECT_GT(info["highest"], 900);
    const json store = of("s.zarr --preset auto --size 8x8")["store"];
    EXPECT_EQ(store["lowest"], info["lowest"]);
    EXPECT_EQ(store["highest"], info["highest"]);
}

// A bar is drawn where it is asked for; the manifest says how long it is, and where that holds.
TEST_F(Manifest, AScaleBarIsDrawnAndToldOf) {
    const std::string render = "render s.zarr -q --engine native --preset auto --no-check --samples 1 "
                               "--size 200x160 --projection parallel --json -o ";
    const Outcome plain = run(render + "a.png"), barred = run(render + "b.png --scale-bar");
    ASSERT_EQ(plain.exitCode, 0) << plain.problems;
    ASSERT_EQ(barred.exitCode, 0) << barred.problems;
    EXPECT_FALSE(json::parse(plain.out).contains("scaleBar"));
    const json bar = json::parse(barred.out)["scaleBar"];
    EXPECT_EQ(bar["at"], "everywhere");
    const double scale = json::parse(barred.out)["scene"]["camera"]["parallelScale"];
    EXPECT_NEAR(bar["mm"].get<double>() / bar["pixels"].get<double>(), 2 * scale / 160, 1e-9);
    EXPECT_EQ(json::parse(run("info b.png --json").out)["scaleBar"], bar);
    EXPECT_EQ(
        json::parse(
            run("render s.zarr -q --preset auto --size 160x128 --engine mirror --json --scale-bar -o c.png")
                .out)["scaleBar"]["at"],
        "centre");
}

TEST_F(Manifest, AViewByAngles) {
    const std::string small = "s.zarr --preset auto --size 16x16 --view ";
    EXPECT_EQ(of(small + "90,0")["scene"]["camera"], of(small + "left")["scene"]["camera"]);
    const json manifest = of(small + "30,15");
    const auto& at = manifest["scene"]["camera"];
    const auto side = [&](int axis) {
        return at["position"][axis].get<double>() - at["focalPoint"][axis].get<double>();
    };
    EXPECT_NEAR(std::atan2(side(0), -side(1)) * 180 / 3.14159265358979, 30, 1e-9);
    EXPECT_NEAR(std::asin(side(2) / std::hypot(side(0), side(1), side(2))) * 180 / 3.14159265358979, 15,
                1e-9);
    for (const char* wrong : {"30", "30,", ",3", "30,15,4", "30;15", "400,0", "0,91", "1e999,0", "sidewards"})
        expectRefused("render s.zarr -o b.png --view " + std::string(wrong), {"--view"});
}

TEST_F(Manifest, AProjectionIsTakenWithAViewAndWithACamera) {
    for (const char* camera : {R"({"view":"left"})", R"({"position":[0,-300,0],"focalPoint":[0,0,0]})"}) {
        EXPECT_EQ(ofScene(camera)["scene"]["camera"]["parallelProjection"], false);
        EXPECT_EQ(ofScene(camera, "--projection parallel")["scene"]["camera"]["parallelProjection"], true);
    }
}

// A picture says how wrong it is: in its manifest, and to whoever asks the picture.
TEST_F(Manifest, SaysHowWrongThePictureIs) {
    const Outcome drawn =
        run("render s.zarr -o a.png --engine native --preset auto --size 48x48 --samples 4 --json -q");
    ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
    const json measured = json::parse(drawn.out)["errors"]["measured"];
    EXPECT_EQ(measured["mode"], "quick");
    for (const json& of : {measured, measured["samplesOfPixels"]}) {
        EXPECT_GT(of["rms"]["value"], 0);
        EXPECT_LE(of["rms"]["from"], of["rms"]["value"]);
        EXPECT_GE(of["rms"]["to"], of["rms"]["value"]);
    }
    EXPECT_GE(measured["pixels"], 400);
    const Outcome told = run("info a.png");
    EXPECT_EQ(told.exitCode, 0) << told.problems;
    EXPECT_THAT(told.out, HasSubstr("L*u*v*"));
    EXPECT_THAT(told.out, HasSubstr("of samples:"));
    EXPECT_EQ(json::parse(run("info a.png --json").out)["errors"]["measured"], measured);
    const json not_ = of("s.zarr --size 8x8");
    EXPECT_FALSE(not_["errors"].contains("measured")) << "--no-check";
    EXPECT_THAT(run("info a.png").out, HasSubstr("not measured"));
    write("b.png", "no picture");
    EXPECT_NE(run("info b.png").exitCode, 0);
}

// Effects that a measured error does not include are named beside it, wherever it is reported.
TEST_F(Manifest, SaysWhatIsNotInTheError) {
    const std::string render = "render s.zarr -o a.png --engine native --preset auto --size 40x40 --explain ";
    const Outcome lit = run(render + "--light studio --max-error 20");
    ASSERT_EQ(lit.exitCode, 0) << lit.problems;
    EXPECT_THAT(lit.out, HasSubstr("what light itself errs by is not in it"));
    EXPECT_THAT(lit.problems, HasSubstr("the error of the light itself is not measured"));
    EXPECT_THAT(run("info a.png").out, HasSubstr("what light itself errs by"));
    EXPECT_EQ(json::parse(run("info a.png --json").out)["errors"]["measured"]["notCounted"], json({"light"}));
    const Outcome full = run(render + "--light studio --verify full");
    ASSERT_EQ(full.exitCode, 0) << full.problems;
    EXPECT_THAT(full.out, HasSubstr("beside it the light, of voxels and maps: "));
    const json beside = json::parse(run("info a.png --json").out)["errors"]["measured"];
    EXPECT_TRUE(beside["light"].contains("rms")) << beside;
    EXPECT_FALSE(beside.contains("notCounted"));
    EXPECT_THAT(run("info a.png").out, HasSubstr("beside it:     of light"));
    const Outcome plain = run(render + "--samples 1");
    ASSERT_EQ(plain.exitCode, 0) << plain.problems;
    EXPECT_THAT(plain.out, Not(HasSubstr("light itself")));
    EXPECT_THAT(
        plain.out,
        HasSubstr(
            "of the mean over a pixel's 16 rays; single rays, as the picture has, err by as much or more"));
    EXPECT_FALSE(json::parse(run("info a.png --json").out)["errors"]["measured"].contains("notCounted"));
    EXPECT_THAT(run(render + "--samples 4").out, Not(HasSubstr("single rays")));
}

// Errors of paths of light are not measured; their noise is told.
TEST_F(Manifest, TellsTheNoiseOfPaths) {
    const Outcome drawn =
        run("render s.zarr -o a.png --preset auto --size 24x24 --light cinematic --samples 8 --json -q");
    ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
    const json manifest = json::parse(drawn.out);
    EXPECT_GT(manifest["paths"]["paths"], 0);
    EXPECT_EQ(manifest["paths"]["oneByOne"], 0);
    EXPECT_GT(manifest["pixels"]["standardError"]["rms"], 0);
    EXPECT_THAT(run("info a.png").out, HasSubstr("noise:         rms 0."));
    ASSERT_EQ(run("render s.zarr -o a.png --preset auto --size 8x8 --light cinematic --samples 1").exitCode,
              0);
    EXPECT_THAT(run("info a.png").out, Not(HasSubstr("noise:")));
    const Outcome set = run("render s.zarr -o a.png --preset auto --size 8x8 --set "
                            "lighting.transport.bounces=2 --json -q"); // has no samples of its own
    ASSERT_EQ(set.exitCode, 0) << set.problems;
    EXPECT_EQ(json::parse(set.out)["pixels"]["samples"], 64);
}

// A filtered picture has an error of its own, which its pixels drawn again tell.
TEST_F(Manifest, TellsTheErrorOfDenoisedPaths) {
    const Outcome drawn =
        run("render s.zarr -o a.png --preset auto --size 40x40 --light cinematic --samples 8 "
            "--denoise --verify full --explain");
    ASSERT_EQ(drawn.exitCode, 0) << drawn.problems;
    EXPECT_THAT(drawn.out, HasSubstr("what levels and step err by is not in it"));
    const json measured = json::parse(run("info a.png --json").out)["errors"]["measured"];
    EXPECT_TRUE(measured.contains("rms")) << measured;
    EXPECT_EQ(measured["notCounted"], json({"levelsStepFiltering"}));
    EXPECT_FALSE(measured.contains("levelsStepFiltering"));
    EXPECT_THAT(run("info a.png").out, HasSubstr("what levels and step err by"));
    EXPECT_THAT(run("render s.zarr -o b.png --preset auto --size 8x8 --denoise --samples 4").problems,
                HasSubstr("quality.denoise: expected paths of light"));
    EXPECT_THAT(run("render s.zarr -o b.png --size 8x8 --light cinematic --denoise --samples 1").problems,
                HasSubstr("\"samples\" from 2 on beside \"denoise\""));
}

TEST_F(Manifest, HoldsTheCameraThatDrew) {
    const json camera = ofScene(R"({"view":"left"})")["scene"]["camera"];
    EXPECT_FALSE(camera.contains("view")) << "a later version could frame it in another way";
    EXPECT_EQ(ofScene(camera.dump())["scene"]["camera"], camera);
}

// Files are named after patients: the volume is named by what it holds.
TEST_F(Manifest, NamesTheVolumeByItsContent) {
    fs::rename(folder_ / "s.zarr", folder_ / "doe-jane.zarr");
    const json manifest = of("doe-jane.zarr --preset auto --size 8x8");
    EXPECT_EQ(manifest["scene"]["volumes"][0]["path"],
              "content-" + manifest["store"]["contentHash"].get<std::string>() + ".zarr");
    EXPECT_EQ(manifest.dump().find("doe-jane"), std::string::npos);
}

TEST_F(Manifest, OptionsStandInIt) {
    const std::string picture = "s.zarr --preset auto --size 24x16 ";
    const json plain = of(picture);
    EXPECT_EQ(plain["scene"]["image"]["size"], json({24, 16}));
    EXPECT_FALSE(plain["scene"]["quality"].contains("stepVoxels"));
    EXPECT_FALSE(plain["scene"]["quality"].contains("maxError"));
    const json step = of(picture + "--step 16"); // the largest
    EXPECT_EQ(step["scene"]["quality"]["stepVoxels"], 16);
    EXPECT_EQ(step["segments"]["stepVoxels"], 16);
    EXPECT_EQ(of(picture + "--max-error 0")["scene"]["quality"]["maxError"], 0);
    const json surface = of(picture + "--isosurface 10:#ff0000:0.25 --isosurface 20");
    ASSERT_EQ(surface["scene"]["isosurfaces"].size(), 2u);
    EXPECT_EQ(surface["scene"]["isosurfaces"][0],
              (json{{"value", 10.0}, {"rgb", {1.0, 0.0, 0.0}}, {"opacity", 0.25}}));
    EXPECT_EQ(surface["scene"]["isosurfaces"][1]["opacity"], 1);
    expectRefused("render " + picture + "-o a.png --isosurface 10:#ff0000:1.5", {"--isosurface", "0 to 1"});
    const json budgets = of(picture + "--ram 300MiB --gpu-memory 200MiB")["budgets"];
    EXPECT_EQ(budgets["ram"]["limitBytes"], 300 << 20);
    EXPECT_EQ(budgets["gpuMemory"]["limitBytes"], 200 << 20);
}

#if TESSERA_WITH_IMPORT
TEST_F(Manifest, TheUnitDecidesTheFunction) {
    NiftiImage image;
    image.extent = {8, 8, 8};
    image.voxels = std::string(2 * 8 * 8 * 8, '\1');
    writeFile(folder_ / "ct.nii", niftiBytes(image));
    const auto function = [&](const std::string& options) {
        return of("ct.nii --size 8x8 " + options)["scene"]["volumes"][0]["transferFunction"];
    };
    EXPECT_EQ(function(""), "auto");
    EXPECT_EQ(function("--unit HU"), "bone-1");
}

// -2 * stored + 100, turned a quarter about z, 2 x 3 x 5 mm.
TEST_F(Manifest, InfoTellsPhysicalValuesAndPlacesOfATurnedVolume) {
    std::string voxels;
    for (int i = 0; i < 4 * 6 * 3; ++i)
        voxels += static_cast<char>(i);
    write("v.raw", voxels);
    write("v.json", R"({"data":"v.raw","extent":[4,6,3],"type":"uint8","spacing":[2,3,5],"origin":[7,8,9],
                        "direction":[0.6,-0.8,0, 0.8,0.6,0, 0,0,1],"rescaleSlope":-2,"rescaleIntercept":100})");
    ASSERT_EQ(run("import v.json v.zarr").exitCode, 0);
    const json info = json::parse(run("info v.zarr --json").out);
    EXPECT_EQ(info["lowest"], 100 - 2 * 71);
    EXPECT_EQ(info["highest"], 100);
    const std::string text = run("info v.zarr").out;
    EXPECT_THAT(text, HasSubstr("-42 to 100"));
    EXPECT_EQ(info["fieldOfViewMm"][2], 15);
    EXPECT_THAT(text, HasSubstr(" x 15 mm")) << "from the first voxel's edge to the last one's";
    const glm::dvec3 step(2 * 0.6, 2 * 0.8, 0), down(-3 * 0.8, 3 * 0.6, 0); // of the file's x and y
    const int x = info["originalOrder"]["sourceAxis"][0].get<int>();
    const bool flipped = info["originalOrder"]["flipped"][0].get<bool>();
    const glm::dvec3 first = (flipped ? -1.0 : 1.0) * (x == 0 ? step : down);
    for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(info["patientFromVoxel"][row][0].get<double>(), first[row], 1e-12);
    EXPECT_EQ(info["patientFromVoxel"][3], json({0.0, 0.0, 0.0, 1.0}));
}

// A slice is a line from its side, and refused; a single row of voxels is no better from anywhere.
TEST_F(Manifest, ARowOfVoxelsIsDrawnFromEverySide) {
    write("r.raw", "0123456789");
    write("r.json", R"({"data":"r.raw","type":"uint8","extent":[1,1,10],"spacing":[1,1,1]})");
    for (const char* view : {"anterior", "left", "superior"})
        EXPECT_EQ(of(std::string("r.json --size 8x8 --view ") + view)["store"]["extentVoxels"],
                  json({1, 1, 10}));
}

TEST_F(Manifest, AbsentVoxelsAreToldAsPhysicalValues) {
    NiftiImage image;
    image.extent = {2, 2, 2};
    image.datatype = 16;
    image.slope = 2, image.intercept = 10;
    for (const float value : {std::nanf(""), 1.f, 2.f, 3.f, 4.f, 5.f, 6.f, 7.f})
        image.voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
    writeFile(folder_ / "m.nii", niftiBytes(image));
    EXPECT_THAT(run("import m.nii m.zarr").problems, HasSubstr("stored as the lowest value, 12"));
}

TEST_F(Manifest, TheLargestVolumeIsListedFirst) {
    fs::create_directory(folder_ / "scans");
    for (const int n : {2, 4, 3}) {
        const std::string name = "scans/" + std::to_string(n);
        write(name + ".raw", std::string(static_cast<std::size_t>(n * n * n), '\1'));
        const std::string extent = std::to_string(n) + "," + std::to_string(n) + "," + std::to_string(n);
        write(name + ".json", "{\"data\":\"" + std::to_string(n) + ".raw\",\"type\":\"uint8\",\"extent\":[" +
                                  extent + "],\"spacing\":[1,1,1]}");
    }
    const json listed = json::parse(run("info scans --json").out);
    ASSERT_EQ(listed["volumes"].size(), 3u);
    for (std::size_t i = 0; i < 3; ++i)
        EXPECT_EQ(listed["volumes"][i]["extentVoxels"][0], 4 - static_cast<int>(i));
}
#endif

} // namespace
} // namespace tessera::test
