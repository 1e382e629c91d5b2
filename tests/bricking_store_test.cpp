// tests/bricking_store_test.cpp: what is written is read back bit for bit, and what is damaged is refused by
// name.
#include "bricking_test_volumes.h"

#include "bricking/ray_statistics.h"
#include "bricking/statistics.h"
#include "bricking/store/crc32c.h"
#include "bricking/store/store_writer.h"

#include <algorithm>
#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <set>
#include <tuple>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr std::size_t kPlenty = 256u << 20;

ImportReport import(const fs::path& path, SlabSource& source, bool force = false, int threads = 2,
                    std::size_t budget = kPlenty, bool durable = false) {
    Ledger ram("RAM", "--ram", budget);
    ImportOptions options;
    options.force = force;
    options.threads = threads;
    options.durable = durable;
    const ImportReport report = importToStore(source, path, ram, options);
    EXPECT_EQ(ram.usedBytes(), 0u);
    EXPECT_LE(ram.peakBytes(), budget);
    return report;
}

/// The rule of bricking/pyramid.h, independently: rint() rounds halves to even.
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

    Ledger ram("RAM", "--ram", kPlenty);
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
        Ledger ram("RAM", "--ram", kPlenty);
        EXPECT_EQ(readLevel(StoreReader(scratch / "v.zarr", ram), 1).at(0), mean) << sum;
    }
}

VolumeInfo obliqueInfo() {
    VolumeInfo info = plainInfo({21, 35, 40}, ValueType::i16);
    info.patientFromVoxel = patientFromVoxelOf({-101.3, 0.1, 1e-3}, {0.68, 0.1, -0.02}, {-0.1, 0.7, 1.0 / 3},
                                               {0.01, -0.4, 1.1}); // oblique and sheared
    info.rescaleSlope = 0.1;
    info.rescaleIntercept = -1024.5;
    info.unit = "HU";
    info.fillStored = -1024;
    info.originalOrder = {{2, 0, 1}, {true, false, true}};
    info.acquisition = {"CT", "B30f", 120, 1.5};
    info.nonFiniteVoxels = 3;
    info.clampedVoxels = std::uint64_t{1} << 40;
    return info;
}

TEST(StoreMetadata, EveryFieldComesBackExactly) {
    ScratchFolder scratch;
    const VolumeInfo info = obliqueInfo();
    HashSource source(info);
    import(scratch / "v.zarr", source);
    Ledger ram("RAM", "--ram", kPlenty);
    const VolumeInfo found = StoreReader(scratch / "v.zarr", ram).info();
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
    Ledger ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "1", ram).contentHash(), StoreReader(scratch / "4", ram).contentHash());
    EXPECT_NE(StoreReader(scratch / "1", ram).contentHash(),
              StoreReader(scratch / "other", ram).contentHash());
}

TEST(StoreMetadata, TextsAreCutToPlainAscii) {
    ScratchFolder scratch;
    VolumeInfo info = plainInfo({2, 2, 2}, ValueType::u8);
    info.acquisition.kernel = std::string("B\xff\n") + std::string(200, 'x');
    HashSource source(info);
    import(scratch / "v.zarr", source);
    Ledger ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().acquisition.kernel, "B??" + std::string(61, 'x'));
}

TEST(Store, ChunksOfNothingButFillAreNotWritten) {
    ScratchFolder scratch;
    VolumeInfo info = plainInfo({70, 40, 40}, ValueType::i16);
    info.fillStored = -1000;
    HashSource source(info, [](int x, int, int) { return x >= 64 ? 5 : -1000; });
    const ImportReport report = import(scratch / "v.zarr", source);
    EXPECT_EQ(report.chunksWritten, 4u + 1 + 1 + 1 + 1 + 1); // level 1: x = 32..34 is the second chunk
    Ledger ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    EXPECT_EQ(readLevel(store, 0).at(0), -1000);
    EXPECT_EQ(readLevel(store, 0).at(69), 5);

    HashSource air(info, [](int, int, int) { return -1000; });
    EXPECT_EQ(import(scratch / "air.zarr", air).chunksWritten, 0u);
    EXPECT_FALSE(fs::exists(scratch / "air.zarr/0/c"));
    EXPECT_EQ(readLevel(StoreReader(scratch / "air.zarr", ram), 0), std::vector<double>(70 * 40 * 40, -1000));
}

