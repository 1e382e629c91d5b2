// tests/program/file_part_test.cpp: a level of a file, and a box of it, as the volume, from outside: what
// info lists, what pictures say, that imports do not mix, scenes, labels, and files that the cache has no
// room for.
#include "core/image/image_file.h" // readManifest
#include "tests/support/program_fixture.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class FilePart : public Program {
  protected:
    /// An image of OME-Zarr 0.4 with levels of 16, 8 and 4 voxels along each axis.
    void SetUp() override {
        fs::create_directories(folder_ / "a.zarr");
        write("a.zarr/.zgroup", R"({"zarr_format":2})");
        json datasets = json::array(), axes = json::array();
        for (const char* const axis : {"z", "y", "x"})
            axes.push_back({{"name", axis}, {"type", "space"}, {"unit", "millimeter"}});
        for (int level = 0; level < 3; ++level) {
            const int side = 16 >> level;
            const double mm = 1 << level, first = (mm - 1) / 2;
            const std::string name = std::to_string(level);
            datasets.push_back({{"path", name},
                                {"coordinateTransformations",
                                 {{{"type", "scale"}, {"scale", {mm, mm, mm}}},
                                  {{"type", "translation"}, {"translation", {first, first, first}}}}}});
            fs::create_directories(folder_ / "a.zarr" / name);
            const json array = {
                {"zarr_format", 2}, {"shape", {side, side, side}}, {"chunks", {side, side, side}},
                {"dtype", "|u1"},   {"compressor", nullptr},       {"fill_value", 0},
                {"order", "C"},     {"filters", nullptr}};
            write("a.zarr/" + name + "/.zarray", array.dump());
            std::string voxels;
            for (int n = 0; n < side * side * side; ++n)
                voxels += static_cast<char>(n * 37 % 199 + level);
            write("a.zarr/" + name + "/0.0.0", voxels);
        }
        write("a.zarr/.zattrs",
              json({{"multiscales", {{{"version", "0.4"}, {"axes", axes}, {"datasets", datasets}}}}}).dump());
    }
    /// A picture's record of its volume.
    json drawn(const std::string& what) {
        const Outcome outcome = run("render " + what + " --engine mirror --size 16x16 -o a.png");
        EXPECT_EQ(outcome.exitCode, 0) << what << outcome.problems;
        problems_ = outcome.problems;
        return json::parse(readManifest(folder_ / "a.png"))["store"];
    }
    std::string problems_;
};

TEST_F(FilePart, PicturesSayWhichPartTheyAreOf) {
    EXPECT_FALSE(drawn("a.zarr").contains("filePart"));
    const json level = drawn("a.zarr --file-level 1");
    EXPECT_EQ(level["extentVoxels"], json({8, 8, 8}));
    EXPECT_EQ(level["filePart"]["fileLevel"], 1);
    EXPECT_EQ(level["filePart"]["finestVoxels"], json({16, 16, 16}));
    const Outcome told = run("info a.png");
    EXPECT_THAT(told.out,
                AllOf(HasSubstr("file level:    1 (0 is the finest), 8 x 8 x 8 voxels of 16 x 16 x 16"),
                      HasSubstr("errors are against this level")));
    const json box = drawn("a.zarr --file-level 1 --file-box 1,5,0,8,2,7");
    EXPECT_EQ(box["extentVoxels"], json({4, 8, 5}));
    EXPECT_EQ(box["filePart"]["fileBox"], json({1, 5, 0, 8, 2, 7}));
    const json other = drawn("a.zarr --file-level 1 --file-box 2,6,0,8,2,7");
    EXPECT_NE(box["contentHash"], other["contentHash"]) << "imports do not mix";
    EXPECT_EQ(drawn("a.zarr --file-level 1 --file-box 1,5,0,8,2,7"), box);
}

TEST_F(FilePart, ScenesNameItByTheSameWords) {
    write("s.json", R"({"tesseraScene":1,"volumes":[{"path":"a.zarr","fileLevel":1,"fileBox":[1,5,0,8,2,7],
                        "transferFunction":"auto"}]})");
    EXPECT_EQ(drawn("s.json"), drawn("a.zarr --preset auto --file-level 1 --file-box 1,5,0,8,2,7"));
    EXPECT_EQ(drawn("s.json --set volumes[0].fileBox=0,4,0,4,0,4")["extentVoxels"], json({4, 4, 4}));
    expectRefused("render s.json -o a.png --set volumes[0].fileBox=[3,3,0,1,0,1]", {"fileBox"});
    expectRefused("render s.json -o a.png --set volumes[0].fileLevel=-1", {"fileLevel"});
}

