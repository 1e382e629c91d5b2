// tests/bricking/labels/label_files_damage_test.cpp: random damage to label files. Each is read or refused
// with its name, and takes no memory that its bytes do not justify.
#include "bricking/import/labels/open_labels.h"
#include "tests/support/counted_heap.h"
#include "tests/support/label_file_tools.h"
#include "tests/support/segmentation_writer.h"
#include "tests/support/zarr_writer.h"

#include <random>

namespace tessera::test {
namespace {

constexpr std::size_t kMostBytes = std::size_t{6} << 20; // of buffers; files here have a few kilobytes

struct Outcome {
    int read = 0, refused = 0;
};

/// Reads a few slices of every layer, one at a time, so that the test's own memory is a slice.
void readSome(const std::filesystem::path& path, Outcome& outcome) {
    try {
        LabelFile file = openLabels(path, {});
        constexpr std::size_t kMostRead = 200;
        for (std::size_t i = 0; i < std::min(file.layers.size(), kMostRead); ++i) {
            const glm::ivec3 extent = file.layers[i]->info().extentVoxels;
            // Formats whose files may lack chunks have any extent: an import charges for a slice first.
            constexpr std::size_t kMostSlice = std::size_t{1} << 18;
            if (static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) > kMostSlice)
                continue;
            std::vector<std::uint32_t> slice(static_cast<std::size_t>(extent.x) *
                                             static_cast<std::size_t>(extent.y));
            for (int z = 0; z < std::min(extent.z, static_cast<int>(kMostRead)); ++z)
                file.layers[i]->readSlices(1, slice);
        }
        ++outcome.read;
    } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(path.parent_path().string()));
        ++outcome.refused;
    }
}

/// Flips bits, or replaces, removes or doubles runs of bytes, within the first `part` bytes.
std::string damaged(std::string bytes, std::size_t part, std::mt19937& random) {
    const auto below = [&](std::size_t limit) { return random() % std::max<std::size_t>(limit, 1); };
    for (std::size_t i = 0, count = 1 + below(3); i < count; ++i) {
        const std::size_t at = below(std::min(part, bytes.size())), length = 1 + below(4);
        switch (below(6)) {
        case 0:
        case 1:
        case 2:
            bytes[at] = static_cast<char>(bytes[at] ^ 1 << below(8));
            break;
        case 3:
            bytes[at] = "0199-:(\n\xff"[below(9)];
            break;
        case 4:
            bytes.erase(at, length);
            break;
        default:
            bytes.insert(at, bytes.substr(at, length));
        }
    }
    return bytes;
}

void expectHarmless(const std::string& name, const std::string& bytes, std::size_t part, int count) {
    const auto folder = labelTestFolder();
    Outcome outcome;
    writeBytes(folder / name, bytes);
    readSome(folder / name, outcome); // what libraries keep is there now
    ASSERT_EQ(outcome.read, 1) << name;
    std::mt19937 random(11);
    for (int i = 0; i < count && !testing::Test::HasFailure(); ++i) {
        writeBytes(folder / name, damaged(bytes, part, random));
        const std::size_t before = liveBytes;
        peakBytes = before;
        readSome(folder / name, outcome);
        EXPECT_LT(peakBytes - before, kMostBytes) << name << " " << i;
    }
    EXPECT_GT(outcome.refused, count / 10) << name;
    EXPECT_EQ(outcome.read + outcome.refused, count + 1);
}

std::string nrrdText(const std::string& encoding, const std::string& data, bool hasLayers) {
    return "NRRD0004\ntype: unsigned short\ndimension: " + std::string(hasLayers ? "4" : "3") +
           "\nspace: left-posterior-superior\nsizes: " + (hasLayers ? "2 " : "") +
           "3 4 5\nspace directions: " + (hasLayers ? "none " : "") +
           "(2,0,0) (0,3,0) (0,0,4)\nkinds: " + (hasLayers ? "list " : "") +
           "domain domain domain\nendian: little\nencoding: " + encoding +
           "\nspace origin: (10,20,30)\nSegment0_Name:=a\nSegment0_LabelValue:=1\nSegment0_Color:=1 0 0\n" +
           (hasLayers ? "Segment0_Layer:=0\nSegment1_LabelValue:=2\nSegment1_Layer:=1\n" : "") + "\n" + data;
}

TEST(LabelFilesDamage, Nrrd) {
    std::vector<std::uint32_t> values(60), two(120);
    for (std::size_t i = 0; i < 60; ++i)
        values[i] = two[2 * i] = i % 7 == 0;
    const std::string raw = fileBytes<std::uint16_t>(values), rawTwo = fileBytes<std::uint16_t>(two);
    std::string text;
    for (const std::uint32_t value : values)
        text += std::to_string(value) + " ";
    expectHarmless("a.nrrd", nrrdText("raw", raw, false), 500, 1500);
    expectHarmless("b.nrrd", nrrdText("gzip", gzipped(raw), false), 500, 1500);
    expectHarmless("c.nrrd", nrrdText("ascii", text, false), 500, 1000);
    expectHarmless("d.seg.nrrd", nrrdText("gzip", gzipped(rawTwo), true), 500, 1500);
}