// -- damage
// --------------------------------------------------------------------------------------------------------

/// A store of 33x47x65 and a way to read all of it: levels, then statistics, which are rebuilt where damaged.
class DamagedStore : public testing::Test {
  protected:
    void SetUp() override {
        HashSource source(plainInfo({33, 47, 65}, ValueType::u8));
        import(path, source);
        whole = readAll();
    }
    std::vector<double> readAll() const {
        Ledger ram("RAM", "--ram", kPlenty);
        const StoreReader store(path, ram);
        std::vector<double> all;
        for (int level = 0; level < kLevelCount; ++level) {
            const auto values = readLevel(store, level);
            all.insert(all.end(), values.begin(), values.end());
        }
        const Statistics statistics = loadStatistics(store, ram, 1);
        all.insert(all.end(), statistics.cellMin.begin(), statistics.cellMin.end());
        all.insert(all.end(), statistics.cellMax.begin(), statistics.cellMax.end());
        for (const std::uint64_t count : statistics.histogram)
            all.push_back(static_cast<double>(count));
        return all;
    }
    void flip(const fs::path& file, std::size_t bit) const {
        std::string text = fileText(path / file);
        text[bit / 8] = static_cast<char>(text[bit / 8] ^ (1 << (bit % 8)));
        setFileText(path / file, text);
    }
    ScratchFolder scratch;
    fs::path path = scratch / "v.zarr";
    std::vector<double> whole;
};

TEST_F(DamagedStore, AFlippedBitInAPayloadIsRefusedAndTheChunkNamed) {
    // Index of 0/c/0/0/0: chunks are 2 x 2 x 3, so entry 1 is chunk (1,0,0).
    const std::string text = fileText(path / "0/c/0/0/0");
    std::uint64_t offset = 0, bytes = 0;
    std::memcpy(&offset, text.data() + text.size() - 4 - 16 * 12 + 16, 8);
    std::memcpy(&bytes, text.data() + text.size() - 4 - 16 * 12 + 24, 8);
    flip("0/c/0/0/0", 8 * (offset + bytes / 2) + 3);
    Ledger ram("RAM", "--ram", kPlenty);
    const StoreReader store(path, ram);
    std::vector<std::byte> chunk(store.chunkBytes());
    EXPECT_THAT(
        [&] {
            store.readChunk({0, 1, 0, 0}, chunk);
        },
        ThrowsMessage<InputError>(AllOf(HasSubstr("0/c/0/0/0"), HasSubstr("level 0 chunk (1,0,0)"),
                                        HasSubstr("expected checksum"))));
    EXPECT_NO_THROW(store.readChunk({0, 0, 0, 0}, chunk)) << "undamaged chunks stay readable";
}

TEST_F(DamagedStore, EverySingleFlippedBitInAShardIsRefused) {
    std::mt19937 random(20);
    for (const char* file : {"0/c/0/0/0", "1/c/0/0/0", "4/c/0/0/0", "5/c/0/0/0"}) {
        const std::string text = fileText(path / file);
        const std::size_t index = text.size() < 260 ? 20 : 16 * 12 + 4; // bytes; every bit of a few entries
        for (int i = 0; i < 20; ++i) {
            const std::size_t bit =
                i < 10 ? random() % (8 * text.size())
                       : 8 * (text.size() - index) + random() % (8 * std::min(index, text.size()));
            flip(file, bit);
            EXPECT_THROW(readAll(), InputError) << file << " bit " << bit;
            setFileText(path / file, text);
        }
    }
    EXPECT_TRUE(readAll() == whole);
}

