// tests/bricking/import/files/stack_imagej_test.cpp: hyperstacks of ImageJ: channels and points of time as
// volumes of one file, with entries for all pages or for the first alone.
#include "bricking/import/catalogue.h"
#include "bricking/import/files/file_format.h"
#include "tests/support/stack_writers.h"

#include <fstream>
#include <gmock/gmock.h>

namespace tessera::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

std::string counts(int channels, int slices, int frames) {
    return "ImageJ=1.53t\nimages=" + std::to_string(channels * slices * frames) +
           "\nchannels=" + std::to_string(channels) + "\nslices=" + std::to_string(slices) +
           "\nframes=" + std::to_string(frames) + "\nhyperstack=true\nmode=grayscale\n";
}

/// Page n holds the values of slice n of stackValues().
void writeStack(const fs::path& path, const std::string& description, int pages, bool isAppended, bool big,
                bool isLong) {
    OwnTiff tiff{.big = big, .isLong = isLong, .rows = 6, .pages = isAppended ? 1 : pages};
    tiff.description = description;
    tiff.perX = 2, tiff.perY = 4; // pixels a unit
    const std::string pixels = voxelBytes(stackValues<std::uint16_t>(5, 6, pages), big);
    tiff.pixels = isAppended ? pixels.substr(0, 60) : pixels;
    if (!isAppended)
        return writeFile(path, tiff.bytes());
    OwnTiff moved = tiff; // its pixels lie behind everything else, and so do the other pages
    moved.other[273] = static_cast<std::uint32_t>(tiff.bytes().size());
    writeFile(path, moved.bytes() + pixels);
}

// Pages go up by channels, then slices, then points of time.
TEST(ImageJStack, ChannelsAndTimesAreVolumesOfOneFile) {
    const ScratchFolder folder;
    const fs::path path = folder / "a.tif";
    for (const bool isAppended : {false, true})
        for (const bool big : {false, true})
            for (const bool isLong : {false, true})
                for (const glm::ivec3 c : {glm::ivec3(2, 3, 4), glm::ivec3(1, 3, 2), glm::ivec3(3, 2, 1),
                                           glm::ivec3(1, 4, 1), glm::ivec3(2, 1, 3)}) {
                    const int pages = c.x * c.y * c.z, volumes = c.x * c.z;
                    writeStack(path, counts(c.x, c.y, c.z) + "unit=micron\nspacing=3.0\n", pages, isAppended,
                               big, isLong);
                    EXPECT_EQ(fileFormatOf(path)->volumes(path).size(),
                              volumes == 1 ? 0u : static_cast<std::size_t>(c.x));
                    for (int n = 0; n < 2 * volumes; ++n) { // by number alone, and by channel and time
                        const int volume = n % volumes;
                        SourceOptions options;
                        options.series = volumes == 1 ? 0 : volume + 1;
                        if (n >= volumes && volumes > 1) {
                            options.series = c.x > 1 ? volume % c.x + 1 : 0;
                            options.phase = c.z > 1 ? volume / c.x + 1 : 0;
                        }
                        const auto source = openSource(path, options);
                        EXPECT_EQ(source->info().extentVoxels, glm::ivec3(5, 6, c.y));
                        EXPECT_NEAR(source->info().spacingMm().x, 0.5e-3, 1e-9);
                        EXPECT_NEAR(source->info().spacingMm().y, 0.25e-3, 1e-9);
                        EXPECT_NEAR(source->info().spacingMm().z, 3e-3, 1e-9);
                        const std::vector<std::uint16_t> found = readAll<std::uint16_t>(*source);
                        std::vector<std::uint16_t> expected;
                        for (int z = 0; z < c.y; ++z) {
                            const int page = (volume / c.x * c.y + z) * c.x + volume % c.x;
                            for (const std::uint16_t value : sliceValues<std::uint16_t>(5, 6, page))
                                expected.push_back(value);
                        }
                        EXPECT_EQ(found, expected) << isAppended << ' ' << volume << " of " << volumes;
                    }
                }
}

TEST(ImageJStack, VolumesAreListedAndChosenByNumber) {
    const ScratchFolder folder;
    const fs::path path = folder / "a.tif";
    writeStack(path, counts(2, 2, 2), 8, false, false, false);
    const auto listed = [&] {
        std::vector<std::string> all;
        for (const CatalogueRow& row : lookThrough(path, kCubes).rows)
            all.push_back(std::to_string(row.series) + " " + row.what);
        return all;
    };
    EXPECT_THAT(listed(), ElementsAre("1 channel 1, 2 phases for --phase (1: time 1, 2: time 2)",
                                      "2 channel 2, 2 phases for --phase (1: time 1, 2: time 2)"));
    EXPECT_THAT(refusalOfOpening(path, kCubes), HasSubstr("--series N"));
    writeStack(path, counts(1, 2, 3) + "finterval=500\ntunit=ms\n", 6, true, false, false);
    EXPECT_THAT(listed(), ElementsAre("0 a.tif, 3 phases for --phase (1: 0 s, 2: 0.5 s, 3: 1 s)"));
    EXPECT_THAT(refusalOfOpening(path, kCubes), HasSubstr("--phase N"));
    SourceOptions any = kCubes;
    any.largest = true; // of equal ones the first
    EXPECT_EQ(readAll<std::uint16_t>(*openSource(path, any)), (stackValues<std::uint16_t>(5, 6, 2)));
    any.largest = false, any.series = 1, any.phase = 3;
    EXPECT_EQ(readAll<std::uint16_t>(*openSource(path, any)).front(),
              (sliceValues<std::uint16_t>(5, 6, 4).front()));
    // In a folder it is one volume of three times.
    any.series = 0;
    EXPECT_EQ(readAll<std::uint16_t>(*openSource(folder.path(), any)).front(),
              (sliceValues<std::uint16_t>(5, 6, 4).front()));
}

