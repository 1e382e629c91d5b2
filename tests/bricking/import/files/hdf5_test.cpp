// tests/bricking/import/files/hdf5_test.cpp: volumes in HDF5 files as h5py writes them: every way to find
// chunks, filters, missing chunks, axes, places, and what is refused.
#include "bricking/import/catalogue.h"
#include "bricking/import/files/hdf5/h5_bytes.h"
#include "tests/support/hdf5_corpus.h"
#include "tests/support/refusals.h"

#include <cstddef>
#include <gmock/gmock.h>
#include <span>
#include <string>

namespace tessera::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(ImportHdf5, TheChecksumIsLookup3) {
    const auto sum = [](const std::string& text) {
        return h5Checksum(std::as_bytes(std::span(text.data(), text.size())));
    };
    // Of its author's driver.
    EXPECT_EQ(sum(""), 0xdeadbeefu);
    EXPECT_EQ(sum("Four score and seven years ago"), 0x17770551u);
}

// All ways to lay out numbers and to find chunks, of both generations of the format.
TEST(ImportHdf5, EveryVoxelHasTheValueThatWasWritten) {
    std::size_t volumes = 0;
    for (const fs::path& path : hdf5Files(false))
        for (Hdf5Volume& volume : openHdf5Volumes(path)) {
            const std::string what = path.filename().string() + " " + volume.name;
            const VolumeInfo& info = volume.source->info();
            const bool isInPages = what.starts_with("pages"), isLong = isInPages || what.starts_with("many");
            ASSERT_EQ(info.extentVoxels, glm::ivec3(7, 6, isLong ? 30 : 5)) << what;
            const bool isSecond = volume.name == "/channels[1]" || volume.name.starts_with("channel 2");
            const std::size_t time = volume.name.find("time ");
            const int base = (isSecond ? 1000 : 0) +
                             (time == std::string::npos ? 0 : 10000 * (volume.name[time + 5] - '1'));
            const std::vector<double> found = valuesOf(*volume.source);
            for (int z = 0; z < info.extentVoxels.z; ++z)
                for (int y = 0; y < 6; ++y)
                    for (int x = 0; x < 7; ++x) {
                        double expected = 100 * z + 10 * y + x + base;
                        const bool isThere = z >= 2 && z < 4 && y >= 3 && x < 4;
                        if ((volume.name == "/missing" && !isThere) || volume.name == "/never")
                            expected = 7;
                        if (isInPages)
                            expected = z == 29 && y == 5 && x == 6 ? (2956 & 255) : 7;
                        ASSERT_EQ(found[indexOf(info, x, y, z)], expected)
                            << what << ": " << x << ' ' << y << ' ' << z;
                    }
            ++volumes;
        }
    EXPECT_EQ(volumes, 52u);
}

std::vector<std::string> namesOf(const std::vector<FileVolume>& volumes) {
    std::vector<std::string> names;
    for (const FileVolume& volume : volumes)
        names.push_back(volume.name);
    return names;
}

// A time by --phase; --series alone goes on through all of them.
TEST(ImportHdf5, ChannelsOfImarisHaveTimes) {
    const fs::path path = hdf5Corpus() / "times.ims";
    const Catalogue catalogue = lookThrough(path);
    ASSERT_EQ(catalogue.rows.size(), 2u);
    for (const CatalogueRow& row : catalogue.rows)
        EXPECT_THAT(row.phases, ElementsAre("time 1", "time 2", "time 3"));
    for (int time = 0; time < 3; ++time)
        for (int channel = 0; channel < 2; ++channel) {
            SourceOptions both, alone;
            both.series = channel + 1, both.phase = time + 1;
            alone.series = 2 * time + channel + 1;
            const std::vector<double> voxels = valuesOf(*openSource(path, both));
            EXPECT_EQ(voxels, valuesOf(*openSource(path, alone))) << time << ' ' << channel;
            EXPECT_EQ(voxels.front(), 10000 * time + 1000 * channel);
        }
    SourceOptions wrong;
    wrong.phase = 2;
    EXPECT_THAT(refusalOfOpening(path, wrong), AllOf(HasSubstr("times.ims"), HasSubstr("--series N")));
    wrong.series = 1, wrong.phase = 4;
    EXPECT_THAT(refusalOfOpening(path, wrong), AllOf(HasSubstr("times.ims"), HasSubstr("between 1 and 3")));
    wrong.series = 3; // a later time of channel 1
    EXPECT_THAT(refusalOfOpening(path, wrong), AllOf(HasSubstr("times.ims"), HasSubstr("between 1 and 2")));
}

