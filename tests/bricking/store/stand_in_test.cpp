// tests/bricking/store/stand_in_test.cpp: a coarser level stands in for a damaged chunk, and it is noted.
#include "tests/support/bricking_store_tools.h"

#include "bricking/analysis/body/kept_table.h"
#include "bricking/statistics/local_histograms.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/stand_in_reader.h"
#include "bricking/store/zarr_metadata.h"

#include <cstring>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Damages a chunk of a shard of so many chunks, by its place in the index.
void damage(const fs::path& shard, std::size_t chunks, std::size_t entry) {
    std::string text = fileText(shard);
    std::uint64_t offset = 0;
    std::memcpy(&offset, text.data() + text.size() - 4 - 16 * chunks + 16 * entry, 8);
    text[offset + 25] = static_cast<char>(text[offset + 25] ^ 8);
    setFileText(shard, text);
}

/// Linear along every axis: trilinear samples of any level are exact, but for halves that levels are rounded
/// to.
class StandIn : public testing::Test {
  protected:
    void SetUp() override {
        HashSource source(plainInfo(extent, ValueType::f32),
                          [](int x, int y, int z) { return 8.0 * x - 16.0 * y + 32.0 * z; });
        import(path, source);
    }
    std::vector<float> read(const StoreReader& store, const ChunkKey& key) const {
        std::vector<float> values(cellCount(glm::ivec3(kChunkExtent)));
        store.readChunk(key, std::as_writable_bytes(std::span(values)));
        return values;
    }
    glm::ivec3 extent{70, 64, 64}; // 3x2x2 chunks, 2x1x1, 1
    ScratchFolder scratch;
    fs::path path = scratch / "v.zarr";
    MemoryBudget ram{"RAM", "--ram", kPlenty};
};

TEST_F(StandIn, AWholeStoreIsReadAsEver) {
    const StoreReader plain(path, ram);
    const StandInReader store(path, ram);
    EXPECT_EQ(read(store, {0, 1, 1, 1}), read(plain, {0, 1, 1, 1}));
    EXPECT_EQ(store.damagedCount(), 0u);
    EXPECT_FALSE(hasStandIns(store));
    EXPECT_FALSE(hasStandIns(plain));
}

TEST_F(StandIn, TheNextCoarserWholeLevelIsTakenAndNotedOnce) {
    const auto whole = read(StoreReader(path, ram), {0, 1, 0, 1});
    damage(path / "0/c/0/0/0", 12, 7); // [z][y][x]: chunk (1,0,1)
    for (const int levels : {1, 2}) {
        if (levels == 2)
            damage(path / "1/c/0/0/0", 2, 0);
        EXPECT_THROW(read(StoreReader(path, ram), {0, 1, 0, 1}), InputError);
        const StandInReader store(path, ram);
        const auto values = read(store, {0, 1, 0, 1});
        EXPECT_EQ(read(store, {0, 1, 0, 1}), values);
        // Away from the ends of the coarse chunk, where its neighbours are not asked.
        const int edge = levels == 1 ? 1 : 2;
        for (int z = 0; z < kChunkExtent - edge; ++z)
            for (int y = edge; y < kChunkExtent; ++y)
                for (int x = 0; x < kChunkExtent - edge; ++x) {
                    const std::size_t at = linearIndex({x, y, z}, glm::ivec3(kChunkExtent));
                    ASSERT_NEAR(values[at], whole[at], 1e-3) << levels << ": " << x << " " << y << " " << z;
                }
        ASSERT_EQ(store.damagedCount(), 1u);
        const DamagedChunk noted = store.damaged().front();
        EXPECT_EQ(noted.key, (ChunkKey{0, 1, 0, 1}));
        EXPECT_EQ(noted.drawnFrom, levels);
        EXPECT_THAT(noted.why, AllOf(HasSubstr("0/c/0/0/0"), HasSubstr("level 0 chunk (1,0,1)")));
        EXPECT_TRUE(hasStandIns(store));
    }
}

TEST_F(StandIn, ACoarserLevelIsDrawnFromTheOneAfterIt) {
    HashSource source(plainInfo({140, 8, 8}, ValueType::f32), [](int x, int, int) { return 8.0 * x; });
    const fs::path wide = scratch / "wide.zarr"; // 5 chunks in a row, 3, 2
    import(wide, source);
    const auto whole = read(StoreReader(wide, ram), {1, 2, 0, 0});
    damage(wide / "1/c/0/0/0", 3, 2);
    const StandInReader store(wide, ram);
    const auto values = read(store, {1, 2, 0, 0});
    for (int x = 1; x < 5; ++x) { // of 6 samples
        const std::size_t at = linearIndex({x, 1, 1}, glm::ivec3(kChunkExtent));
        EXPECT_NEAR(values[at], whole[at], 1e-3) << x;
    }
    ASSERT_EQ(store.damagedCount(), 1u);
    EXPECT_EQ(store.damaged().front().key, (ChunkKey{1, 2, 0, 0}));
    EXPECT_EQ(store.damaged().front().drawnFrom, 2);
}

