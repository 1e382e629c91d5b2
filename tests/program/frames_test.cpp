// tests/program/frames_test.cpp: frames of reference: a store keeps that of its scan; labels and structure
// sets of another one are refused, and further volumes of another one are told.
#include "tests/support/dicom_writer.h"
#include "tests/support/program_fixture.h"
#include "tests/support/segmentation_writer.h"

#include "core/image/image_file.h"

#include <nlohmann/json.hpp>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Frames : public Program {
  protected:
    void SetUp() override {
        series("scan", frame_);
        series("other", other_);
        series("unknown", "");
        for (const char* name : {"scan", "other", "unknown"})
            ASSERT_EQ(run("import " + std::string(name) + " " + name + ".zarr").exitCode, 0);
        segmentation("seg.dcm", frame_);
        segmentation("seg-other.dcm", other_);
    }
    void series(const std::string& folder, const std::string& frame) const {
        fs::create_directories(folder_ / folder);
        for (int z = 0; z < kSlices; ++z) {
            DicomImage image;
            image.columns = kColumns;
            image.rows = kRows;
            image.spacingX = image.spacingY = 1;
            image.position = glm::dvec3(0, 0, 2.0 * z);
            image.frameOfReference = frame;
            for (int i = 0; i < kColumns * kRows; ++i)
                image.pixels.push_back(static_cast<std::uint16_t>(1024 + (i % kColumns > 5 ? 300 : 0)));
            writeDicom(folder_ / folder / ("s" + std::to_string(z)), image);
        }
    }
    void segmentation(const std::string& name, const std::string& frame) {
        SegImage image;
        image.rows = kRows;
        image.columns = kColumns;
        image.spacing = "1\\1";
        image.thickness = "2";
        image.frame = frame;
        for (const int z : {1, 2, 3})
            image.frames.push_back(
                {1, glm::dvec3(0, 0, 2.0 * z), std::vector<std::uint16_t>(std::size_t{kRows} * kColumns, 1)});
        write(name, segFileBytes(image));
    }
    /// A square around a place for each frame of reference.
    void structures(const std::string& name, const std::vector<std::string>& frames) {
        DicomBytes meta, length, four, data, rois, contours;
        const std::string kind = "1.2.840.10008.5.1.4.1.1.481.3";
        meta.element(2, 2, "UI", kind);
        meta.element(2, 3, "UI", "1.2.3");
        meta.element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
        four.u32(meta.bytes().size());
        length.element(2, 0, "UL", four.bytes());
        std::string allRois, allContours;
        for (std::size_t n = 0; n < frames.size(); ++n) {
            DicomBytes roi, contour, item;
            roi.element(0x3006, 0x22, "IS", std::to_string(n + 1));
            roi.element(0x3006, 0x24, "UI", frames[n]);
            roi.element(0x3006, 0x26, "LO", "part " + std::to_string(n + 1));
            allRois += DicomBytes::item(roi.bytes());
            contour.element(0x3006, 0x42, "CS", "CLOSED_PLANAR");
            contour.element(0x3006, 0x46, "IS", "3");
            contour.element(0x3006, 0x50, "DS", "2\\2\\4\\9\\2\\4\\9\\9\\4");
            item.element(0x3006, 0x40, "SQ", DicomBytes::item(contour.bytes()));
            item.element(0x3006, 0x84, "IS", std::to_string(n + 1));
            allContours += DicomBytes::item(item.bytes());
        }
        data.element(8, 0x16, "UI", kind);
        data.element(8, 0x18, "UI", "1.2.3");
        data.element(0x3006, 0x20, "SQ", allRois);
        data.element(0x3006, 0x39, "SQ", allContours);
        write(name, std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() + data.bytes());
    }
    static std::string drawing(const std::string& what, const std::string& more) {
        return "render " + what + " -o a.png --engine mirror --size 16x16 --preset bone --no-check " + more;
    }
    std::string noteOf(const std::string& what, const std::string& more) {
        const Outcome outcome = run(drawing(what, more));
        EXPECT_EQ(outcome.exitCode, 0) << more << "\n" << outcome.problems;
        return outcome.out + outcome.problems;
    }
    static constexpr int kSlices = 6, kColumns = 20, kRows = 16;
    const std::string frame_ = "1.2.826.7.1", other_ = "1.2.826.7.2";
    const std::vector<std::string> bothNamed_ = {"reference, " + frame_, "found " + other_, "--same-frame"};
};

TEST_F(Frames, AStoreKeepsThatOfItsScan) {
    const auto described = [&](const std::string& what) {
        const Outcome info = run("info " + what + " --json");
        return info.exitCode == 0 ? nlohmann::json::parse(info.out) : nlohmann::json();
    };
    EXPECT_EQ(described("scan.zarr")["frameOfReference"], frame_);
    EXPECT_EQ(described("unknown.zarr")["frameOfReference"], "");
    EXPECT_EQ(described("scan")["volumes"][0]["frameOfReference"], frame_);
    EXPECT_THAT(run("info scan.zarr").out, AllOf(HasSubstr(frame_), HasSubstr("FrameOfReferenceUID")));
    EXPECT_THAT(run("info unknown.zarr").out, Not(HasSubstr("FrameOfReferenceUID")));
    EXPECT_EQ(described("scan.zarr")["contentHash"], described("unknown.zarr")["contentHash"]);
    // Interpolated slices are of the same frame.
    fs::remove(folder_ / "scan" / "s2");
    ASSERT_EQ(run("import scan uneven.zarr --resample-z").exitCode, 0);
    EXPECT_EQ(described("uneven.zarr")["frameOfReference"], frame_);
    // Pictures are passed on.
    EXPECT_THAT(noteOf("scan.zarr", "--json --explain"), Not(HasSubstr(frame_)));
    EXPECT_THAT(readAll(folder_ / "a.png"), Not(HasSubstr(frame_)));
    EXPECT_THAT(readManifest(folder_ / "a.png"), AllOf(HasSubstr("contentHash"), Not(HasSubstr(frame_))));
}

