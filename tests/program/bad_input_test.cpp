// tests/program/bad_input_test.cpp: bad input from outside: each kind has its own message, one line, exit
// code 2, and leaves nothing behind. Files are generated.
#include "tests/support/program_fixture.h"
#if TESSERA_WITH_IMPORT
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"
#endif

#include "core/base/budget.h"

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class BadInput : public Program {
  protected:
    /// import, info and render refuse, and no store or picture appears.
    void expectRefusedByAll(const std::string& input, const std::vector<std::string>& words) {
        expectRefused("import " + input + " out.zarr", words);
        expectRefused("render " + input + " -o out.png --engine mirror", words);
        EXPECT_FALSE(exists("out.zarr"));
        EXPECT_FALSE(exists("out.png"));
    }
};

TEST_F(BadInput, AFlippedBitIsFoundAndTheChunkNamed) {
    makeSphere();
    const fs::path shard = folder_ / "s.zarr/0/c/0/0/0";
    ASSERT_TRUE(fs::exists(shard));
    std::string bytes = readAll(shard);
    bytes[bytes.size() / 3] = static_cast<char>(bytes[bytes.size() / 3] ^ 0x10);
    std::ofstream(shard, std::ios::binary) << bytes;
    const std::string render = "render s.zarr -o a.png --preset auto --no-skipping --engine ";
    for (const char* engine : {"mirror", "reference", "march --gl-device software"})
        expectRefused(render + engine, {"s.zarr/0/c/0/0/0", "chunk"});
    EXPECT_FALSE(exists("a.png"));
    bytes.resize(40);
    std::ofstream(shard, std::ios::binary) << bytes;
    expectRefused(render + "mirror", {"s.zarr/0/c/0/0/0", "cut short"});
    fs::remove(shard);
    expectRefused(render + "mirror", {"s.zarr/0/c/0/0/0", "no such file"});
    const std::string text = readAll(folder_ / "s.zarr/zarr.json");
    for (const std::size_t at : {std::size_t{0}, text.find("rescaleSlope") + 3, text.size() / 2}) {
        std::string changed = text;
        changed[at] = static_cast<char>(changed[at] ^ 1);
        write("s.zarr/zarr.json", changed);
        expectRefused(render + "mirror", {"s.zarr/zarr.json"});
        expectRefused("info s.zarr", {"s.zarr/zarr.json"});
    }
}

TEST_F(BadInput, ABudgetBelowTheFloorSaysWhatTheFloorIs) {
    makeSphere();
    const auto floorOf = [&](const std::string& arguments, const std::string& option) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exitCode, 2) << outcome.problems;
        EXPECT_THAT(outcome.problems, HasSubstr(option));
        std::istringstream words(outcome.problems.substr(outcome.problems.find("at least ") + 9));
        std::string number, unit;
        words >> number >> unit;
        unit.erase(std::remove(unit.begin(), unit.end(), ','), unit.end());
        return number + unit;
    };
    const std::string render = "render s.zarr -q -o a.png --preset auto --size 40x40 ";
    for (const char* engine : {"--engine mirror", "--engine reference", "--gl-device software"}) {
        std::string floor;
        for (const char* small : {"1", "64KiB", "1MiB"}) // also where not even the store could be read
            floor = floorOf(render + engine + " --ram " + small, "--ram");
        const Outcome enough = run(render + engine + " --ram " + floor);
        EXPECT_EQ(enough.exitCode, 0) << floor << ": " << enough.problems;
    }
    const std::string gpuFloor = floorOf(render + "--gl-device software --gpu-memory 1KiB", "--gpu-memory");
    EXPECT_EQ(run(render + "--gl-device software --gpu-memory " + gpuFloor).exitCode, 0) << gpuFloor;
}