TEST_F(StandIn, BeyondTheEdgeIsFillAsEver) {
    const auto whole = read(StoreReader(path, ram), {0, 2, 1, 0});
    damage(path / "0/c/0/0/0", 12, 5); // chunk (2,1,0): 6 voxels wide
    const StandInReader store(path, ram);
    const auto values = read(store, {0, 2, 1, 0});
    for (int x = 6; x < kChunkExtent; ++x)
        EXPECT_EQ(values[static_cast<std::size_t>(x)], whole[static_cast<std::size_t>(x)]);
    EXPECT_NEAR(values[linearIndex({3, 9, 9}, glm::ivec3(kChunkExtent))],
                whole[linearIndex({3, 9, 9}, glm::ivec3(kChunkExtent))], 1e-3);
}

/// Every chunk of every level, from each coarser one, by the definition: samples of a coarser level lie in
/// the middle of 2^n finer ones, and what lies beyond the coarse chunk is as its last sample. Names of labels
/// cannot be mixed: each is that of the coarse voxel that holds it.
TEST_F(StandIn, EveryChunkIsTheInterpolationOfACoarserOne) {
    static constexpr double kFill = 7;
    const glm::ivec3 size(70, 37, 66);
    for (const bool areNames : {false, true})
        for (const ValueType type : {ValueType::u8, ValueType::i16, ValueType::u16, ValueType::f32}) {
            if (areNames && type != ValueType::u16)
                continue;
            const fs::path folder = scratch / ("all" + std::to_string(areNames) + name(type));
            VolumeInfo info = plainInfo(size, type);
            info.fillStored = kFill;
            // Whole numbers: all sums are exact.
            HashSource source(info, [](int x, int y, int z) {
                return static_cast<double>(mixed(static_cast<std::uint64_t>((z * 100 + y) * 100 + x)) % 200) +
                       10;
            });
            import(folder, source);
            std::vector<std::vector<double>> levels;
            for (int level = 0; level < kLevelCount; ++level)
                levels.push_back(readLevel(StoreReader(folder, ram), level));
            if (areNames) { // which the metadata say: behind an address no folder is looked for
                const std::string file = (folder / "zarr.json").string();
                StoreMetadata metadata = parseGroup(fileText(file), file);
                metadata.rule = kMajorityRule;
                setFileText(file, groupDocument(metadata));
            }
            for (int from = 1; from < kLevelCount; ++from) {
                fs::remove_all(folder / std::to_string(from - 1) / "c");
                const StandInReader store(folder, ram);
                const glm::ivec3 coarse = levelExtent(size, from);
                const auto& samples = levels[static_cast<std::size_t>(from)];
                for (int level = 0; level < from; ++level) {
                    const int n = from - level;
                    const auto beyond = [](double padding) { ASSERT_EQ(padding, kFill); };
                    const std::vector<double> found = readLevel(store, level, beyond);
                    const glm::ivec3 fine = levelExtent(size, level);
                    for (int z = 0; z < fine.z; ++z)
                        for (int y = 0; y < fine.y; ++y)
                            for (int x = 0; x < fine.x; ++x) {
                                const glm::ivec3 at(x, y, z);
                                // Of the coarse chunk that holds the chunk.
                                const glm::ivec3 first = (at / kChunkExtent >> n) * kChunkExtent;
                                const glm::ivec3 last = glm::min(first + kChunkExtent, coarse) - 1;
                                glm::dvec3 place = (glm::dvec3(at) + 0.5) / std::ldexp(1.0, n) - 0.5;
                                if (areNames)
                                    place = glm::dvec3(at >> n);
                                const glm::ivec3 low(glm::floor(place));
                                double expected = 0;
                                for (int corner = 0; corner < 8; ++corner) {
                                    const glm::ivec3 to(corner & 1, corner >> 1 & 1, corner >> 2);
                                    double weight = 1;
                                    for (int axis = 0; axis < 3; ++axis) {
                                        const double share = place[axis] - low[axis];
                                        weight *= to[axis] == 1 ? share : 1 - share;
                                    }
                                    expected +=
                                        weight *
                                        samples[linearIndex(glm::clamp(low + to, first, last), coarse)];
                                }
                                ASSERT_NEAR(found[linearIndex(at, fine)], expected,
                                            type == ValueType::f32 ? 1e-3 : 0.5001)
                                    << name(type) << " level " << level << " from " << from << ": " << x
                                    << ' ' << y << ' ' << z;
                            }
                }
                EXPECT_FALSE(store.damaged().empty());
                for (const DamagedChunk& chunk : store.damaged())
                    EXPECT_EQ(chunk.drawnFrom, from);
            }
        }
}

