// tests/program/folders_test.cpp: folders as they come, through the program: what import, info and render say
// about them, and to whom.
#include "tests/support/dicom_writer.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/program_fixture.h"

#include "core/image/image_file.h" // readManifest

#include <iterator>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Folders : public Program {
  protected:
    void slice(const std::string& name, double z, const std::function<void(DicomImage&)>& change = {}) {
        DicomImage image;
        image.columns = image.rows = 12;
        image.spacingX = image.spacingY = 1;
        image.pixels.assign(144, 1024);
        for (std::size_t i = 50; i < 94; ++i)
            image.pixels[i] = 2000;
        image.position = glm::dvec3(0, 0, z);
        if (change)
            change(image);
        fs::create_directories((folder_ / name).parent_path());
        writeDicom(folder_ / name, image);
    }
    void series(const std::string& folder, const std::function<void(DicomImage&)>& change = {}) {
        for (int n = 1; n <= 4; ++n)
            slice(folder + "/IM000" + std::to_string(n), 2 * n, change);
    }
};

TEST_F(Folders, WhatWasPassedOverIsSaidAtImportAndInInfo) {
    series("scan");
    slice("scan/scout", 0, [](DicomImage& image) {
        image.series = "2";
        image.imageType = "ORIGINAL\\PRIMARY\\LOCALIZER";
    });
    slice("scan/dose", 0, [](DicomImage& image) {
        image.series = "3";
        image.modality = "SR";
        image.withPixels = false;
        image.storageClass = "1.2.840.10008.5.1.4.1.1.88.67";
    });
    write("scan/notes.bin", "notes");
    write("scan/.DS_Store", "");
    const Outcome import = run("import scan a.zarr");
    ASSERT_EQ(import.exitCode, 0) << import.problems;
    EXPECT_THAT(import.problems,
                AllOf(HasSubstr("took series 1; passed over: series"), HasSubstr("(CT, 1 slice: scout)"),
                      HasSubstr("1 file of another kind (.DS_Store)"), HasSubstr("1 not DICOM (notes.bin)"),
                      HasSubstr("1 dose report")));
    EXPECT_EQ(run("import scan b.zarr -q").problems, "");
    EXPECT_EQ(run("render scan -q --engine mirror --preset bone --size 16x16 -o a.png").exitCode, 0);
    const Outcome info = run("info scan");
    EXPECT_EQ(info.exitCode, 0);
    EXPECT_THAT(info.out, AllOf(HasSubstr("passed over:"), HasSubstr("1 not DICOM (notes.bin)"),
                                HasSubstr("  series  date        modality  slices"),
                                HasSubstr("place:         x -0.5 to 11.5, y -0.5 to 11.5, z 1 to 9 mm"),
                                HasSubstr("field of view: 12 x 12 x 8 mm"), Not(HasSubstr("body"))));
    const auto json = nlohmann::json::parse(run("info scan --json").out);
    EXPECT_EQ(json["passedOver"], (nlohmann::json{{"notSlice", 1}, {"notDicom", 1}, {"notImage", 1}}));
    EXPECT_EQ(json["series"].size(), 3u);
    EXPECT_EQ(json["volumes"][0]["gantryTiltDegrees"], 0);
    EXPECT_EQ(json["volumes"][0]["fieldOfViewMm"], (nlohmann::json{12, 12, 8}));
    // A whole folder without anything else says nothing about it.
    series("plain");
    EXPECT_THAT(run("import plain c.zarr").problems, Not(HasSubstr("passed over")));
}