TEST_F(DamagedStore, AFlippedBitInMetadataIsRefusedOrWithoutEffect) {
    std::mt19937 random(21);
    int refused = 0;
    for (const char* file : {"zarr.json", "0/zarr.json", "3/zarr.json"}) {
        const std::string text = fileText(path / file);
        for (int i = 0; i < 50; ++i) {
            const std::size_t bit = random() % (8 * text.size());
            flip(file, bit);
            Ledger ram("RAM", "--ram", kPlenty);
            try {
                EXPECT_EQ(StoreReader(path, ram).info().patientFromVoxel,
                          plainInfo({1, 1, 1}, ValueType::u8).patientFromVoxel);
            } catch (const InputError& problem) {
                EXPECT_THAT(problem.what(), HasSubstr(file));
                ++refused;
            }
            setFileText(path / file, text);
        }
    }
    EXPECT_GT(refused, 120); // white space may change into other white space
}

TEST_F(DamagedStore, DamagedStatisticsAreRebuilt) {
    std::mt19937 random(22);
    for (const char* file : {"stats/zarr.json", "stats/cell_min/c/0/0/0", "stats/cell_max/zarr.json"}) {
        const std::string text = fileText(path / file);
        for (int i = 0; i < 10; ++i) {
            flip(file, random() % (8 * text.size()));
            EXPECT_TRUE(readAll() == whole) << file;
            setFileText(path / file, text);
        }
        fs::remove(path / file);
        EXPECT_TRUE(readAll() == whole) << file;
        setFileText(path / file, text);
    }
    fs::remove_all(path / "stats");
    EXPECT_TRUE(readAll() == whole);
}

TEST_F(DamagedStore, ATruncatedFileIsRefused) {
    std::mt19937 random(23);
    for (const char* file : {"0/c/0/0/0", "2/c/0/0/0", "zarr.json", "0/zarr.json"}) {
        const std::string text = fileText(path / file);
        const std::size_t n = text.size();
        std::vector<std::size_t> lengths = {0, 1, n / 2, n - 1, n - 2, n - 4, n - 5, n - 20};
        for (int i = 0; i < 8; ++i)
            lengths.push_back(random() % n);
        for (const std::size_t length : lengths) {
            if (text.substr(length) == "\n")
                continue; // the last line end carries nothing
            setFileText(path / file, text.substr(0, length));
            EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr(file))) << length;
        }
        setFileText(path / file, text);
    }
}

TEST_F(DamagedStore, ALostShardIsNotTakenForFill) {
    fs::remove(path / "1/c/0/0/0");
    EXPECT_THAT([&] { readAll(); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("1/c/0/0/0"), HasSubstr("level 1 chunk (0,0,0)"))));
}

TEST_F(DamagedStore, AShardOfAnotherStoreIsRefused) {
    // Whole and with right checksums, but not the one that was written here.
    HashSource source(plainInfo({33, 47, 65}, ValueType::u8),
                      [](int x, int y, int z) { return (x + y * z) % 200; });
    import(scratch / "other.zarr", source);
    fs::copy_file(scratch / "other.zarr/0/c/0/0/0", path / "0/c/0/0/0", fs::copy_options::overwrite_existing);
    EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr("another index")));
}

TEST_F(DamagedStore, LinksFifosAndMissingPartsAreRefused) {
    fs::rename(path / "0/c/0/0/0", scratch / "elsewhere");
    fs::create_symlink(scratch / "elsewhere", path / "0/c/0/0/0");
    EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr("symbolic link")));
    fs::remove(path / "0/c/0/0/0");
    fs::create_directory(path / "0/c/0/0/0");
    EXPECT_THROW(readAll(), InputError);
    fs::remove(path / "3/zarr.json");
    EXPECT_THAT([&] { readAll(); }, ThrowsMessage<InputError>(HasSubstr("3/zarr.json")));
    Ledger ram("RAM", "--ram", kPlenty);
    EXPECT_THROW(StoreReader(scratch / "nowhere.zarr", ram), InputError);
}

TEST_F(DamagedStore, AnEditedLevelIsRefusedWithTheKey) {
    std::string text = fileText(path / "2/zarr.json");
    text.replace(text.find("bitshuffle"), 10, "noshuffle");
    setFileText(path / "2/zarr.json", text);
    EXPECT_THAT([&] { readAll(); },
                ThrowsMessage<InputError>(
                    AllOf(HasSubstr("2/zarr.json"), HasSubstr("/shuffle"), HasSubstr("noshuffle"))));
}

