// tests/bricking/labels/open_labels_test.cpp: labels in NIfTI files of every type, folders of masks, and what
// TotalSegmentator wrote.
#include "bricking/import/labels/label_format.h"
#include "bricking/import/labels/open_labels.h"
#include "tests/support/import_test_tools.h"
#include "tests/support/label_tools.h"

#include <chrono>
#include <gmock/gmock.h>
#include <iostream>
#include <sys/resource.h>

namespace tessera::test {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

/// All voxels of a layer, in uneven portions.
Values allOf(LabelLayer& layer) {
    const glm::ivec3 e = layer.info().extentVoxels;
    const std::size_t slice = cellCount({e.x, e.y, 1});
    Values values(cellCount(e));
    for (int z = 0, count = 1; z < e.z; z += count++) {
        count = std::min(count, e.z - z);
        layer.readSlices(count, std::span(values).subspan(slice * static_cast<std::size_t>(z),
                                                          slice * static_cast<std::size_t>(count)));
    }
    return values;
}

struct NiftiType {
    std::int16_t code;
    std::uint32_t most; // label that it holds
};
template <class T> std::string bytesAs(const Values& values, bool bigEndian) {
    return voxelBytes(std::vector<T>(values.begin(), values.end()), bigEndian);
}
std::string voxelsOf(std::int16_t code, const Values& values, bool bigEndian) {
    switch (code) {
    case 2:
        return bytesAs<std::uint8_t>(values, bigEndian);
    case 4:
        return bytesAs<std::int16_t>(values, bigEndian);
    case 8:
        return bytesAs<std::int32_t>(values, bigEndian);
    case 16:
        return bytesAs<float>(values, bigEndian);
    case 64:
        return bytesAs<double>(values, bigEndian);
    case 256:
        return bytesAs<std::int8_t>(values, bigEndian);
    case 512:
        return bytesAs<std::uint16_t>(values, bigEndian);
    case 768:
        return bytesAs<std::uint32_t>(values, bigEndian);
    case 1024:
        return bytesAs<std::int64_t>(values, bigEndian);
    default:
        return bytesAs<std::uint64_t>(values, bigEndian);
    }
}

TEST(OpenLabels, EveryNiftiTypeKeepsItsValues) {
    const ScratchFolder scratch;
    const std::vector<NiftiType> types = {
        {2, 255},   {4, 32767},   {8, 2147483647},    {16, 4294967040u},   {64, 4294967295u},
        {256, 127}, {512, 65535}, {768, 4294967295u}, {1024, 4294967295u}, {1280, 4294967295u}};
    for (const NiftiType& type : types)
        for (const int how : {0, 1, 2, 3}) { // version, order, gzip
            NiftiImage image;
            image.extent = {71, 63, 3}; // more than one piece a slice
            image.datatype = type.code;
            image.version = how == 1 ? 2 : 1;
            image.bigEndian = how == 2;
            Values values(71 * 63 * 3);
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = i % 5 == 0 ? type.most : i % 5 == 1 ? 0 : static_cast<std::uint32_t>(i % 100);
            image.voxels = voxelsOf(type.code, values, image.bigEndian);
            const fs::path file = scratch / (how == 3 ? "l.nii.gz" : "l.NII");
            writeFile(file, how == 3 ? gzip(niftiBytes(image)) : niftiBytes(image));
            LabelFile labels = openLabels(file, {});
            ASSERT_EQ(labels.layers.size(), 1u);
            EXPECT_EQ(labels.shown, file.string());
            ASSERT_TRUE(allOf(*labels.layers[0]) == values) << type.code << " " << how;
        }
}

TEST(OpenLabels, ScaledValuesAreRounded) {
    const ScratchFolder scratch;
    NiftiImage image;
    image.datatype = 2;
    image.slope = 1. / 255; // a mask that an image program wrote
    Values values(24, 255);
    values[3] = 0;
    image.voxels = voxelsOf(2, values, false);
    writeFile(scratch / "m.nii", niftiBytes(image));
    Values expected(24, 1);
    expected[3] = 0;
    EXPECT_EQ(allOf(*openLabels(scratch / "m.nii", {}).layers[0]), expected);
    image.slope = 0.5;
    writeFile(scratch / "m.nii", niftiBytes(image));
    EXPECT_THAT(refusal([&] { allOf(*openLabels(scratch / "m.nii", {}).layers[0]); }), HasSubstr("127.5"));
}

TEST(OpenLabels, WhatIsNoLabelIsNamedWithItsVoxel) {
    const ScratchFolder scratch;
    const auto refusalOf = [&](std::int16_t code, const std::string& voxels) {
        NiftiImage image; // 2 x 3 x 4
        image.datatype = code;
        image.voxels = voxels;
        writeFile(scratch / "l.nii.gz", gzip(niftiBytes(image)));
        return refusal([&] { allOf(*openLabels(scratch / "l.nii.gz", {}).layers[0]); });
    };
    const auto with = [](auto value) { // in voxel (1, 2, 1)
        std::vector<decltype(value)> values(24, 1);
        values[11] = value;
        return voxelBytes(values);
    };
    const auto named = [](const char* value) {
        return AllOf(HasSubstr("l.nii.gz"), HasSubstr("(1, 2, 1)"), HasSubstr(value));
    };
    EXPECT_THAT(refusalOf(64, with(0.25)), named("0.25"));
    EXPECT_THAT(refusalOf(64, with(-1.0)), named("-1"));
    EXPECT_THAT(refusalOf(64, with(4294967296.0)), named("4294967296"));
    EXPECT_THAT(refusalOf(64, with(std::nan(""))), named("nan"));
    EXPECT_THAT(refusalOf(16, with(4294967296.0f)), named("4294967296"));
    EXPECT_THAT(refusalOf(16, with(std::numeric_limits<float>::infinity())), named("inf"));
    EXPECT_THAT(refusalOf(4, with(std::int16_t{-7})), named("-7"));
    EXPECT_THAT(refusalOf(1280, with(std::uint64_t{1} << 32)), named("4294967296"));
    EXPECT_THAT(refusalOf(1024, with(std::int64_t{-1})), named("-1"));
    NiftiImage cut;
    cut.voxels = std::string(48, '\1');
    const std::string whole = gzip(niftiBytes(cut));
    writeFile(scratch / "cut.nii.gz", whole.substr(0, whole.size() - 9));
    EXPECT_THAT(refusal([&] { allOf(*openLabels(scratch / "cut.nii.gz", {}).layers[0]); }),
                HasSubstr("cut.nii.gz"));
}

TEST(OpenLabels, AFolderOfMasks) {
    const ScratchFolder scratch;
    fs::create_directory(scratch / "masks");
    const auto write = [&](const std::string& name, const Values& values, double x) {
        NiftiImage image;
        image.extent = {3, 2, 2};
        image.datatype = 64;
        image.srow[3] = x;
        image.voxels = voxelsOf(64, values, false);
        writeFile(scratch / "masks" / name,
                  name.ends_with("gz") ? gzip(niftiBytes(image)) : niftiBytes(image));
    };
    write("spleen.nii.gz", {0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1}, 0);
    write("aorta.nii", {0, 0, 255, 0, 0, 0, 1, 0, 0, 0, 0, 0}, 0);
    write("lung_left.v2.nii.gz", {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 1);
    writeFile(scratch / "masks/readme.txt", "x");
    writeFile(scratch / "masks/.hidden.nii", "x");
    LabelFile file = openLabels(scratch / "masks", {});
    ASSERT_EQ(file.layers.size(), 3u);
    EXPECT_THAT(file.labels, ElementsAre(Label{1, "aorta"}, Label{2, "lung_left.v2"}, Label{3, "spleen"}));
    const VolumeInfo scan = openSource(scratch / "masks/aorta.nii", {})->info(); // in LPS
    const LabelImportReport report = importAtFloor(file, scan, scratch / "l.zarr");
    EXPECT_THAT(report.notes, Contains(AllOf(HasSubstr("aorta"), HasSubstr("255"))));
    EXPECT_THAT(report.notes, Contains("1 file that is no mask is left out"));
    writeFile(scratch / "masks/notes.txt", "x");
    EXPECT_THAT(openLabels(scratch / "masks", {}).notes, Contains("2 files that are no masks are left out"));
    // x and y run the other way in the scan; lung_left lies one voxel to the side.
    const std::vector<LabelSet> voxels = readBack(scratch / "l.zarr").voxels();
    EXPECT_THAT(voxels,
                ElementsAre(LabelSet{}, LabelSet{}, LabelSet{}, LabelSet{1, 3}, LabelSet{2, 3}, LabelSet{},
                            LabelSet{3}, LabelSet{}, LabelSet{}, LabelSet{}, LabelSet{}, LabelSet{1}));
}

TEST(OpenLabels, MoreMasksThanFilesMayBeOpen) {
    const ScratchFolder scratch;
    fs::create_directory(scratch / "masks");
    constexpr std::uint32_t kMasks = 320;
    for (std::uint32_t i = 0; i < kMasks; ++i) {
        NiftiImage image; // 2 x 3 x 4
        image.datatype = 2;
        image.voxels = std::string(24, '\0');
        image.voxels[i % 24] = 1;
        const std::string name = std::to_string(1000 + i) + (i % 2 ? ".nii" : ".nii.gz");
        writeFile(scratch / "masks" / name, i % 2 ? niftiBytes(image) : gzip(niftiBytes(image)));
    }
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
    rlimit few = before;
    few.rlim_cur = 256;
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
    LabelFile file = openLabels(scratch / "masks", {});
    const VolumeInfo scan = file.layers.front()->info();
    importAtFloor(file, scan, scratch / "l.zarr");
    const std::vector<LabelSet> voxels = readBack(scratch / "l.zarr").voxels();
    setrlimit(RLIMIT_NOFILE, &before);
    for (std::uint32_t i = 0; i < kMasks; ++i)
        EXPECT_TRUE(voxels[i % 24].contains(i + 1)) << i;
    for (std::size_t at = 0; at < voxels.size(); ++at)
        EXPECT_EQ(voxels[at].size(), (kMasks - at + 23) / 24);
}

TEST(OpenLabels, WhatIsNoFileOfLabelsIsRefused) {
    const ScratchFolder scratch;
    writeFile(scratch / "x.txt", "x");
    fs::create_directory(scratch / "empty");
    EXPECT_THAT(refusal([&] { openLabels(scratch / "x.txt", {}); }),
                AllOf(HasSubstr("x.txt"), HasSubstr("NIfTI files")));
    EXPECT_THAT(refusal([&] { openLabels(scratch / "empty", {}); }), HasSubstr("masks"));
    EXPECT_THAT(refusal([&] { openLabels(scratch / "nowhere", {}); }), HasSubstr("no such file"));
    EXPECT_FALSE(labelFormats().empty());
}

class RealLabels : public testing::Test {
  protected:
    void SetUp() override {
        if (testData().empty() || !fs::exists(folder / "masks"))
            GTEST_SKIP() << "no shared test data (TESSERA_TEST_DATA or ../shared/data)";
        scan = openSource(folder / "example_ct.nii.gz", {})->info();
    }
    fs::path folder = testData() / "labels/totalsegmentator";
    VolumeInfo scan;
    ScratchFolder scratch;
};

TEST_F(RealLabels, AFolderOfMasksIsEveryMask) {
    LabelFile file = openLabels(folder / "masks", {});
    ASSERT_EQ(file.layers.size(), 104u);
    const std::vector<Label> labels = file.labels;
    const std::size_t floor = labelImportFloorBytes(file, scan, 2);
    const LabelImportReport report = importAtFloor(file, scan, scratch / "l.zarr");
    std::cout << "104 masks: " << report.seconds << " s in " << formatBytes(floor) << ", " << report.sets
              << " sets\n";
    const ReadBack back = readBack(scratch / "l.zarr");
    ASSERT_EQ(back.table.labels.size(), 104u);
    std::vector<std::size_t> notIn(back.levels[0].size()); // labels of a voxel that no mask has confirmed
    for (std::size_t i = 0; i < notIn.size(); ++i)
        notIn[i] = back.table.sets[static_cast<std::size_t>(back.levels[0][i])].size();
    for (const Label& label : labels) {
        const auto mask = openSource(folder / "masks" / (label.name + ".nii.gz"), {});
        ASSERT_EQ(mask->info().extentVoxels, scan.extentVoxels);
        const std::vector<float> inside = readAll<float>(*mask);
        std::vector<bool> isIn;
        for (const auto& set : back.table.sets)
            isIn.push_back(std::ranges::find(set, label.value - 1) != set.end());
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < inside.size(); ++i) {
            wrong += (inside[i] != 0) != isIn[static_cast<std::size_t>(back.levels[0][i])];
            notIn[i] -= inside[i] != 0;
        }
        ASSERT_EQ(wrong, 0u) << label.name;
    }
    EXPECT_EQ(std::ranges::count(notIn, 0u), static_cast<std::ptrdiff_t>(notIn.size()));
}

TEST_F(RealLabels, AFileOfClassesOnASmallerGrid) {
    LabelFile file = openLabels(folder / "example_seg.nii.gz", {});
    importAtFloor(file, scan, scratch / "l.zarr");
    const ReadBack back = readBack(scratch / "l.zarr");
    const auto source = openSource(folder / "example_seg.nii.gz", {});
    const VolumeInfo own = source->info();
    const std::vector<std::uint8_t> values = readAll<std::uint8_t>(*source);
    const glm::ivec3 first(
        glm::round(glm::dvec3(glm::inverse(scan.patientFromVoxel) * own.patientFromVoxel[3])));
    std::size_t labelled = 0;
    for (std::size_t i = 0; i < back.levels[0].size(); ++i) {
        const glm::ivec3 at = gridPosition(i, scan.extentVoxels) - first;
        const bool isIn = glm::clamp(at, glm::ivec3(0), own.extentVoxels - 1) == at;
        const std::uint32_t value = isIn ? values[linearIndex(at, own.extentVoxels)] : 0;
        ASSERT_EQ(back.setOf(back.levels[0][i]), value == 0 ? LabelSet{} : LabelSet{value});
        labelled += value != 0;
    }
    EXPECT_GT(labelled, 50000u);
    EXPECT_EQ(back.table.labels.size(), 41u);
}

} // namespace
} // namespace tessera::test