TEST_F(Frames, LabelsOfAnotherAreRefused) {
    for (const char* scan : {"scan.zarr", "scan"}) {
        noteOf(scan, ""); // a series is imported once
        expectRefused(drawing(scan, "--labels seg-other.dcm"), bothNamed_);
        noteOf(scan, "--labels seg-other.dcm --same-frame");
        noteOf(scan, "--labels seg-other.dcm --set volumes[0].labels.sameFrame=true");
        noteOf(scan, "--labels seg.dcm");
        expectRefused(drawing(scan, "--labels seg-other.dcm"), bothNamed_); // whatever the cache holds
    }
    noteOf("unknown.zarr", "--labels seg-other.dcm");
    expectRefused(drawing("scan.zarr", "--same-frame"), {"--same-frame: expected labels", "found none"});
}

TEST_F(Frames, AnImportOfLabelsKeepsThatOfItsScan) {
    noteOf("scan.zarr", "--labels seg.dcm");
    std::string kept;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "cache"))
        if (entry.path().filename() == "sets")
            kept = entry.path().parent_path().string();
    ASSERT_FALSE(kept.empty());
    fs::rename(kept, folder_ / "kept.zarr");
    noteOf("scan.zarr", "--labels kept.zarr");
    noteOf("unknown.zarr", "--labels kept.zarr");
    expectRefused(drawing("other.zarr", "--labels kept.zarr"),
                  {"kept.zarr", "reference, " + other_, "found " + frame_, "--same-frame"});
    noteOf("other.zarr", "--labels kept.zarr --same-frame");
}

TEST_F(Frames, LabelsOfAFurtherVolumeGoByTheirOwnVolume) {
    const std::string labelled = "--add other.zarr --set volumes[1].labels={\"path\":\"LABELS\"}";
    const auto with = [&](const std::string& labels) {
        std::string text = labelled;
        return text.replace(text.find("LABELS"), 6, labels);
    };
    noteOf("scan.zarr", with("seg-other.dcm"));
    expectRefused(drawing("scan.zarr", with("seg.dcm")),
                  {"seg.dcm", "reference, " + other_, "found " + frame_, "sameFrame"});
    // --set comes after the options, and has the last word.
    noteOf("scan.zarr", with("seg.dcm") + " --set volumes[1].labels.sameFrame=true");
    write("two.json", R"({"tesseraScene":1,"image":{"size":[16,16]},"volumes":[
        {"path":"scan.zarr","transferFunction":"bone"},
        {"path":"other.zarr","transferFunction":"bone","labels":{"path":"seg.dcm"}}]})");
    expectRefused("render two.json -o a.png --engine mirror --no-check", {"seg.dcm", "sameFrame"});
    noteOf("two.json", "--same-frame");
}

TEST_F(Frames, StructureSetsOfAnotherAreRefused) {
    structures("rs.dcm", {frame_, other_});
    structures("rs-unknown.dcm", {""});
    expectRefused(drawing("scan.zarr", "--mesh rs.dcm"),
                  {"rs.dcm", "reference, " + frame_, "found " + other_, "\"part 2\"", "--same-frame"});
    noteOf("scan.zarr", "--mesh rs.dcm --same-frame");
    noteOf("scan.zarr", "--mesh rs.dcm --set meshes[0].sameFrame=true");
    noteOf("scan.zarr", "--mesh rs.dcm --set meshes[0].rois=[\"1\"]");
    noteOf("unknown.zarr", "--mesh rs.dcm");
    noteOf("scan.zarr", "--mesh rs-unknown.dcm");
    // Of a further volume where no transform moves it.
    noteOf("scan.zarr", "--mesh rs.dcm --add other.zarr");
    expectRefused(drawing("scan.zarr", "--mesh rs.dcm --add other.zarr --set "
                                       "volumes[1].transform=[1,0,0,1,0,1,0,0,0,0,1,0]"),
                  {"rs.dcm", frame_, other_});
    expectRefused(drawing("scan.zarr", "--mesh rs.dcm --add unknown.zarr"), {"rs.dcm", frame_, other_});
    noteOf("scan.zarr", "--mesh rs.dcm --set volumes[0].transform=[1,0,0,1,0,1,0,0,0,0,1,0]");
}

TEST_F(Frames, FurtherVolumesOfAnotherAreTold) {
    const std::string moved = "=[1,0,0,1,0,1,0,0,0,0,1,0]";
    EXPECT_THAT(noteOf("scan.zarr", "--add scan.zarr --add other.zarr"),
                AllOf(HasSubstr("volume 3 has another frame of reference, " + other_),
                      HasSubstr("the first, " + frame_), HasSubstr("volumes[2].transform"),
                      Not(HasSubstr("volume 2"))));
    for (const std::string& more : {std::string("--add scan.zarr"), std::string("--add unknown.zarr"),
                                    "--add other.zarr --set volumes[1].transform" + moved,
                                    "--add other.zarr --set volumes[0].transform" + moved})
        EXPECT_THAT(noteOf("scan.zarr", more), Not(HasSubstr("frame of reference"))) << more;
    EXPECT_THAT(noteOf("unknown.zarr", "--add other.zarr"), Not(HasSubstr("frame of reference")));
}

} // namespace
} // namespace tessera::test