// -- importing
// -----------------------------------------------------------------------------------------------------

TEST(Import, AnExistingStoreIsReplacedOnlyByForce) {
    ScratchFolder scratch;
    HashSource first(plainInfo({5, 6, 7}, ValueType::u8));
    import(scratch / "v.zarr", first, false, 1, kPlenty, true);
    HashSource second(plainInfo({8, 8, 8}, ValueType::i16));
    EXPECT_THAT([&] { import(scratch / "v.zarr", second); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("v.zarr"), HasSubstr("--force"))));
    Ledger ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().extentVoxels, glm::ivec3(5, 6, 7));
    import(scratch / "v.zarr", second, true, 1, kPlenty, true);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().extentVoxels, glm::ivec3(8, 8, 8));
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
}

TEST(Import, WhatIsNoStoreIsNeverReplaced) {
    ScratchFolder scratch;
    fs::create_directory(scratch / "photos");
    setFileText(scratch / "photos/zarr.json", "{}");
    HashSource source(plainInfo({5, 6, 7}, ValueType::u8));
    EXPECT_THROW(import(scratch / "photos", source, true), InputError);
    EXPECT_EQ(fileText(scratch / "photos/zarr.json"), "{}");
    EXPECT_FALSE(isStore(scratch / "photos"));
    EXPECT_THROW(import(scratch / "no-such-folder/v.zarr", source), InputError);
}

TEST(Import, AFailingSourceLeavesNothingBehind) {
    ScratchFolder scratch;
    HashSource good(plainInfo({40, 40, 10}, ValueType::u8));
    import(scratch / "v.zarr", good);
    HashSource source(plainInfo({40, 40, 100}, ValueType::u8));
    source.failAtZ = 70;
    EXPECT_THROW(import(scratch / "v.zarr", source, true), InputError);
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
    Ledger ram("RAM", "--ram", kPlenty);
    EXPECT_EQ(StoreReader(scratch / "v.zarr", ram).info().extentVoxels.z, 10) << "the old store must stay";
    VolumeInfo info = plainInfo({4, 4, 4}, ValueType::f32);
    HashSource hole(info, [](int x, int, int) { return x == 2 ? NAN : 1; });
    EXPECT_THROW(import(scratch / "hole.zarr", hole), InputError);
    EXPECT_EQ(entriesIn(scratch.path()), 1u);
}

TEST(Import, WhatCannotBeStoredIsRefused) {
    ScratchFolder scratch;
    const auto refused = [&](auto change) {
        VolumeInfo info = plainInfo({4, 4, 4}, ValueType::u8);
        change(info);
        HashSource source(info);
        EXPECT_THROW(import(scratch / "v.zarr", source), InputError);
    };
    refused([](VolumeInfo& info) { info.extentVoxels.y = 0; });
    refused([](VolumeInfo& info) { info.fillStored = 300; });
    refused([](VolumeInfo& info) { info.fillStored = 0.5; });
    refused([](VolumeInfo& info) { info.patientFromVoxel[2] = info.patientFromVoxel[1]; });
    refused([](VolumeInfo& info) { info.rescaleSlope = 0; });
    refused([](VolumeInfo& info) { info.acquisition.tubeVoltageKv = NAN; });
    EXPECT_EQ(entriesIn(scratch.path()), 0u);
}

TEST(Import, KeepsItsBudgetAndNamesTheFloor) {
    for (const glm::ivec3& extent : {glm::ivec3(1, 1, 1), glm::ivec3(70, 90, 130), glm::ivec3(600, 20, 5)})
        for (const ValueType type : {ValueType::u8, ValueType::f32})
            for (const int threads : {1, 3}) {
                ScratchFolder scratch;
                const VolumeInfo info = plainInfo(extent, type);
                const std::size_t floor = importFloorBytes(info, threads);
                HashSource refused(info);
                EXPECT_THAT(
                    [&] { import(scratch / "v.zarr", refused, false, threads, floor - 1); },
                    ThrowsMessage<InputError>(AllOf(HasSubstr(formatBytes(floor)), HasSubstr("--ram"))));
                EXPECT_EQ(entriesIn(scratch.path()), 0u);
                HashSource source(info);
                import(scratch / "v.zarr", source, false, threads, floor); // checks the peak
                Ledger ram("RAM", "--ram", kPlenty);
                EXPECT_EQ(readLevel(StoreReader(scratch / "v.zarr", ram), 0).at(0), source.valueAt(0, 0, 0));
            }
}