TEST_F(Folders, ALostSliceStopsImportAndRenderAndIsToldByInfo) {
    series("scan");
    write("scan/IM0004", "");
    for (const char* command : {"import scan a.zarr", "render scan -o a.png --engine mirror"})
        expectRefused(command, {"scan/IM0004", "empty", "--allow-missing"});
    EXPECT_FALSE(exists("a.zarr") || exists("a.png"));
    EXPECT_THAT(run("info scan").out, HasSubstr("incomplete: 1 file could be slices"));
    EXPECT_THAT(run("info scan --allow-missing").out, HasSubstr("1 file left out"));
    const Outcome import = run("import scan a.zarr --allow-missing");
    EXPECT_EQ(import.exitCode, 0) << import.problems;
    EXPECT_THAT(import.problems, AllOf(HasSubstr("1 empty (IM0004)"), HasSubstr("1 file left out")));
    const std::string render = "render scan -q --engine mirror --preset bone --size 16x16 -o a.png";
    EXPECT_EQ(run(render + " --allow-missing").exitCode, 0);
    expectRefused(render, {"IM0004"}); // the import that leaves it out is not taken for the whole one
}

TEST_F(Folders, PhasesAreChosenByNumberAndTheCacheKeepsThemApart) {
    series("scan", [](DicomImage& image) { image.temporalPosition = 1; });
    for (int n = 1; n <= 4; ++n)
        slice("scan/late" + std::to_string(n), 2 * n, [](DicomImage& image) {
            image.temporalPosition = 2;
            image.pixels.assign(144, 1500);
        });
    expectRefused("import scan a.zarr", {"--phase N", "1: time 1, 2: time 2"});
    EXPECT_THAT(run("info scan").out, HasSubstr("2 phases for --phase (1: time 1, 2: time 2)"));
    EXPECT_EQ(run("import scan a.zarr --phase 2").exitCode, 0);
    EXPECT_THAT(run("info a.zarr").out, HasSubstr("476 to 476 HU"));
    const std::string render =
        "render scan --engine mirror --preset bone --size 16x16 -o a.png --json --phase ";
    const auto hash = [&](const char* phase) {
        const Outcome outcome = run(render + phase);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        return nlohmann::json::parse(outcome.out)["store"].dump();
    };
    EXPECT_NE(hash("1"), hash("2"));
}

TEST_F(Folders, AScoutAndASliceExplainThemselvesInsteadOfABlankPicture) {
    slice("scout/a", 0, [](DicomImage& image) { image.imageType = "ORIGINAL\\PRIMARY\\LOCALIZER"; });
    expectRefusedWithTable("render scout -o a.png --engine mirror", {"a scout (localizer)", "--series 1"});
    series("scan");
    const std::string render = "render scan/IM0002 --engine mirror --preset bone --size 16x16 -o a.png";
    expectRefused(render + " -q --view left", {"one slice", "--view superior"});
    EXPECT_FALSE(exists("a.png"));
    const Outcome shown = run(render);
    EXPECT_EQ(shown.exitCode, 0) << shown.problems;
    EXPECT_THAT(shown.problems, HasSubstr("one slice: shown as --slice axial"));
    const std::string asShown = readAll(folder_ / "a.png");
    EXPECT_EQ(run(render + " --slice axial").exitCode, 0);
    EXPECT_EQ(readAll(folder_ / "a.png"), asShown);
    EXPECT_EQ(run(render + " --view superior").exitCode, 0);
    EXPECT_EQ(run(render + " --mm-per-pixel 0.5").exitCode, 0) << "a slice has one scale";
    EXPECT_EQ(run(render + " --mode maximum -q").exitCode, 0) << "from the side that it faces";
    EXPECT_THAT(run("import scan/IM0002 one.zarr").problems,
                AllOf(HasSubstr("one slice only"), HasSubstr("name the folder")));
    for (const char* options : {" --window abdomen", " --window 40,300 --value-colour inverse",
                                " --slab 2:maximum", " --value-colour transferFunction"})
        for (const char* name : {"scan/IM0002", "one.zarr"}) { // it takes the options of slices
            const std::string one = std::string("render ") + name + " --engine mirror --size 16x16 -q -o ";
            EXPECT_EQ(run(one + "d.exr" + options).exitCode, 0) << options;
            EXPECT_EQ(run(one + "e.exr --slice axial" + options).exitCode, 0) << options;
            EXPECT_EQ(readAll(folder_ / "d.exr"), readAll(folder_ / "e.exr")) << options;
            expectRefused(one + "f.exr --view superior" + options, {"found mode composite"});
            expectRefused(one + "f.exr --projection parallel" + options, {"found mode composite"});
        }
    const auto imports = [&] {
        const fs::directory_iterator all(folder_ / "cache" / "tessera");
        return std::distance(begin(all), end(all));
    };
    const auto before = imports();
    for (const char* option : {"--window abdomen", "--value-colour inverse", "--slab 2"})
        expectRefused(std::string("render scan -q -o f.exr ") + option, {"found mode composite"});
    EXPECT_EQ(imports(), before) << "refused by the headers";
    EXPECT_EQ(run("render one.zarr -q --engine mirror --size 16x16 -o b.png").exitCode, 0);
    slice("lone/IM0002", 0); // a folder that holds no more
    const Outcome lone = run("render lone --engine mirror --size 16x16 -o c.png");
    EXPECT_EQ(lone.exitCode, 0) << lone.problems;
    EXPECT_THAT(lone.problems, Not(HasSubstr("name the folder")));
}

