// tests/bricking/store/store_test.cpp: written data are read back bit for bit, every level and every field.
#include "tests/support/bricking_store_tools.h"

#include "bricking/store/codec.h"

#include <cstdlib>
#include <gtest/gtest.h>
#include <map>
#include <random>

namespace tessera {
namespace {

using namespace test;

/// The rule of bricking/store/pyramid.h, independently: rint() rounds halves to even.
std::vector<double> halved(const std::vector<double>& in, glm::ivec3 n, bool integer) {
    std::vector<double> out;
    for (int z = 0; z < n.z; z += 2)
        for (int y = 0; y < n.y; y += 2)
            for (int x = 0; x < n.x; x += 2) {
                double sum = 0;
                for (int i = 0; i < 8; ++i)
                    sum +=
                        in[linearIndex(glm::min(glm::ivec3(x + i % 2, y + i / 2 % 2, z + i / 4), n - 1), n)];
                out.push_back(integer ? std::rint(sum / 8)
                                      : static_cast<double>(static_cast<float>(sum / 8)));
            }
    return out;
}

struct Shape {
    glm::ivec3 extent;
    ValueType type;
};
std::vector<Shape> shapes() {
    std::vector<Shape> all;
    for (const glm::ivec3& e : {glm::ivec3(1, 1, 1), glm::ivec3(33, 47, 65), glm::ivec3(70, 90, 130)})
        for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32})
            all.push_back({e, type});
    all.push_back({{1030, 33, 3}, ValueType::i16}); // three shards along x
    all.push_back({{5, 2, 1100}, ValueType::u8});   // and along z, which closes shards on the way
    return all;
}

class StoreLevels : public testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, StoreLevels, testing::ValuesIn(shapes()), [](const auto& info) {
    const glm::ivec3 e = info.param.extent;
    return std::to_string(e.x) + "x" + std::to_string(e.y) + "x" + std::to_string(e.z) +
           name(info.param.type);
});

TEST_P(StoreLevels, EqualThePyramidBitForBit) {
    const auto [extent, type] = GetParam();
    ScratchFolder scratch;
    VolumeInfo info = plainInfo(extent, type);
    info.fillStored = 7;
    HashSource source(info);
    const ImportReport report = import(scratch / "v.zarr", source);
    EXPECT_EQ(report.voxels, info.voxelCount());
    EXPECT_EQ(entriesIn(scratch.path()), 1u) << "a temporary folder was left";

    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    std::vector<double> expected;
    for (int z = 0; z < extent.z; ++z)
        for (int y = 0; y < extent.y; ++y)
            for (int x = 0; x < extent.x; ++x)
                expected.push_back(source.valueAt(x, y, z));
    glm::ivec3 n = extent;
    for (int level = 0; level < kLevelCount; ++level) {
        ASSERT_EQ(levelExtent(extent, level), n);
        const auto found = readLevel(store, level, [](double padding) { ASSERT_EQ(padding, 7); });
        ASSERT_TRUE(found == expected) << "level " << level;
        expected = halved(expected, n, type != ValueType::f32);
        n = (n + 1) / 2;
    }
}

TEST(StorePyramid, HalvesGoToTheEvenNeighbourOnBothSidesOfZero) {
    // Sums of eight with remainder 4: 0.5 -> 0, 1.5 -> 2, -0.5 -> 0, -1.5 -> -2.
    const std::map<int, double> cases = {{4, 0}, {12, 2},  {-4, 0}, {-12, -2},
                                         {5, 1}, {-5, -1}, {3, 0},  {-3, 0}};
    for (const auto& [sum, mean] : cases) {
        ScratchFolder scratch;
        HashSource source(plainInfo({2, 2, 2}, ValueType::i16),
                          [sum = sum](int x, int y, int z) { return x + y + z == 0 ? sum : 0; });
        import(scratch / "v.zarr", source);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        EXPECT_EQ(readLevel(StoreReader(scratch / "v.zarr", ram), 1).at(0), mean) << sum;
    }
}