TEST_F(FilePart, InfoListsTheLevels) {
    EXPECT_THAT(run("info a.zarr").out,
                AllOf(HasSubstr("level 0:       16 x 16 x 16 voxels of 1 x 1 x 1 mm, 4 KiB decoded"),
                      HasSubstr("level 2:       4 x 4 x 4 voxels of 4 x 4 x 4 mm, 64 B decoded")));
    const json levels = json::parse(run("info a.zarr --json").out)["volumes"][0]["levels"];
    ASSERT_EQ(levels.size(), 3u);
    EXPECT_EQ(levels[1]["extentVoxels"], json({8, 8, 8}));
    EXPECT_EQ(levels[1]["spacingMm"], json({2.0, 2.0, 2.0}));
    EXPECT_EQ(levels[1]["decodedBytes"], 512);
}

TEST_F(FilePart, WhatTheCacheHasNoRoomForIsTakenCoarser) {
    ASSERT_EQ(::setenv("TESSERA_CACHE_SIZE", "1KiB", 1), 0);
    EXPECT_EQ(drawn("a.zarr")["filePart"]["fileLevel"], 1);
    EXPECT_THAT(problems_,
                AllOf(HasSubstr("16 x 16 x 16"), HasSubstr("8 x 8 x 8"), HasSubstr("level 1 is taken")));
    EXPECT_FALSE(drawn("a.zarr --file-level 0").contains("filePart"));
    EXPECT_EQ(drawn("a.zarr --file-box 0,2,0,2,0,2")["filePart"]["fileLevel"], 0);
    EXPECT_EQ(run("import a.zarr whole.zarr").exitCode, 0);
    EXPECT_THAT(run("info whole.zarr").out, Not(HasSubstr("part:")));
    EXPECT_EQ(run("import a.zarr part.zarr --file-level auto").exitCode, 0);
    EXPECT_THAT(run("info part.zarr").out, HasSubstr("part:          level 1 of its file, 8 x 8 x 8 voxels"));
    ::unsetenv("TESSERA_CACHE_SIZE");
    EXPECT_FALSE(drawn("a.zarr").contains("filePart")) << "there is room";
}

TEST_F(FilePart, WhatIsNoPartIsRefused) {
    const std::string render = "render a.zarr -o a.png ";
    expectRefused(render + "--file-level 3", {"a.zarr", "--file-level from 0 (finest) to 2"});
    expectRefused(render + "--file-level fine", {"--file-level", "auto"});
    expectRefused(render + "--file-level auto --file-box 0,1,0,1,0,1", {"--file-level", "a number"});
    expectRefused(render + "--file-level 1 --file-box 0,9,0,8,0,8", {"a.zarr", "0,8,0,8,0,8"});
    expectRefused(render + "--file-box 0,1,0,1,0", {"--file-box", "X0,X1,Y0,Y1,Z0,Z1"});
    makeSphere();
    expectRefused("render s.zarr -o a.png --file-level 1", {"s.zarr", "--file-level", "a store"});
    expectRefused("render s.zarr -o a.png --file-box 0,1,0,1,0,1", {"s.zarr", "--file-box", "a store"});
}

TEST_F(FilePart, LabelsOfTheWholeLieBesideABox) {
    const auto nrrd = [&](const std::string& name, int shift, const std::string& voxels) {
        write(name, "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 12 12\n"
                    "space directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\nencoding: raw\n"
                    "space origin: (" +
                        std::to_string(shift) + ",0,0)\n\n" + voxels);
    };
    std::string scan, labels;
    for (int n = 0; n < 12 * 12 * 12; ++n) {
        scan += static_cast<char>(n * 37 % 199);
        labels += static_cast<char>(n % 12 < 6 ? 1 : 2); // x below 6, and above
    }
    nrrd("scan.nrrd", 0, scan);
    nrrd("labels.nrrd", 0, labels);
    nrrd("beside.nrrd", 100, labels);
    const auto exported = [&](const std::string& box) {
        const Outcome outcome =
            run("export scan.nrrd o.nrrd --force --file-box " + box + " --labels labels.nrrd");
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        const std::string text = readAll(folder_ / "o.nrrd");
        return text.substr(text.find("\n\n") + 2);
    };
    const std::string found = exported("4,8,0,2,0,2");
    ASSERT_GE(found.size(), 4u);
    EXPECT_EQ(found[0] == found[1] && found[2] == found[3] && found[1] != found[2], true);
    EXPECT_EQ(found[0], exported("0,1,0,1,0,1")[0]);
    expectRefused("export scan.nrrd o.nrrd --force --file-box 4,8,0,2,0,2 --labels beside.nrrd",
                  {"beside.nrrd"});
}

} // namespace
} // namespace tessera::test