TEST_F(Folders, TheTableTellsWhatPeopleChooseBy) {
    series("study/arterial",
           [](DicomImage& image) { image.seriesNumber = "5", image.seriesDate = "20230518"; });
    series("study/venous", [](DicomImage& image) {
        image.series = "2", image.seriesNumber = "7", image.seriesDate = "20230519";
        image.columns = 6, image.rows = 24;
    });
    slice("study/scout", 0, [](DicomImage& image) {
        image.series = "3", image.imageType = "LOCALIZER", image.seriesNumber = "1";
    });
    expectRefusedWithTable("import study a.zarr", {"found 2 volumes: series 1, 3",
                                                   "  series  number  date        folder    modality",
                                                   "  1       5       2023-05-18  arterial  CT        4",
                                                   "  3       7       2023-05-19  venous    CT        4",
                                                   "  2       1       2023-05-17  -         CT        1"});
    const Outcome info = run("info study");
    const std::size_t first = info.out.find("source:        series 1"),
                      last = info.out.find("source:        series 3");
    EXPECT_LT(first, last) << "in the order of the table\n" << info.out;
    EXPECT_NE(last, std::string::npos);
    const auto json = nlohmann::json::parse(run("info study --json").out);
    EXPECT_EQ(json["series"][0]["seriesNumber"], 5);
    EXPECT_EQ(json["series"][0]["date"], "2023-05-18");
    EXPECT_EQ(json["series"][0]["folder"], "arterial");
    // None of it is kept.
    ASSERT_EQ(run("import study a.zarr --series 3").exitCode, 0);
    const std::string store = readAll(folder_ / "a.zarr/zarr.json");
    for (const char* text : {"2023", "venous", "seriesNumber"})
        EXPECT_THAT(store, Not(HasSubstr(text)));
}

TEST_F(Folders, WhatIsOddIsSaidAtImportAndStaysInTheStore) {
    for (int n = 1; n <= 6; ++n)
        slice("scan/IM000" + std::to_string(n), 10 * n, [&](DicomImage& image) {
            image.thickness = "5", image.instance = 2 * n - 1;
            image.kernel = n == 2 ? "B70f" : "B30f";
        });
    const std::string gaps = "slices are 5 mm thick and lie 10 mm apart",
                      kernel = "the kernel is B30f in 5 slices";
    for (const char* command : {"import scan a.zarr", "info scan", "info a.zarr", "info a.zarr --json"}) {
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        EXPECT_THAT(outcome.out + outcome.problems, AllOf(HasSubstr(gaps), HasSubstr(kernel))) << command;
    }
}