TEST(StoreMetadata, EveryFieldComesBackExactly) {
    ScratchFolder scratch;
    VolumeInfo info = obliqueInfo();
    info.frameOfReference = "1.2.840.113619.2.30." + std::string(42, '7') + ".1"; // of 64 characters
    ASSERT_EQ(info.frameOfReference.size(), 64u);
    HashSource source(info);
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const VolumeInfo found = StoreReader(scratch / "v.zarr", ram).info();
    EXPECT_EQ(found.frameOfReference, info.frameOfReference);
    EXPECT_EQ(found.extentVoxels, info.extentVoxels);
    EXPECT_EQ(found.type, info.type);
    EXPECT_EQ(found.patientFromVoxel, info.patientFromVoxel);
    EXPECT_EQ(found.rescaleSlope, info.rescaleSlope);
    EXPECT_EQ(found.rescaleIntercept, info.rescaleIntercept);
    EXPECT_EQ(found.unit, info.unit);
    EXPECT_EQ(found.fillStored, info.fillStored);
    EXPECT_EQ(found.originalOrder, info.originalOrder);
    EXPECT_EQ(found.acquisition, info.acquisition);
    EXPECT_EQ(found.nonFiniteVoxels, info.nonFiniteVoxels);
    EXPECT_EQ(found.clampedVoxels, info.clampedVoxels);
}

TEST(StoreMetadata, TheSameVolumeGivesTheSameBytesWhateverTheThreads) {
    ScratchFolder scratch;
    for (const int threads : {1, 4}) {
        HashSource source(plainInfo({70, 90, 130}, ValueType::u16));
        import(scratch / std::to_string(threads), source, false, threads);
    }
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(scratch / "1"))
        if (entry.is_regular_file()) {
            ++files;
            EXPECT_TRUE(fileText(entry.path()) ==
                        fileText(scratch / "4" / fs::relative(entry.path(), scratch / "1")))
                << entry.path();
        }
    EXPECT_GT(files, 20u);
    // One voxel more or less is another volume.
    HashSource other(plainInfo({70, 90, 130}, ValueType::u16), [](int x, int, int) { return x; });
    import(scratch / "other", other);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "1", ram).contentHash(), StoreReader(scratch / "4", ram).contentHash());
    EXPECT_NE(StoreReader(scratch / "1", ram).contentHash(),
              StoreReader(scratch / "other", ram).contentHash());
}

TEST(StoreMetadata, TextsAreCutToPlainAscii) {
    ScratchFolder scratch;
    VolumeInfo info = plainInfo({2, 2, 2}, ValueType::u8);
    info.acquisition.kernel = std::string("B\xff\n\x7f") + std::string(200, 'x');
    HashSource source(info);
    import(scratch / "v.zarr", source);
    MemoryBudget ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().acquisition.kernel, "B???" + std::string(60, 'x'));
}

// What is no UID is no frame: the store is as one of a source without.
TEST(StoreMetadata, AFrameOfReferenceIsAUidOrNone) {
    ScratchFolder scratch;
    MemoryBudget ram("RAM", "--ram", kPlenty);
    std::string without, hash;
    for (const std::string& frame :
         {std::string(), std::string("PLANTED"), std::string(65, '1'), std::string("1.2\n3"),
          std::string(".1"), std::string(1'000'000, '1'), std::string("1.2\0", 4), std::string("1.2.3")}) {
        VolumeInfo info = plainInfo({2, 2, 2}, ValueType::u8);
        info.frameOfReference = frame;
        HashSource source(info);
        import(scratch / "v.zarr", source, true);
        const StoreReader reader(scratch / "v.zarr", ram);
        const bool isUid = frame == "1.2.3";
        EXPECT_EQ(reader.info().frameOfReference, isUid ? frame : "");
        const std::string text = fileText(scratch / "v.zarr/zarr.json");
        if (frame.empty()) {
            without = text;
            hash = reader.contentHash();
        }
        EXPECT_EQ(text == without, !isUid) << frame.substr(0, 20);
        EXPECT_EQ(reader.contentHash(), hash) << "it is that of the voxels";
    }
}