// -- statistics
// ----------------------------------------------------------------------------------------------------

TEST(StoreStatistics, EqualBruteForce) {
    for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32}) {
        ScratchFolder scratch;
        const glm::ivec3 n(70, 47, 65);
        // Mostly equal, rarely extreme: so that most cells differ in what their apron sees.
        HashSource source(plainInfo(n, type), [](int x, int y, int z) {
            const auto h = mixed(static_cast<std::uint64_t>(x + 100 * y + 10000 * z));
            return h % 97 == 0 ? static_cast<double>(h >> 57) : 40;
        });
        import(scratch / "v.zarr", source);
        Ledger ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        const Statistics statistics = loadStatistics(store, ram, 2);
        ASSERT_EQ(statistics.cells, cellGrid(n));
        EXPECT_GT(ram.usedBytes(), statistics.cellMin.size() * 8);
        for (int k = 0; k < statistics.cells.z; ++k)
            for (int j = 0; j < statistics.cells.y; ++j)
                for (int i = 0; i < statistics.cells.x; ++i) {
                    double lo = 1e9, hi = -1e9;
                    for (int z = std::max(8 * k - 1, 0); z <= std::min(8 * k + 8, n.z - 1); ++z)
                        for (int y = std::max(8 * j - 1, 0); y <= std::min(8 * j + 8, n.y - 1); ++y)
                            for (int x = std::max(8 * i - 1, 0); x <= std::min(8 * i + 8, n.x - 1); ++x) {
                                lo = std::min(lo, source.valueAt(x, y, z));
                                hi = std::max(hi, source.valueAt(x, y, z));
                            }
                    const std::size_t at = linearIndex({i, j, k}, statistics.cells);
                    ASSERT_EQ(statistics.cellMin[at], lo) << i << " " << j << " " << k;
                    ASSERT_EQ(statistics.cellMax[at], hi) << i << " " << j << " " << k;
                }
        const auto coarsest = readLevel(store, 5);
        ASSERT_EQ(statistics.brickMean.size(), coarsest.size());
        EXPECT_TRUE(std::equal(coarsest.begin(), coarsest.end(), statistics.brickMean.begin()));
        const auto finest = readLevel(store, 0);
        EXPECT_EQ(statistics.lowest, *std::min_element(finest.begin(), finest.end()));
        EXPECT_EQ(statistics.highest, *std::max_element(finest.begin(), finest.end()));

        std::vector<std::uint64_t> histogram(kHistogramBins);
        const double width = (static_cast<double>(statistics.highest) - statistics.lowest) / kHistogramBins;
        for (const double v : finest)
            ++histogram[static_cast<std::size_t>(
                std::min(63.0, std::floor((v - statistics.lowest) / width)))];
        EXPECT_EQ(histogram, statistics.histogram);
        float lo = 0, hi = 0;
        statistics.brickRange({1, 1, 0}, lo, hi);
        double expectedLo = 1e9, expectedHi = -1e9;
        for (int z = 0; z <= 32; ++z)
            for (int y = 31; y < 47; ++y)
                for (int x = 31; x <= 64; ++x) {
                    expectedLo = std::min(expectedLo, source.valueAt(x, y, z));
                    expectedHi = std::max(expectedHi, source.valueAt(x, y, z));
                }
        EXPECT_EQ(lo, expectedLo);
        EXPECT_EQ(hi, expectedHi);
    }
}

/// A value of a level's field at p (voxels), by the definition, from the whole level.
double fieldAt(const std::vector<double>& values, const glm::ivec3& extent, int level, const glm::dvec3& p) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        glm::ivec3 sample;
        for (int axis = 0; axis < 3; ++axis) {
            const double at = p[axis] / std::ldexp(1.0, level) - 0.5, low = std::floor(at);
            const int bit = corner >> axis & 1;
            weight *= bit ? at - low : 1 - (at - low);
            sample[axis] = std::clamp(static_cast<int>(low) + bit, 0, extent[axis] - 1);
        }
        sum += weight * values[linearIndex(sample, extent)];
    }
    return sum;
}

