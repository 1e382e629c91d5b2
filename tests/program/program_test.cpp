// tests/program/program_test.cpp: the program from outside: exit codes, one-line messages, what it writes and
// what not. Everything is generated; the cache folder is a temporary one.
#include "tests/support/program_fixture.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(Program, HelpAndVersionSucceed) {
    EXPECT_THAT(run("--version").out, HasSubstr("tessera 0."));
    EXPECT_EQ(run("--version").exitCode, 0);
    for (const char* command :
         {"", "import", "info", "render", "phantom", "accuracy", "bench", "bench lod", "bench memory"}) {
        const Outcome outcome = run(std::string(command) + " --help");
        EXPECT_EQ(outcome.exitCode, 0) << command;
        EXPECT_THAT(outcome.out, HasSubstr("Example:")) << command;
    }
}

TEST(ProgramItself, IsTheSameAsTheFunction) {
    const auto exitCode = [](const std::string& arguments) {
        return WEXITSTATUS(std::system(("'" TESSERA_PROGRAM "' " + arguments + " >/dev/null 2>&1").c_str()));
    };
    EXPECT_EQ(exitCode("--version"), 0);
    EXPECT_EQ(exitCode("info /no/such/file"), 2);
}

TEST_F(Program, UnknownCommandsAndOptionsAreRefusedWithTheNearest) {
    expectRefused("", {"--help"});
    expectRefused("rendr x", {"\"rendr\"", "nearest: \"render\""});
    expectRefused("render x.zarr -o a.png --gpu-memry 1GiB", {"--gpu-memry", "nearest: --gpu-memory"});
    for (const auto& [typed, meant] :
         std::vector<std::pair<std::string, std::string>>{{"--colour red", "--preset"},
                                                          {"--transfer-function=x", "--preset"},
                                                          {"--memory 1GiB", "--ram"},
                                                          {"--width 100", "--size"},
                                                          {"--isovalue 3", "--isosurface"},
                                                          {"--error 1", "--max-error"},
                                                          {"--skipping", "--no-skipping"},
                                                          {"--veiw left", "--view"},
                                                          {"--Fit volume", "--fit"},
                                                          {"--gradiant sobel", "--gradient"}})
        expectRefused("render x.zarr -o a.png " + typed, {"unknown option", "nearest: " + meant + " ("});
    const Outcome nothingLike = run("render x.zarr -o a.png --xyzzy");
    EXPECT_THAT(nothingLike.problems, Not(HasSubstr("nearest")));
    EXPECT_THAT(nothingLike.problems, HasSubstr("tessera render --help"));
    expectRefused("render x.zarr", {"--output"});
    expectRefused("info", {"X is required"});
    expectRefused("import a b.zarr --series two", {"--series"});
    expectRefused("bench", {"--help"});
    expectRefused("bench lod", {"--output"});
    expectRefused("bench lod -o out --only gradiant", {"--only", "nearest: \"gradient\""});
    expectRefused("bench memory -o out --scans nowhere", {"nowhere", "expected a folder with scans"});
}

// The side that faces the viewer by its other names; a camera that is spelled out cannot be fitted.
TEST_F(Program, SidesHaveOtherNamesAndFitsAreTaken) {
    makeSphere();
    const auto cameraOf = [&](const std::string& options) {
        const Outcome outcome =
            run("render s.zarr -o a.png --size 16x16 --no-check --gl-device software --json -q " + options);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        return nlohmann::json::parse(outcome.out)["scene"]["camera"];
    };
    for (const auto& [other, side] : std::vector<std::pair<std::string, std::string>>{
             {"front", "anterior"}, {"back", "posterior"}, {"top", "superior"}, {"bottom", "inferior"}})
        EXPECT_EQ(cameraOf("--view " + other), cameraOf("--view " + side));
    EXPECT_NE(cameraOf("--fit volume"), cameraOf(""));
    EXPECT_EQ(cameraOf("--fit shown"), cameraOf(""));
    // Chosen values stand in the manifest, so that a scene with them draws the same.
    nlohmann::json scene = {{"tesseraScene", 1},
                            {"volumes", {{{"path", "s.zarr"}, {"transferFunction", "auto"}}}},
                            {"camera", cameraOf("")}};
    write("scene.json", scene.dump());
    const Outcome again =
        run("render scene.json -o a.png --size 16x16 --no-check --gl-device software --json -q");
    EXPECT_EQ(nlohmann::json::parse(again.out)["scene"]["camera"], scene["camera"]);
    expectRefused("render scene.json -o a.png --fit volume", {"--fit", "--view"});
    expectRefused("render s.zarr -o a.png --fit tight", {"--fit", "shown, volume"});
}

