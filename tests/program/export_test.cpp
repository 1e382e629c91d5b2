// tests/program/export_test.cpp: `tessera export` from outside: what it refuses, that files appear whole or
// not at all, and that an exported volume is drawn as its source is.
#include "tests/support/program_fixture.h"

#include <fcntl.h>
#include <sys/resource.h>

namespace tessera::test {
namespace {

using ::testing::HasSubstr;

class ExportProgram : public Program {
  protected:
    void SetUp() override { makeSphere(); }
    /// Names in the folder, hidden ones too.
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const auto& entry : fs::directory_iterator(folder_.path()))
            if (const std::string name = entry.path().filename(); name != ".err" && name != ".out")
                all.push_back(name);
        std::sort(all.begin(), all.end());
        return all;
    }
    /// With a limit to the size of files: a full disk.
    int runWithin(rlim_t bytes, const std::string& arguments) {
        const pid_t child = ::fork();
        if (child == 0) {
            const rlimit limit{bytes, bytes};
            ::setrlimit(RLIMIT_FSIZE, &limit);
            std::vector<std::string> words = {"tessera"};
            std::istringstream text(arguments);
            for (std::string word; text >> word;)
                words.push_back(word);
            ::_exit(runInChild(words));
        }
        int status = 0;
        ::waitpid(child, &status, 0);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
};

TEST_F(ExportProgram, WhatCannotBeDoneIsRefusedInALine) {
    expectRefused("export s.zarr a.nrrd --level 6", {"--level", "0 (finest) to 5", "6"});
    expectRefused("export s.zarr a.nrrd --crop-voxels 5,5,5,9,5,9",
                  {"--crop-voxels", "below its upper end", "5 to 5"});
    expectRefused("export s.zarr a.nrrd --crop-voxels 50,60,5,9,5,9", {"--crop-voxels", "0,40,0,33,0,24"});
    expectRefused("export s.zarr a.nrrd --crop-voxels 1,2,3", {"--crop-voxels", "X0,X1,Y0,Y1,Z0,Z1"});
    expectRefused("export s.zarr a.nrrd --crop 9000,9001,0,1,0,1", {"--crop"});
    expectRefused("export s.zarr a.nrrd --crop 5,4,0,1,0,1", {"--crop"});
    expectRefused("export s.zarr a.nrrd --unit SUVbw", {"--unit", "HU"});
    expectRefused("export s.zarr a.nrrd --crop-voxels 0,1,0,1,0,1 --crop body", {"--crop", "--crop-voxels"});
    expectRefused("export s.zarr a.xyz", {"a.xyz", ".nii.gz", "--format"});
    expectRefused("export s.zarr a.nrrd --format nrd", {"--format", "nearest: \"nrrd\""});
    expectRefused("export s.zarr a.nii --compress", {"a.nii", ".nii.gz"});
    expectRefused("export s.zarr none/a.nrrd", {"none/a.nrrd", "an existing folder"});
    expectRefused("export nothing.zarr a.nrrd", {"nothing.zarr"});
    // Before anything is opened, or imported for long.
    expectRefused("export nothing.zarr a.nrrd --crop 1,2", {"--crop: expected body or X0,X1,Y0,Y1,Z0,Z1"});
    expectRefused("export nothing.zarr a.nrrd --crop-voxels a", {"--crop-voxels: expected X0,X1"});
    EXPECT_EQ(names(), std::vector<std::string>{"s.zarr"});
}

TEST_F(ExportProgram, AFileIsReplacedByForceAlone) {
    for (const char* file : {"a.nrrd", "a.nii.gz", "a.vti", "a.tif"}) {
        write(file, "old");
        expectRefused(std::string("export s.zarr ") + file, {file, "--force"});
        EXPECT_EQ(readAll(folder_ / file), "old");
        const Outcome outcome = run(std::string("export --force s.zarr ") + file);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        EXPECT_THAT(outcome.problems, HasSubstr("wrote " + std::string(file) + ": 40 x 33 x 24 voxels of "));
        EXPECT_THAT(outcome.problems, HasSubstr("level 0"));
        EXPECT_GT(fs::file_size(folder_ / file), 1000u);
    }
    expectRefused("export s.zarr s.zarr", {"s.zarr", "--force"});
}

TEST_F(ExportProgram, AFullDiskLeavesWhatWasThere) {
    std::vector<std::string> files = {"a.nrrd", "a.nii.gz", "a.vti", "a.tif"};
#if TESSERA_WITH_VDB
    files.emplace_back("a.vdb");
#endif
    for (const std::string& file : files) {
        ASSERT_EQ(run("export -q s.zarr " + file).exitCode, 0);
        const auto size = static_cast<rlim_t>(fs::file_size(folder_ / file));
        write(file, "old");
        const std::vector<std::string> before = names();
        for (const rlim_t bytes : {rlim_t{0}, rlim_t{100}, size / 2, size - 1}) {
            EXPECT_EQ(runWithin(bytes, "export -q --force s.zarr " + file), 1) << file << bytes;
            EXPECT_THAT(readAll(folder_ / ".err"), ::testing::AnyOf("", HasSubstr(file))) << file << bytes;
            EXPECT_EQ(readAll(folder_ / file), "old") << file << bytes;
            EXPECT_EQ(names(), before) << file << bytes;
        }
        EXPECT_EQ(runWithin(size, "export -q --force s.zarr " + file), 0) << file;
    }
}

#if TESSERA_WITH_IMPORT
// Values, place and unit are those of the source, so every pixel is. Tilted axes, and HU by a slope.
TEST_F(ExportProgram, APictureOfTheFileIsThatOfTheSource) {
    std::string voxels;
    for (int z = 0; z < 40; ++z)
        for (int y = 0; y < 37; ++y)
            for (int x = 0; x < 45; ++x)
                voxels += static_cast<char>((x * x + 2 * y * z + (x > y ? 90 : 0)) % 200);
    write("v.raw", voxels);
    write(
        "v.json",
        R"({"data":"v.raw","type":"uint8","extent":[45,37,40],"spacing":[0.7,0.8,1.3],)"
        R"("direction":[0.8,0.6,0,-0.6,0.8,0,0,0,1],"rescaleSlope":4,"rescaleIntercept":-100,"unit":"HU"})");
    const std::string render = " --engine mirror --size 40x40 --step 1 --preset soft-tissue -q -o ";
    ASSERT_EQ(run("render v.json" + render + "source.png").exitCode, 0) << readAll(folder_ / ".err");
    const auto pixels = [&](const std::string& name) {
        const std::string png = readAll(folder_ / name);
        return png.substr(std::min(png.size(), png.find("IDAT")));
    };
    for (const std::string file : {"a.nrrd", "w.zarr"}) {
        ASSERT_EQ(run("export -q v.json " + file).exitCode, 0) << readAll(folder_ / ".err");
        ASSERT_EQ(run("render " + file + render + file + ".png").exitCode, 0) << readAll(folder_ / ".err");
        EXPECT_EQ(pixels(file + ".png"), pixels("source.png")) << file;
    }
}
#endif

} // namespace
} // namespace tessera::test