/// Every stored ray must be a row of the brick, sampled at the documented places at every level.
TEST(RayStatistics, AreRowsOfTheBrickAtEveryLevel) {
    for (const ValueType type : {ValueType::i16, ValueType::f32}) {
        ScratchFolder scratch;
        const glm::ivec3 n(70, 47, 97), bricks = brickGrid(n);
        HashSource source(plainInfo(n, type), [](int x, int y, int z) {
            const auto h = mixed(static_cast<std::uint64_t>(x + 100 * y + 10000 * z));
            return std::floor(300 * std::sin(0.2 * x + 0.1 * y) * std::cos(0.15 * z)) +
                   static_cast<double>(h >> 58);
        });
        import(scratch / "v.zarr", source);
        Ledger ram("RAM", "--ram", kPlenty);
        const StoreReader store(scratch / "v.zarr", ram);
        std::vector<std::vector<double>> levels;
        for (int level = 0; level < kLevelCount; ++level)
            levels.push_back(readLevel(store, level));
        BrickRays rays = noBrickRays(store.info(), kBrickRayParts, ram);
        addBrickRays(store, std::vector<std::uint8_t>(cellCount(bricks), 1), rays, ram);
        std::set<std::tuple<std::size_t, int, int, int>> found;
        for (std::size_t brick = 0; brick < cellCount(bricks); ++brick) {
            const glm::ivec3 first = 32 * glm::ivec3(static_cast<int>(brick) % bricks.x,
                                                     static_cast<int>(brick) / bricks.x % bricks.y,
                                                     static_cast<int>(brick) / bricks.x / bricks.y);
            const glm::ivec3 size = glm::min(n - first, glm::ivec3(32));
            for (int p = 0; p < kBrickRayParts; ++p) {
                const BrickRayPart part = decodeRays(rays.part(rays.rowOf[brick], p));
                const double range = static_cast<double>(part.hi) - static_cast<double>(part.lo);
                for (int ray = 0; ray < kRaysPerPart; ++ray) {
                    const int axis = part.axis(ray), u = (axis + 1) % 3, w = (axis + 2) % 3;
                    bool matched = false;
                    for (int b = 0; b < size[w] && !matched; ++b)
                        for (int a = 0; a < size[u] && !matched; ++a) {
                            std::size_t code = static_cast<std::size_t>(ray * kSamplesPerRay);
                            matched = true;
                            for (int level = 0; level < kLevelCount && matched; ++level)
                                for (int j = 0; j < kRaySamples[static_cast<std::size_t>(level)] && matched;
                                     ++j) {
                                    glm::dvec3 at;
                                    at[axis] = raySampleAt(j, kRaySamples[static_cast<std::size_t>(level)],
                                                           size[axis]);
                                    at[u] = a + 0.5;
                                    at[w] = b + 0.5;
                                    const double value =
                                        fieldAt(levels[static_cast<std::size_t>(level)],
                                                levelExtent(n, level), level, glm::dvec3(first) + at);
                                    const double stored =
                                        static_cast<double>(part.lo) + range * part.codes[code++] / 255;
                                    matched = std::abs(value - stored) <= range * 0.502 / 255 + 1e-4;
                                }
                            if (matched)
                                found.insert({brick, axis, a, b});
                        }
                    EXPECT_TRUE(matched) << "brick " << brick << " part " << p << " ray " << ray;
                }
            }
        }
        EXPECT_GT(found.size(), 13 * cellCount(bricks)); // different rays, but for bricks a few voxels wide
    }
}