TEST_F(Program, MissingAndEmptyInputsAreRefused) {
    fs::create_directory(folder_ / "empty");
    for (const std::string command : {"info", "import", "render"}) {
        const std::string rest = command == "import" ? " out.zarr" : command == "render" ? " -o a.png" : "";
        expectRefused(command + " none.nii" + rest, {"none.nii", "expected"});
        expectRefused(command + " empty" + rest, {"empty", "expected"});
        write("text.txt", "no volume");
        expectRefused(command + " text.txt" + rest, {"text.txt", "expected"});
    }
    EXPECT_FALSE(exists("out.zarr"));
    EXPECT_FALSE(exists("a.png"));
}

TEST_F(Program, PhantomsAreMadeAndNeverReplacedUnasked) {
    makeSphere();
    const std::string before = readAll(folder_ / "s.zarr" / "zarr.json");
    expectRefused("phantom ramp --size 8x8x8 -o s.zarr", {"s.zarr", "--force"});
    EXPECT_EQ(readAll(folder_ / "s.zarr" / "zarr.json"), before);
    EXPECT_EQ(run("phantom ramp --size 8x8x8 -o s.zarr --force").exitCode, 0);
    fs::create_directory(folder_ / "mine.zarr");
    write("mine.zarr/letter.txt", "dear");
    expectRefused("phantom ramp --size 8x8x8 -o mine.zarr --force", {"mine.zarr", "store"});
    EXPECT_TRUE(exists("mine.zarr/letter.txt"));
    expectRefused("phantom ramq --size 8x8x8 -o t.zarr", {"ramp"});
    for (const char* size :
         {"8x8", "8x8x0", "8x8x8x8", "8x8x", "8x8x8x", "-8x8x8", "8x8x99999999999", "axbxc", "''"})
        expectRefused(std::string("phantom ramp -o t.zarr --size ") + size, {"--size"});
    expectRefused("phantom ramp --size 8x8x8 -o t.zip", {".zarr"});
    expectRefused("phantom ramp --size 8x8x8 -o t.zarr --ram lots", {"--ram", "lots"});
    expectRefused("phantom ramp --size 8x8x8 -o t.zarr --ram 1KiB", {"--ram"}); // below the floor
    EXPECT_FALSE(exists("t.zarr"));
}

TEST_F(Program, InfoTellsWhatAStoreIs) {
    makeSphere();
    const json info = json::parse(run("info s.zarr --json").out);
    EXPECT_EQ(info["extentVoxels"], json({40, 33, 24}));
    EXPECT_LT(info["lowest"].get<double>(), info["highest"].get<double>());
    EXPECT_EQ(info["levels"].size(), 6u);
    EXPECT_FALSE(info["contentHash"].get<std::string>().empty());
    EXPECT_THAT(run("info s.zarr").out, HasSubstr("40 x 33 x 24 voxels"));
}

TEST_F(Program, RenderRefusesBadOptionsBeforeItWorks) {
    makeSphere();
    const std::string render = "render s.zarr -o a.png ";
    expectRefused("render s.zarr -o a.jpg", {"a.jpg", ".png"});
    expectRefused("render s.zarr -o none/a.png", {"none/a.png"});
    fs::create_directory(folder_ / "folder.png");
    expectRefused("render s.zarr -o folder.png", {"folder.png", "a folder"});
    expectRefused(render + "--preset bonne", {"--preset", "nearest: \"bone\""});
    expectRefused(render + "--engine mirro", {"--engine", "nearest: \"mirror\""});
    expectRefused(render + "--view sideways", {"--view", "anterior"});
    expectRefused(render + "--projection isometric", {"--projection"});
    expectRefused(render + "--background blueish", {"--background", "#rrggbb"});
    expectRefused(render + "--fetch soft", {"--fetch"});
    expectRefused(render + "--step 0.001", {"--step"});
    expectRefused(render + "--step x", {"--step"});
    expectRefused(render + "--size 512", {"--size"});
    expectRefused(render + "--gpu-memory 12parsec", {"--gpu-memory", "12parsec"});
    expectRefused(render + "--ram 0", {"--ram"});
    expectRefused(render + "--engine mirror --ram 64KiB", {"--ram"}); // below the scene's floor
    EXPECT_FALSE(exists("a.png"));
}