// A thousand are told by their places, in their order; all are counted.
TEST_F(StandIn, AThousandAreNamedAndAllAreCounted) {
    HashSource source(plainInfo({32 * 1003, 1, 1}, ValueType::u8));
    const fs::path row = scratch / "row.zarr";
    import(row, source);
    fs::remove_all(row / "0/c");
    const StandInReader store(row, ram);
    std::vector<std::byte> chunk(store.chunkBytes());
    for (int i = 1002; i >= 0; --i) {
        store.readChunk({0, i, 0, 0}, chunk);
        ASSERT_EQ(store.damagedCount(), static_cast<std::uint64_t>(1003 - i));
    }
    const std::vector<DamagedChunk> named = store.damaged();
    ASSERT_EQ(named.size(), 1000u);
    for (std::size_t n = 0; n < named.size(); ++n)
        EXPECT_EQ(named[n].key, (ChunkKey{0, static_cast<int>(n) + 3, 0, 0}));
}

// By level, then as chunks lie in a volume: z, y, x.
TEST_F(StandIn, DamageIsToldInTheOrderOfItsPlaces) {
    fs::remove(path / "0/c/0/0/0");
    fs::remove(path / "1/c/0/0/0");
    const StandInReader store(path, ram);
    std::vector<ChunkKey> order;
    for (int level = 0; level < 2; ++level)
        for (int k = 0; k < (level == 0 ? 2 : 1); ++k)
            for (int j = 0; j < (level == 0 ? 2 : 1); ++j)
                for (int i = 0; i < (level == 0 ? 3 : 2); ++i)
                    order.push_back({level, i, j, k});
    for (std::size_t n = 0; n < order.size(); ++n)
        read(store, order[n * 5 % order.size()]); // 14 chunks, each once
    const std::vector<DamagedChunk> told = store.damaged();
    ASSERT_EQ(told.size(), order.size());
    for (std::size_t n = 0; n < order.size(); ++n)
        EXPECT_EQ(told[n].key, order[n]) << n;
}

TEST_F(StandIn, ALostShardIsDrawnCoarserToo) {
    fs::remove(path / "0/c/0/0/0");
    const StandInReader store(path, ram);
    for (int i = 0; i < 3; ++i)
        read(store, {0, i, 0, 0});
    EXPECT_EQ(store.damagedCount(), 3u);
    EXPECT_THAT(store.damaged().back().why, HasSubstr("no such file"));
}

TEST_F(StandIn, WhereNoCoarserLevelIsWholeItIsRefused) {
    damage(path / "0/c/0/0/0", 12, 0);
    for (int level = 1; level < kLevelCount; ++level)
        fs::remove(path / (std::to_string(level) + "/c/0/0/0"));
    const StandInReader store(path, ram);
    EXPECT_THAT(
        [&] {
            read(store, {0, 0, 0, 0});
        },
        ThrowsMessage<InputError>(HasSubstr("level 0 chunk (0,0,0)")));
    EXPECT_THAT([&] { read(store, {5, 0, 0, 0}); }, ThrowsMessage<InputError>(HasSubstr("5/c/0/0/0")));
    EXPECT_EQ(store.damagedCount(), 0u);
}

TEST_F(StandIn, WhatFollowsFromThemIsNotKept) {
    fs::remove(path / "1/c/0/0/0");
    const StandInReader store(path, ram);
    LocalHistogramSettings settings;
    settings.radiusMm = 4;
    settings.representatives = 16;
    const Statistics statistics = loadStatistics(store, ram, 1);
    localHistogramsOf(store, store, 0, statistics, settings, ram, 1);
    EXPECT_TRUE(hasStandIns(store));
    EXPECT_FALSE(fs::exists(path / "stats/histograms"));
    fs::remove_all(path / "stats/table");
    fs::remove(path / "0/c/0/0/0");
    tableOf(store, ram, 1);
    EXPECT_FALSE(fs::exists(path / "stats/table"));
}

} // namespace
} // namespace tessera