// A line that is left out counts 1; slices are what is left.
TEST(ImageJStack, CountsThatAreNotSaidFollowFromTheOthers) {
    const ScratchFolder folder;
    const fs::path path = folder / "a.tif";
    SourceOptions second = kCubes;
    second.series = 2;
    writeStack(path, "ImageJ=1.11a\nimages=6\nchannels=2\n", 6, false, false, false);
    EXPECT_EQ(openSource(path, second)->info().extentVoxels.z, 3);
    writeStack(path, "ImageJ=1.11a\nimages=6\nframes=6\n", 6, true, false, false);
    EXPECT_EQ(openSource(path, second)->info().extentVoxels.z, 1);
    writeStack(path, "ImageJ=1.11a\nchannels=3\nslices=2\n", 6, false, false, false);
    EXPECT_EQ(openSource(path, second)->info().extentVoxels.z, 2);
    // A distance of 1 is left out between slices; a single one has none.
    second.spacingMm.reset();
    writeStack(path, counts(2, 3, 1) + "unit=mm\n", 6, false, false, false);
    EXPECT_NEAR(openSource(path, second)->info().spacingMm().z, 1, 1e-12);
    writeStack(path, counts(2, 1, 3) + "unit=mm\n", 6, false, false, false);
    EXPECT_THAT(refusal([&] { fileFormatOf(path)->open(path, second); }), HasSubstr("nothing between them"));
}

TEST(ImageJStack, CountsThatDisagreeAreRefused) {
    const ScratchFolder folder;
    const fs::path path = folder / "a.tif";
    const auto refused = [&](const std::string& description, bool isAppended) {
        writeStack(path, description, 6, isAppended, false, false);
        SourceOptions first = kCubes;
        first.series = 1;
        const std::string why = refusal([&] { fileFormatOf(path)->open(path, first); });
        EXPECT_EQ(refusal([&] { fileFormatOf(path)->volumes(path); }), why); // nothing is listed on a lie
        return why;
    };
    EXPECT_THAT(refused("ImageJ=1.53t\nimages=6\nchannels=4\nslices=2\n", false),
                HasSubstr("4 times 2 times 1"));
    EXPECT_THAT(refused("ImageJ=1.53t\nimages=6\nchannels=4\n", false), HasSubstr("6 pages"));
    EXPECT_THAT(refused(counts(2, 4, 1), false), HasSubstr("expected 8 pages"));
    EXPECT_THAT(refused(counts(2, 4, 1), true), HasSubstr("is it truncated?"));
    EXPECT_THAT(refused(counts(10000, 100000, 1), true), HasSubstr("is it truncated?"));
    EXPECT_THAT(refused("ImageJ=1.53t\nimages=6\nchannels=99999999999\n", true), HasSubstr("channels="));
    EXPECT_THAT(refused("ImageJ=1.53t\nimages=6\nframes=0\n", false), HasSubstr("frames="));
    EXPECT_THAT(refused("ImageJ=1.53t\nimages=6\nchannels=200000\nframes=200000\n", true),
                HasSubstr("10000 channels"));
}

// Above 4 GiB, in a file that takes no such place.
TEST(ImageJStack, PagesBehindFourGibibytesAreRead) {
    const ScratchFolder folder;
    const fs::path path = folder / "a.tif";
    constexpr int kWidth = 2048, kHeight = 1024, kPages = 1026; // of 4 MiB
    OwnTiff tiff{.width = kWidth, .height = kHeight, .rows = kHeight, .pages = 1};
    tiff.description = counts(2, kPages / 2, 1);
    tiff.pixels = std::string(std::size_t{kWidth} * kHeight * 2, '\0');
    const std::string head = tiff.bytes();
    OwnTiff moved = tiff;
    moved.other[273] = static_cast<std::uint32_t>(head.size());
    writeFile(path, moved.bytes());
    const std::uint64_t page = std::uint64_t{kWidth} * kHeight * 2, begin = head.size();
    fs::resize_file(path, begin + kPages * page);
    {
        std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
        file.seekp(static_cast<std::streamoff>(begin + (kPages - 1) * page));
        file.write("\x34\x12", 2);
    }
    SourceOptions second = kCubes;
    second.series = 2;
    const auto source = openSource(path, second);
    ASSERT_EQ(source->info().extentVoxels, glm::ivec3(kWidth, kHeight, kPages / 2));
    ASSERT_TRUE(source->seek(kPages / 2 - 1));
    std::vector<std::byte> slice(sliceBytesOf(source->info()));
    source->readSlices(1, slice);
    EXPECT_EQ(slice[0], std::byte{0x34});
    EXPECT_EQ(slice[1], std::byte{0x12});
    fs::resize_file(path, begin + kPages * page - 1);
    EXPECT_THAT(refusal([&] { fileFormatOf(path)->open(path, second); }), HasSubstr("is it truncated?"));
}

} // namespace
} // namespace tessera::test