TEST(Store, ChunksOfNothingButFillAreNotWritten) {
    ScratchFolder scratch;
    VolumeInfo info = plainInfo({70, 40, 40}, ValueType::i16);
    info.fillStored = -1000;
    HashSource source(info, [](int x, int, int) { return x >= 64 ? 5 : -1000; });
    const ImportReport report = import(scratch / "v.zarr", source);
    EXPECT_EQ(report.chunksWritten, 4u + 1 + 1 + 1 + 1 + 1); // level 1: x = 32..34 is the second chunk
    MemoryBudget ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    EXPECT_EQ(readLevel(store, 0).at(0), -1000);
    EXPECT_EQ(readLevel(store, 0).at(69), 5);

    HashSource air(info, [](int, int, int) { return -1000; });
    EXPECT_EQ(import(scratch / "air.zarr", air).chunksWritten, 0u);
    EXPECT_FALSE(fs::exists(scratch / "air.zarr/0/c"));
    EXPECT_EQ(readLevel(StoreReader(scratch / "air.zarr", ram), 0), std::vector<double>(70 * 40 * 40, -1000));
}

// Shards begin anew: two that hold the same are the same, byte for byte.
TEST(Store, AShardKeepsNothingOfTheOneBefore) {
    ScratchFolder scratch;
    HashSource source(plainInfo({5, 2, 1024}, ValueType::u8), [](int x, int y, int z) {
        return static_cast<double>(mixed(static_cast<std::uint64_t>(x + 8 * y + 64 * (z % 512))) & 0xFF);
    });
    import(scratch / "v.zarr", source);
    EXPECT_TRUE(fileText(scratch / "v.zarr/0/c/0/0/0") == fileText(scratch / "v.zarr/0/c/1/0/0"));
}

TEST(Crc32c, KnownValuesAndPieces) {
    const std::string text = "123456789";
    const auto bytes = std::as_bytes(std::span(text));
    EXPECT_EQ(crc32c(bytes), 0xE3069283u);
    EXPECT_EQ(crc32c({}), 0u);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
        EXPECT_EQ(crc32c(bytes.subspan(cut), crc32c(bytes.first(cut))), 0xE3069283u);
    EXPECT_EQ(crc32c(std::vector<std::byte>(32)), 0x8A9136AAu); // RFC 3720, B.4: 32 zeros
    std::mt19937 random(3);
    std::vector<std::byte> any(300);
    for (std::byte& byte : any)
        byte = static_cast<std::byte>(random());
    for (std::size_t first = 0; first < 9; ++first)
        for (std::size_t count = 0; first + count <= any.size(); count += 1 + count / 7) {
            const auto part = std::span(any).subspan(first, count);
            ASSERT_EQ(crc32c(part, 0x12345678u), crc32cByTables(part, 0x12345678u)) << first << ", " << count;
        }
}

// -- interoperability
// ----------------------------------------------------------------------------------------------

/// Writes stores and raw copies of every level where TESSERA_INTEROP_OUT says, for tests/zarrita to compare.
TEST(Interop, WriteStoresForZarrita) {
    const char* out = std::getenv("TESSERA_INTEROP_OUT");
    if (!out)
        GTEST_SKIP() << "TESSERA_INTEROP_OUT is not set; tests/zarrita sets it";
    for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32}) {
        VolumeInfo info = obliqueInfo();
        info.extentVoxels = {70, 90, 130};
        if (type == ValueType::i16)
            info.extentVoxels = {530, 35, 40}; // two shards
        info.type = type;
        info.fillStored = 3;
        const fs::path folder = fs::path(out) / name(type);
        fs::create_directories(folder);
        // A block of fill, so that some chunks are left out.
        const HashSource noise(info);
        HashSource source(info,
                          [&](int x, int y, int z) { return x < 34 && y < 64 ? 3 : noise.valueAt(x, y, z); });
        EXPECT_GT(import(folder / "v.zarr", source, true).chunksFill, 0u);
        MemoryBudget ram("RAM", "--ram", kPlenty);
        const StoreReader store(folder / "v.zarr", ram);
        for (int level = 0; level < kLevelCount; ++level) {
            const auto values = readLevel(store, level);
            std::ofstream raw(folder / (std::to_string(level) + ".f64"), std::ios::binary);
            raw.write(reinterpret_cast<const char*>(values.data()),
                      static_cast<std::streamsize>(values.size() * sizeof(double)));
        }
    }
}

} // namespace
} // namespace tessera