TEST(RayStatistics, ComeFromTheVoxelsWhereTheStoreHasNone) {
    ScratchFolder scratch;
    const glm::ivec3 n(70, 47, 97), bricks = brickGrid(n);
    HashSource source(plainInfo(n, ValueType::u16));
    import(scratch / "v.zarr", source);
    Ledger ram("RAM", "--ram", kPlenty);
    const StoreReader store(scratch / "v.zarr", ram);
    const std::size_t before = ram.usedBytes();
    const auto rowsOf = [&](std::vector<std::vector<std::uint8_t>> steps, int parts) {
        BrickRays rays = noBrickRays(store.info(), parts, ram);
        std::vector<std::uint8_t> all(cellCount(bricks));
        for (const auto& wanted : steps) {
            addBrickRays(store, wanted, rays, ram, 2);
            for (std::size_t b = 0; b < all.size(); ++b)
                all[b] |= wanted[b];
        }
        EXPECT_GE(ram.usedBytes(), before + rays.pages.size() * rays.pages[0].size());
        std::vector<std::vector<std::uint8_t>> rows;
        for (std::size_t b = 0; b < all.size(); ++b) {
            EXPECT_EQ(rays.rowOf[b] != BrickRays::kNoRow, all[b] != 0);
            rows.emplace_back();
            if (all[b])
                rows.back().assign(rays.row(rays.rowOf[b]).begin(), rays.row(rays.rowOf[b]).end());
        }
        return rows;
    };
    const std::vector<std::uint8_t> every(cellCount(bricks), 1);
    std::vector<std::uint8_t> some(cellCount(bricks)), rest(cellCount(bricks), 1);
    some[3] = some[11] = 1;
    const auto expected = rowsOf({every}, 2);
    EXPECT_EQ(rowsOf({some, every}, 2), expected); // step by step
    const auto few = rowsOf({some}, 2);
    EXPECT_EQ(few[3], expected[3]);
    EXPECT_TRUE(few[4].empty());
    const auto half = rowsOf({every}, 1);
    for (std::size_t b = 0; b < half.size(); ++b)
        EXPECT_TRUE(std::equal(half[b].begin(), half[b].end(), expected[b].begin()));
    EXPECT_EQ(ram.usedBytes(), before);

    const fs::path chunk = scratch / "v.zarr/stats/rays/1/c/1/0/0/0";
    std::string bytes = fileText(chunk);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 4);
    setFileText(chunk, bytes);
    EXPECT_EQ(rowsOf({every}, 2), expected);
    fs::remove(scratch / "v.zarr/stats/zarr.json");
    EXPECT_EQ(rowsOf({every}, 2), expected);
    EXPECT_EQ(rowsOf({some}, 2), few);
    const Statistics rebuilt = loadStatistics(store, ram, 2);
    EXPECT_EQ(rebuilt.brickMin.size(), cellCount(bricks));

    Ledger small("RAM", "--ram", 20000);
    BrickRays rays = noBrickRays(store.info(), 2, small);
    EXPECT_THAT([&] { addBrickRays(store, every, rays, small); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("rays of bricks"), HasSubstr("--ram"))));
    EXPECT_EQ(rays.rows, 0u);
}

TEST(StoreStatistics, BinsCoverTheRange) {
    EXPECT_EQ(histogramBin(5, 5, 5), 0);
    EXPECT_EQ(histogramBin(0, 0, 64), 0);
    EXPECT_EQ(histogramBin(0.999, 0, 64), 0);
    EXPECT_EQ(histogramBin(1, 0, 64), 1);
    EXPECT_EQ(histogramBin(64, 0, 64), 63);
    EXPECT_EQ(histogramBin(NAN, 0, 64), 0);
    EXPECT_EQ(histogramBin(1e300, 0, 64), 63);
}

TEST(Crc32c, KnownValuesAndPieces) {
    const std::string text = "123456789";
    const auto bytes = std::as_bytes(std::span(text));
    EXPECT_EQ(crc32c(bytes), 0xE3069283u);
    EXPECT_EQ(crc32c({}), 0u);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut)
        EXPECT_EQ(crc32c(bytes.subspan(cut), crc32c(bytes.first(cut))), 0xE3069283u);
    EXPECT_EQ(crc32c(std::vector<std::byte>(32)), 0x8A9136AAu); // RFC 3720, B.4: 32 zeros
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
        Ledger ram("RAM", "--ram", kPlenty);
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