TEST_F(BadInput, ScenesAndStoresThatAreNone) {
    write("scene.json", R"({"tesseraScene":1,"volumes":[{"path":"s.zarr"}],"colour":"red"})");
    expectRefused("render scene.json -o a.png", {"scene.json", "$", "colour"});
    fs::create_directories(folder_ / "foreign.zarr");
    write("foreign.zarr/zarr.json", R"({"zarr_format":3,"node_type":"group","attributes":{}})");
    expectRefused("render foreign.zarr -o a.png", {"foreign.zarr/zarr.json"});
    expectRefused("info foreign.zarr", {"foreign.zarr/zarr.json"});
    makeSphere();
    expectRefused("import s.zarr out.zarr", {"s.zarr", "used as it is"});
    EXPECT_FALSE(exists("out.zarr"));
    EXPECT_FALSE(exists("a.png"));
}

#if TESSERA_WITH_IMPORT
TEST_F(BadInput, TruncatedNifti) {
    NiftiImage image;
    image.extent = {20, 18, 16};
    image.voxels.assign(20 * 18 * 16 * 2, 'x');
    const std::string whole = niftiBytes(image), packed = gzip(whole);
    write("whole.nii", whole);
    EXPECT_EQ(run("import whole.nii whole.zarr").exitCode, 0);
    for (const std::size_t bytes : {std::size_t{0}, std::size_t{100}, std::size_t{348}, std::size_t{352},
                                    whole.size() / 2, whole.size() - 1}) {
        write("cut.nii", whole.substr(0, bytes));
        expectRefusedByAll("cut.nii", {"cut.nii", "expected", "found"});
    }
    for (const std::size_t bytes : {packed.size() / 2, packed.size() - 1}) {
        write("cut.nii.gz", packed.substr(0, bytes));
        expectRefusedByAll("cut.nii.gz", {"cut.nii.gz", "expected", "found"});
    }
}

TEST_F(BadInput, ASidecarThatLies) {
    write("v.raw", std::string(20 * 10 * 8 * 2, 'x'));
    const auto sidecar = [&](const std::string& extent, const std::string& type) {
        write("v.json",
              R"({"data":"v.raw","extent":[)" + extent + R"(],"type":")" + type + R"(","spacing":[1,1,2]})");
    };
    for (const char* extent : {"20,10,9", "20,10,7", "2000000,2000000,2000000"}) {
        sidecar(extent, "int16");
        expectRefusedByAll("v.json", {"v.", "expected", "found"});
    }
    sidecar("20,10,8", "int32");
    expectRefusedByAll("v.json", {"v.raw", "6400", "3200"});
    sidecar("20,10,8", "word");
    expectRefusedByAll("v.json", {"v.json", "\"type\""});
    sidecar("20,10,0", "int16");
    expectRefusedByAll("v.json", {"v.json", "\"extent\""});
}

TEST_F(BadInput, DicomFoldersThatAreNoVolume) {
    const auto slice = [&](const std::string& name, double z, const std::string& series = "1") {
        DicomImage image;
        image.columns = 8;
        image.rows = 8;
        image.pixels.assign(64, 1024);
        image.position = glm::dvec3(0, 0, z);
        image.series = series;
        fs::create_directories((folder_ / name).parent_path());
        writeDicom(folder_ / name, image);
    };
    for (int z = 0; z < 5; ++z) {
        slice("two/a" + std::to_string(z), z);
        slice("two/b" + std::to_string(z), 2 * z, "2");
        slice("uneven/" + std::to_string(z), z == 4 ? 4.5 : z);
        slice("missing/" + std::to_string(z), z >= 3 ? z + 2 : z);
    }
    for (const char* command : {"import two out.zarr", "render two -o out.png --engine mirror"})
        expectRefusedWithTable(command, {"two: expected", "--series", "\n  1       2023-05-17  CT        5",
                                         "\n  2       2023-05-17  CT"});
    EXPECT_FALSE(exists("out.zarr") || exists("out.png"));
    EXPECT_EQ(run("import two chosen.zarr --series 2").exitCode, 0);
    expectRefusedWithTable("import two out.zarr --series 3", {"--series between 1 and 2"});
    expectRefusedByAll("uneven", {"uneven", "--resample-z"});
    EXPECT_EQ(run("import uneven even.zarr --resample-z").exitCode, 0);
    expectRefusedByAll("missing", {"missing", "--resample-z"});
}
#endif

} // namespace
} // namespace tessera::test
