// tests/bricking/store/stand_in_test.cpp: a coarser level stands in for a damaged chunk, and it is noted.
#include "tests/support/bricking_store_tools.h"

#include "bricking/analysis/body/kept_table.h"
#include "bricking/statistics/local_histograms.h"
#include "bricking/store/stand_in_reader.h"

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