TEST(ImportHdf5, SetsAreListedByTheirPathsAndChosenByNumber) {
    const fs::path path = hdf5Corpus() / "axes_latest.h5";
    EXPECT_THAT(namesOf(fileFormatOf(path)->volumes(path)),
                ElementsAre("/behind", "/channels[0]", "/channels[1]"));
    const fs::path imaris = hdf5Corpus() / "imaris.ims";
    EXPECT_THAT(namesOf(fileFormatOf(imaris)->volumes(imaris)),
                ElementsAre("channel 1 (\"DAPI\")", "channel 2 (\"GFP\")"));
    SourceOptions options;
    options.spacingMm = glm::dvec3(1);
    EXPECT_EQ(lookThrough(path, options).rows.size(), 3u);
    EXPECT_THAT(refusalOfOpening(path, options), HasSubstr("series"));
    options.series = 3;
    EXPECT_EQ(valuesOf(*openSource(path, options)).front(), 1000);
    options.series = 4;
    EXPECT_THAT(refusalOfOpening(path, options), HasSubstr("4"));
}

TEST(ImportHdf5, SpacingIsWhatAttributesSayOrAskedFor) {
    for (const char* name : {"spacing_earliest.h5", "dense_latest.h5"}) { // in micrometres along z, y, x
        const auto source = openSource(hdf5Corpus() / name, {});
        EXPECT_EQ(source->info().spacingMm(), glm::dvec3(0.5, 2, 3)) << name;
        EXPECT_FALSE(source->info().orientationKnown);
    }
    SourceOptions options;
    options.spacingMm = glm::dvec3(4, 5, 6);
    const auto given = openSource(hdf5Corpus() / "spacing_earliest.h5", options);
    EXPECT_EQ(given->info().spacingMm(), glm::dvec3(4, 5, 6));
    EXPECT_THAT(given->info().remarks,
                ElementsAre("element_size_um says distances of voxels; --spacing is taken"));
    EXPECT_THAT(refusalOfOpening(hdf5Corpus() / "implicit_latest.h5"),
                HasSubstr("the spacing of voxels, or --spacing X,Y,Z"));

    SourceOptions second;
    second.series = 2;
    const auto imaris = openSource(hdf5Corpus() / "imaris.ims", second);
    EXPECT_NEAR(imaris->info().spacingMm().x, 0.5, 1e-12); // 3500 micrometres for 7 voxels
    EXPECT_NEAR(imaris->info().spacingMm().y, 2, 1e-12);
    EXPECT_NEAR(imaris->info().spacingMm().z, 3, 1e-12);
    EXPECT_NEAR(firstVoxelCentreMm(imaris->info()).x, -0.75, 1e-12);
}

// A row of Directions is an axis of the image, in the patient's LPS.
TEST(ImportHdf5, ItkSaysWhereItsVoxelsAre) {
    const auto source = fileFormatOf("a.h5")->open(hdf5Corpus() / "itk.h5", {});
    const VolumeInfo& info = source->info();
    EXPECT_TRUE(info.orientationKnown);
    EXPECT_EQ(centreMm(info, 0, 0, 0), glm::dvec3(-10, 20, 30));
    EXPECT_EQ(centreMm(info, 1, 0, 0), glm::dvec3(-10, 20.5, 30));
    EXPECT_EQ(centreMm(info, 0, 1, 0), glm::dvec3(-12, 20, 30));
    EXPECT_EQ(centreMm(info, 0, 0, 1), glm::dvec3(-10, 20, 33));
}

TEST(ImportHdf5, WhatIsNotReadIsRefusedWithItsReason) {
    const auto refused = [](const char* name) { return refusalOfOpening(hdf5Corpus() / name); };
    EXPECT_THAT(refused("refused_lzf.h5"),
                HasSubstr("chunks of /lzf packed by deflate, shuffle and fletcher32 alone, found lzf"));
    EXPECT_THAT(refused("refused_scaleoffset.h5"), HasSubstr("found scaleoffset"));
    EXPECT_THAT(refused("refused_virtual.h5"), HasSubstr("found a virtual set"));
    EXPECT_THAT(refused("refused_external.h5"), HasSubstr("found some in other files"));
    EXPECT_THAT(refused("refused_links.h5"), HasSubstr("links to other files, which are not followed"));
    EXPECT_THAT(refused("refused_types.h5"),
                AllOf(HasSubstr("/colours (4 axes, the last one with 3 numbers"),
                      HasSubstr("/mask (enumerations)"), HasSubstr("/pairs (structures)")));
    EXPECT_THAT(refused("refused_tensors.h5"), HasSubstr("one number a voxel of ITK's image of 3 axes"));
    const ScratchFolder folder;
    writeFile(folder / "a.h5", std::string(4096, 'x'));
    EXPECT_THAT(refusalOfOpening(folder / "a.h5"), HasSubstr("expected an HDF5 file"));
}

// In a folder, files without volumes are passed over, as weights of networks are.
TEST(ImportHdf5, FilesWithoutVolumesAreNoneOfAFolders) {
    const ScratchFolder folder;
    fs::copy_file(hdf5Corpus() / "refused_types.h5", folder / "weights.h5");
    fs::copy_file(hdf5Corpus() / "itk.h5", folder / "scan.h5");
    const Catalogue catalogue = lookThrough(folder.path(), {});
    ASSERT_EQ(catalogue.rows.size(), 1u);
    EXPECT_EQ(catalogue.rows.front().what, "scan.h5");
}

} // namespace
} // namespace tessera::test