TEST_F(Folders, AStoreHasNothingToChoose) {
    series("scan");
    ASSERT_EQ(run("import scan a.zarr").exitCode, 0);
    const std::string render = "render a.zarr --engine mirror --preset bone --size 16x16 -o a.png ";
    expectRefused(render + "--series 2", {"a.zarr", "--series", "a store"});
    expectRefused(render + "--phase 1", {"a.zarr", "--phase", "a store"});
    EXPECT_FALSE(exists("a.png"));
    const Outcome largest = run(render + "--largest");
    EXPECT_EQ(largest.exitCode, 0);
    EXPECT_THAT(largest.problems, HasSubstr("--largest is for source files"));
}

TEST_F(Folders, ASceneSaysWhichSeriesOfItsSource) {
    series("scan");
    series("scan/other", [](DicomImage& image) { image.series = "2", image.pixels.assign(144, 1500); });
    write("s.json", R"({"tesseraScene":1,"volumes":[{"path":"scan","series":2,"transferFunction":"bone"}],
                        "image":{"size":[16,16]}})");
    const auto hash = [&](const std::string& arguments) {
        const Outcome outcome = run("render " + arguments + " --engine mirror --size 16x16 -o a.png --json");
        EXPECT_EQ(outcome.exitCode, 0) << outcome.problems;
        EXPECT_THAT(nlohmann::json::parse(readManifest(folder_ / "a.png"))["scene"].dump(),
                    Not(HasSubstr("\"series\"")));
        return nlohmann::json::parse(outcome.out)["store"].dump();
    };
    EXPECT_EQ(hash("s.json"), hash("scan --series 2 --preset bone"));
    EXPECT_NE(hash("s.json --series 1"), hash("s.json")) << "options win";
}

TEST_F(Folders, APipeIsNeverWaitedFor) {
    fs::create_directories(folder_ / "a.zarr");
    ASSERT_EQ(::mkfifo((folder_ / "a.zarr/zarr.json").c_str(), 0600), 0);
    series("scan");
    for (const char* name : {"p.json", "p.nii", "p.nii.gz", "p.dcm", "p.png"})
        ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
    const std::string render = " -q --engine mirror --size 16x16 -o out.png";
    for (const char* input : {"a.zarr", "p.json", "p.nii", "p.nii.gz", "p.dcm", "p.png"}) {
        EXPECT_EQ(run("info " + std::string(input)).exitCode, 2) << input;
        EXPECT_EQ(run("render " + std::string(input) + render).exitCode, 2) << input;
        EXPECT_EQ(run("import " + std::string(input) + " b.zarr").exitCode, 2) << input;
    }
    expectRefused("info a.zarr", {"zarr.json", "a regular file"});
    expectRefused("render scan --preset p.json" + render, {"p.json"});
    expectRefused("render scan --path p.json" + render, {"p.json", "a regular file"});
}

TEST_F(Folders, AVolumeOfLabelsIsSaidToBeOne) {
    NiftiImage image;
    image.extent = {24, 24, 24};
    image.datatype = 512;
    for (int i = 0; i < 24 * 24 * 24; ++i) {
        const int x = i % 24, y = i / 24 % 24, z = i / 576;
        const auto label = static_cast<std::uint16_t>(x > 4 && y > 4 && z > 4 ? 1 + x / 8 + 3 * (y / 8) : 0);
        image.voxels.append(reinterpret_cast<const char*>(&label), sizeof label);
    }
    writeFile(folder_ / "labels.nii.gz", gzip(niftiBytes(image)));
    writeFile(folder_ / "labels.nii", niftiBytes(image));
    for (const char* name : {"labels.nii.gz", "labels.nii"})
        EXPECT_THAT(run("import " + std::string(name) + " l.zarr --force").problems,
                    HasSubstr("looks like a label map (10 whole values, 0 to 9)"));
    EXPECT_THAT(run("render l.zarr --engine mirror --size 16x16 -o a.png").problems,
                HasSubstr("looks like a label map"));
    // Few values without regions, and measurements, are none.
    std::uint32_t random = 4711;
    for (std::size_t i = 0; i < image.voxels.size(); i += 2)
        image.voxels[i] = static_cast<char>((random = random * 1664525 + 1013904223) >> 28);
    writeFile(folder_ / "noise.nii", niftiBytes(image));
    EXPECT_THAT(run("import noise.nii n.zarr").problems, Not(HasSubstr("label map")));
}