SegImage segOfTwo() {
    SegImage image;
    image.segments = {{1, "a"}, {2, "b"}};
    for (int i = 0; i < 6; ++i) {
        std::vector<std::uint16_t> pixels(15);
        for (std::size_t k = 0; k < pixels.size(); k += static_cast<std::size_t>(i % 2 + 2))
            pixels[k] = 1;
        image.frames.push_back({1 + i % 2, glm::dvec3(0, 0, 2 * (i / 2)), pixels});
    }
    return image;
}

TEST(LabelFilesDamage, Segmentations) {
    SegImage image = segOfTwo();
    const std::string bytes = segFileBytes(image);
    expectHarmless("a.dcm", bytes, bytes.size(), 2500);
    image.type = "FRACTIONAL";
    image.bits = 8;
    const std::string fractions = segFileBytes(image);
    expectHarmless("b.dcm", fractions, fractions.size(), 1000);
    image.type = "LABELMAP";
    image.frames.resize(1);
    const std::string map = segFileBytes(image);
    expectHarmless("c.dcm", map, map.size(), 1000);
}

/// A folder of Zarr with damage to one of its files at a time.
void expectHarmlessZarr(const WrittenZarr& zarr, const std::vector<std::filesystem::path>& files, int count) {
    const auto folder = labelTestFolder();
    std::vector<std::uint32_t> values;
    for (std::uint32_t i = 0; i < 4 * 5 * 6; ++i)
        values.push_back(i % 7 < 3 ? 0 : i % 7);
    const auto image = folder / "s/labels/a";
    const Json about = {{"colors", Json::array({Json{{"label-value", 1}, {"rgba", {1, 2, 3, 4}}}})}};
    Json ome = {{"multiscales", Json::array({multiscaleOf("zyx", {3, 2, 1}, {30, 20, 10})})},
                {"image-label", about}};
    writeZarrGroup(folder / "s", zarr.version, Json::object());
    writeZarrGroup(folder / "s/labels", zarr.version, {{"labels", {"a"}}});
    writeZarrGroup(image, zarr.version, ome);
    writeZarrArray(image / "0", zarr, values);
    Outcome outcome;
    readSome(folder / "s", outcome);
    ASSERT_EQ(outcome.read, 1);
    std::mt19937 random(12);
    for (int i = 0; i < count && !testing::Test::HasFailure(); ++i) {
        const auto file = image / files[random() % files.size()];
        const std::string bytes = readBytes(file);
        writeBytes(file, damaged(bytes, bytes.size(), random));
        const std::size_t before = liveBytes;
        peakBytes = before;
        readSome(folder / "s", outcome);
        EXPECT_LT(peakBytes - before, kMostBytes) << file << " " << i;
        writeBytes(file, bytes);
    }
    EXPECT_GT(outcome.refused, count / 4);
    EXPECT_EQ(outcome.read + outcome.refused, count + 1);
}

TEST(LabelFilesDamage, Zarr) {
    WrittenZarr zarr;
    zarr.shape = {4, 5, 6};
    zarr.chunk = {2, 3, 4};
    for (const char* compressor : {"none", "blosc", "zstd", "gzip"}) {
        zarr.version = 3;
        zarr.compressor = compressor;
        expectHarmlessZarr(zarr, {"zarr.json", "0/zarr.json", "0/zarr.json", "0/c/1/1/0", "0/c/0/0/0"}, 800);
        zarr.version = 2;
        expectHarmlessZarr(zarr, {".zattrs", "0/.zarray", "0/.zarray", "0/1/1/0", "0/0/0/0"}, 800);
    }
    zarr.version = 3;
    zarr.shard = {4, 6, 8};
    expectHarmlessZarr(zarr, {"zarr.json", "0/zarr.json", "0/c/0/0/0", "0/c/0/0/0"}, 800);
}

/// A few bytes that inflate to a thousand times as much.
TEST(LabelFilesDamage, GzipBombs) {
    const auto folder = labelTestFolder();
    const std::string bomb = gzipped(std::string(std::size_t{8} << 20, '\1'));
    std::string header = nrrdText("gzip", bomb, false);
    header.replace(header.find("3 4 5"), 5, "1 1 9");
    writeBytes(folder / "a.nrrd", header);
    Outcome outcome;
    peakBytes = liveBytes.load();
    const std::size_t before = liveBytes;
    readSome(folder / "a.nrrd", outcome);
    EXPECT_EQ(outcome.refused, 1);
    EXPECT_LT(peakBytes - before, std::size_t{1} << 20);
    header.replace(header.find("1 1 9"), 5, "1 1 9999999"); // more than it could hold
    writeBytes(folder / "b.nrrd", header);
    readSome(folder / "b.nrrd", outcome);
    EXPECT_EQ(outcome.refused, 2);
}

} // namespace
} // namespace tessera::test