TEST_F(Program, ScenesAreReadStrictly) {
    makeSphere();
    const std::string start = R"({"tesseraScene":1,"volumes":[{"path":"s.zarr","transferFunction":"auto"}])";
    const auto refused = [&](const std::string& rest, const std::vector<std::string>& words) {
        write("scene.json", start + rest + "}");
        expectRefused("render scene.json -o a.png", words);
    };
    refused(R"(,"camera":{"vieww":"left"})", {"scene.json", "$.camera", "nearest: \"view\""});
    refused(R"(,"shading":{"ambient":"much"})", {"$.shading.ambient", "much"});
    refused(R"(,"image":{"size":[1,2,3]})", {"$.image.size"});
    write("scene.json", "{");
    expectRefused("render scene.json -o a.png", {"scene.json", "JSON"});
    write("scene.json", R"({"tesseraScene":1,"volumes":[{"path":"none.zarr"}]})");
    expectRefused("render scene.json -o a.png", {"none.zarr"});
    EXPECT_FALSE(exists("a.png"));
}

TEST_F(Program, APictureIsWrittenWithoutAWordWhenQuietAndCarriesItsManifest) {
    makeSphere();
    write("scene.json", R"({"tesseraScene":1,"volumes":[{"path":"s.zarr","transferFunction":"auto"}],
                            "image":{"size":[48,32]}})");
    const Outcome outcome = run("render scene.json -o a.exr --engine mirror --json --quiet");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.problems;
    EXPECT_EQ(outcome.problems, "");
    const json manifest = json::parse(outcome.out);
    EXPECT_EQ(manifest["notice"], "not for diagnosis");
    EXPECT_EQ(manifest["engine"], "mirror");
    EXPECT_EQ(manifest["blank"], false);
    EXPECT_EQ(manifest["scene"]["image"]["size"], json({48, 32}));
    const std::string hash = json::parse(run("info s.zarr --json").out)["contentHash"];
    EXPECT_EQ(manifest["store"]["contentHash"], hash);
    EXPECT_LE(manifest["budgets"]["ram"]["peakBytes"], manifest["budgets"]["ram"]["limitBytes"]);
    // No path of this machine is inside the picture.
    const std::string picture = readAll(folder_ / "a.exr");
    EXPECT_THAT(picture, HasSubstr("not for diagnosis"));
    EXPECT_THAT(picture, Not(HasSubstr(folder_.path().filename().string())));
}

TEST_F(Program, ABlankPictureSaysWhyAndWhatToTry) {
    makeSphere();
    write("scene.json", R"({"tesseraScene":1,"image":{"size":[16,16]},"volumes":[{"path":"s.zarr",
        "transferFunction":{"scalarOpacity":[[1e8,0],[2e8,1]]}}]})");
    const Outcome nothing = run("render scene.json -o a.png --engine mirror -q");
    EXPECT_EQ(nothing.exitCode, 0);
    EXPECT_THAT(nothing.problems,
                AllOf(HasSubstr("blank"), HasSubstr("--preset auto"), HasSubstr("go from")));
    EXPECT_THAT(run("render scene.json -o a.png --engine mirror -q --preset auto").problems, "");
    write("scene.json", R"({"tesseraScene":1,"image":{"size":[16,16]},"volumes":[{"path":"s.zarr",
        "transferFunction":"auto"}],"camera":{"position":[0,-9000,0],"focalPoint":[0,-9999,0]}})");
    EXPECT_THAT(run("render scene.json -o a.png --engine mirror -q").problems, HasSubstr("--view anterior"));
}

#if TESSERA_WITH_IMPORT
TEST_F(Program, SourceFilesAreImportedOnceAndThenReused) {
    std::string voxels(20 * 10 * 8 * 2, '\0');
    for (std::size_t i = 0; i < voxels.size(); i += 2)
        voxels[i] = static_cast<char>(i / 37 % 120);
    write("v.raw", voxels);
    write("v.json", R"({"data":"v.raw","extent":[20,10,8],"type":"int16","spacing":[1,1,2]})");
    const std::string render = "render v.json -o a.png --engine mirror --size 16x16 ";
    const Outcome first = run(render), second = run(render + "-v");
    ASSERT_EQ(first.exitCode, 0) << first.problems;
    EXPECT_THAT(first.problems, HasSubstr("with sidecar"));
    EXPECT_THAT(second.problems, AllOf(HasSubstr("reusing"), Not(HasSubstr("with sidecar"))));
    EXPECT_EQ(run("import v.json v.zarr").exitCode, 0);
    expectRefused("import v.json v.zarr", {"v.zarr", "--force"});
    EXPECT_EQ(run("info v.json").exitCode, 0);
}
#endif

} // namespace
} // namespace tessera::test