TEST_F(Folders, ForeignZarrIsReadOrRefusedByEveryCommand) {
    fs::create_directories(folder_ / "ome.zarr");
    write("ome.zarr/zarr.json",
          R"({"zarr_format":3,"node_type":"group","attributes":{"ome":{"version":"0.5"}}})");
    fs::create_directories(folder_ / "two.zarr");
    write("two.zarr/.zarray", "{}");
    fs::create_directories(folder_ / "none.zarr");
    for (const char* command : {"import % out.zarr", "info %", "render % -o a.png --engine mirror"}) {
        const auto with = [&](const char* name) {
            return std::string(command).replace(std::string(command).find('%'), 1, name);
        };
        expectRefused(with("ome.zarr"), {"ome.zarr/zarr.json", "multiscales"});
        expectRefused(with("two.zarr"), {"two.zarr/.zarray", "zarr_format"});
        expectRefused(with("none.zarr"), {"none.zarr", "without metadata"});
    }
    write("two.zarr/.zarray",
          R"({"zarr_format":2,"shape":[4,3,2],"chunks":[4,3,2],"dtype":"|u1","compressor":null,)"
          R"("fill_value":7,"order":"C","filters":null})");
    write("two.zarr/0.0.0", std::string(24, '\5'));
    expectRefused("import two.zarr out.zarr", {"two.zarr/.zarray", "--spacing"});
    EXPECT_EQ(run("import two.zarr out.zarr --spacing 1,2,3").exitCode, 0);
    EXPECT_THAT(run("info out.zarr").out, HasSubstr("5 to 5"));
    EXPECT_THAT(run("info two.zarr --spacing 1,2,3").out, HasSubstr("2 x 3 x 4 voxels of 1 x 2 x 3 mm"));
}

TEST_F(Folders, TiltIsShownWithItsSignInFilesAndStores) {
    for (const double sign : {1.0, -1.0}) {
        fs::remove_all(folder_ / "tilted");
        series("tilted", [&](DicomImage& image) {
            image.columnDirection = {0, 0.9659258, -0.2588190 * sign};
            image.position->y = 5;
        });
        const Outcome import = run("import tilted t.zarr --force");
        ASSERT_EQ(import.exitCode, 0) << import.problems;
        for (const char* input : {"tilted", "t.zarr"}) {
            EXPECT_THAT(
                run(std::string("info ") + input).out,
                HasSubstr(sign > 0
                              ? "gantry tilt:   15 degrees (anterior edge of the slices towards the head)"
                              : "gantry tilt:   -15 degrees (anterior edge of the slices towards the feet)"));
            const auto json = nlohmann::json::parse(run(std::string("info --json ") + input).out);
            const auto& volume = json.contains("volumes") ? json["volumes"][0] : json;
            EXPECT_NEAR(volume["gantryTiltDegrees"].get<double>(), 15 * sign, 1e-4);
        }
    }
}

TEST_F(Folders, ControlCharactersOfASidecarAreEscaped) {
    write("v.raw", std::string(16, 'x'));
    write("v.json", "{\"data\":\"v.raw\",\"extent\":[2,2,2],\"type\":\"int16\",\"spacing\":[1,1,1],"
                    "\"unit\":\"\\u001b[2J\"}");
    const Outcome info = run("info v.json");
    EXPECT_THAT(info.out, AllOf(HasSubstr("\\x1b"), Not(HasSubstr("\x1b"))));
}

} // namespace
} // namespace tessera::test
