// tests/bricking/cache/cache_test.cpp: the cache gives the right bytes, keeps its budget, joins, evicts in
// order, and neither hangs nor loses its head when chunks fail.
#include "tests/support/bricking_test_volumes.h"

#include "bricking/cache/brick_cache.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <thread>

// An exception's reference count lives in libstdc++.so, which is not instrumented: ThreadSanitizer does not
// see that the last holder, on whichever thread, comes after all others. Nothing else is suppressed.
extern "C" const char* __tsan_default_suppressions() {
    return "race:std::__exception_ptr::exception_ptr::_M_release\n";
}

namespace tessera {
namespace {

using namespace test;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr glm::ivec3 kExtent(130, 100, 70); // 5 x 4 x 3 chunks at level 0
constexpr std::size_t kPlenty = 256u << 20;

/// One small store for all tests, and the value of each chunk's first voxel.
class Cache : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<ScratchFolder>();
        HashSource source(plainInfo(kExtent, ValueType::u8));
        MemoryBudget ram("RAM", "--ram", kPlenty);
        ImportOptions options;
        options.durable = false;
        importToStore(source, *folder_ / "v.zarr", ram, options);
    }
    static void TearDownTestSuite() { folder_.reset(); }
    static std::vector<ChunkKey> allKeys() {
        std::vector<ChunkKey> keys;
        for (int level = 0; level < 3; ++level) {
            const glm::ivec3 grid = chunkGrid(kExtent, level);
            for (int k = 0; k < grid.z; ++k)
                for (int j = 0; j < grid.y; ++j)
                    for (int i = 0; i < grid.x; ++i)
                        keys.push_back({level, i, j, k});
        }
        return keys;
    }
    bool right(const ChunkKey& key, const ChunkPointer& chunk) const {
        std::vector<std::byte> expected(store.chunkBytes());
        store.readChunk(key, expected);
        return chunk->size == expected.size() &&
               std::equal(expected.begin(), expected.end(), chunk->bytes.get());
    }
    bool resident(BrickCache& cache, const ChunkKey& key) const {
        const auto before = cache.counters().hits;
        cache.get(key);
        return cache.counters().hits > before;
    }
    static inline std::unique_ptr<ScratchFolder> folder_;
    MemoryBudget ram{"RAM", "--ram", kPlenty};
    StoreReader store{*folder_ / "v.zarr", ram};
    const std::size_t chunk = store.chunkBytes();
};

TEST_F(Cache, ManyThreadsSmallBudget) {
    const std::size_t budget = 14 * chunk;
    MemoryBudget small("RAM", "--ram", budget);
    {
        BrickCache cache(store, small, budget, 2);
        const std::vector<ChunkKey> keys = allKeys();
        const int callers = 4;
        const std::size_t pinsEach = cache.pinnableChunks() / callers; // 3
        std::atomic<int> wrong{0};
        std::vector<std::jthread> threads;
        for (int t = 0; t < callers; ++t)
            threads.emplace_back([&, t] {
                std::mt19937 random(static_cast<unsigned>(t));
                std::vector<ChunkPointer> pinned;
                for (int step = 0; step < 300; ++step) {
                    if (pinned.size() >= pinsEach || (!pinned.empty() && random() % 3 == 0))
                        pinned.erase(pinned.begin() + random() % static_cast<unsigned>(pinned.size()));
                    if (pinned.size() >= pinsEach)
                        continue;
                    const ChunkKey key = keys[random() % keys.size()];
                    if (random() % 4 == 0) { // prefetch: asked for and let go
                        cache.request(std::vector{key});
                        continue;
                    }
                    pinned.push_back(cache.get(key));
                    if (!right(key, pinned.back()))
                        ++wrong;
                    if (cache.counters().heldBytes > budget)
                        ++wrong;
                }
            });
        threads.clear();
        EXPECT_EQ(wrong, 0);
        const auto counters = cache.counters();
        EXPECT_GT(counters.evictions, 100u);
        EXPECT_GT(counters.hits, 0u);
        EXPECT_LE(counters.peakBytes, budget);
        EXPECT_EQ(counters.peakBytes, budget) << "a small budget should be used up";
    }
    EXPECT_LE(small.peakBytes(), budget);
    EXPECT_EQ(small.usedBytes(), 0u);
}

TEST_F(Cache, RequestsForOneChunkAreJoined) {
    BrickCache cache(store, ram, 32 * chunk, 1);
    const std::vector<ChunkKey> keys(20, ChunkKey{0, 1, 1, 1});
    auto futures = cache.request(keys);
    for (auto& future : futures)
        EXPECT_EQ(future.get().get(), futures[0].get().get());
    const auto counters = cache.counters();
    EXPECT_EQ(counters.misses, 1u);
    EXPECT_EQ(counters.joins + counters.hits, 19u);
    EXPECT_EQ(counters.bytesDecoded, chunk);
    cache.get(keys[0]);
    EXPECT_EQ(cache.counters().hits, counters.hits + 1);
}

TEST_F(Cache, TheLeastRecentlyReleasedGoesFirst) {
    BrickCache cache(store, ram, 9 * chunk, 1);
    for (int i = 0; i < 5; ++i)
        cache.get({0, i, 0, 0});
    for (int i = 0; i < 4; ++i)
        cache.get({0, i, 1, 0}); // nine: full
    EXPECT_EQ(cache.counters().evictions, 0u);
    cache.get({0, 0, 0, 0}); // now (1,0,0) is the oldest
    cache.get({0, 0, 2, 0});
    EXPECT_EQ(cache.counters().evictions, 1u);
    EXPECT_TRUE(resident(cache, {0, 0, 0, 0}));
    EXPECT_TRUE(resident(cache, {0, 2, 0, 0}));
    EXPECT_FALSE(resident(cache, {0, 1, 0, 0}));
}

TEST_F(Cache, APinnedChunkStaysAndAQueuedOneWaitsForRoom) {
    BrickCache cache(store, ram, 9 * chunk, 1);
    EXPECT_EQ(cache.pinnableChunks(), 8u);
    std::vector<ChunkPointer> pinned;
    for (int i = 0; i < 9; ++i)
        pinned.push_back(cache.get({0, i % 5, i / 5, 0})); // one more than promised
    auto waiting = cache.request(std::vector{ChunkKey{0, 0, 3, 0}});
    EXPECT_EQ(waiting[0].wait_for(50ms), std::future_status::timeout);
    EXPECT_EQ(cache.counters().heldBytes, 9 * chunk);
    const std::byte* kept = pinned[1]->bytes.get();
    pinned.erase(pinned.begin()); // releases (0,0,0)
    ASSERT_EQ(waiting[0].wait_for(10s), std::future_status::ready);
    EXPECT_TRUE(right({0, 0, 3, 0}, waiting[0].get()));
    EXPECT_EQ(cache.get({0, 1, 0, 0})->bytes.get(), kept);
    EXPECT_EQ(cache.counters().evictions, 1u);
}

TEST_F(Cache, AFailingChunkFailsItsRequestsOnlyAndMayBeTriedAgain) {
    ScratchFolder scratch;
    fs::copy(*folder_ / "v.zarr", scratch / "v.zarr", fs::copy_options::recursive);
    const fs::path shard = scratch / "v.zarr/0/c/0/0/0";
    const std::string text = fileText(shard);
    std::string damaged = text;
    damaged[40] = static_cast<char>(damaged[40] ^ 1); // chunk (0,0,0) stands first
    setFileText(shard, damaged);
    const StoreReader bad(scratch / "v.zarr", ram);
    BrickCache cache(bad, ram, 10 * chunk, 2);
    for (int again = 0; again < 20; ++again) // more often than there is room: failures give theirs back
        EXPECT_THAT(
            [&] {
                cache.get({0, 0, 0, 0});
            },
            ThrowsMessage<InputError>(HasSubstr("level 0 chunk (0,0,0)")));
    EXPECT_EQ(cache.counters().heldBytes, 0u);
    EXPECT_TRUE(right({0, 1, 0, 0}, cache.get({0, 1, 0, 0})));
    std::ofstream(shard, std::ios::binary | std::ios::in).write(text.data(), 64); // repaired in place
    EXPECT_TRUE(right({0, 0, 0, 0}, cache.get({0, 0, 0, 0})));
}

TEST_F(Cache, PointersOutliveTheCacheAndQueuedWorkIsDropped) {
    MemoryBudget own("RAM", "--ram", kPlenty);
    std::vector<ChunkPointer> pinned;
    std::vector<ChunkFuture> waiting;
    {
        BrickCache cache(store, own, 9 * chunk, 1);
        for (int i = 0; i < 9; ++i)
            pinned.push_back(cache.get({0, i % 5, i / 5, 0}));
        waiting = cache.request(std::vector{ChunkKey{0, 0, 3, 0}, ChunkKey{0, 1, 3, 0}});
    }
    for (auto& future : waiting)
        EXPECT_THROW(future.get(), Error);
    EXPECT_TRUE(right({0, 3, 1, 0}, pinned[8]));
    EXPECT_EQ(own.usedBytes(), 9 * chunk);
    pinned.clear();
    EXPECT_EQ(own.usedBytes(), 0u);
}

TEST_F(Cache, ABudgetBelowTheFloorIsRefusedByName) {
    const std::size_t floor = BrickCache::floorBytes(store.info(), 3);
    EXPECT_EQ(floor, 11 * chunk);
    EXPECT_THAT([&] { BrickCache(store, ram, floor - 1, 3); },
                ThrowsMessage<InputError>(HasSubstr(formatBytes(floor))));
    MemoryBudget tight("RAM", "--ram", floor - 1);
    EXPECT_THAT([&] { BrickCache(store, tight, floor, 3); }, ThrowsMessage<InputError>(HasSubstr("--ram")));
}

// -- wanted without waiting
// ------------------------------------------------------------------------------------------------------

/// Takes chunks as they come until none of the keys is left; how many were right, -1 at the deadline.
int takeAll(BrickCache& cache, std::vector<ChunkKey> keys,
            const std::function<bool(const ChunkKey&, const ChunkPointer&)>& right) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    int taken = 0;
    while (!keys.empty()) {
        if (std::chrono::steady_clock::now() > deadline)
            return -1;
        cache.waitForWanted(deadline);
        std::erase_if(keys, [&](const ChunkKey& key) {
            const ChunkPointer chunk = cache.take(key);
            taken += chunk && right(key, chunk);
            return chunk != nullptr;
        });
    }
    return taken;
}

TEST_F(Cache, WantedChunksComeThoughTheyDoNotFitTogether) {
    BrickCache cache(store, ram, 10 * chunk, 2);
    const std::vector<ChunkKey> keys = allKeys();
    ASSERT_GT(keys.size(), 60u);
    cache.want(keys);
    EXPECT_EQ(takeAll(cache, keys, [&](const auto& key, const auto& found) { return right(key, found); }),
              static_cast<int>(keys.size()));
    EXPECT_LE(cache.counters().peakBytes, 10 * chunk);
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    cache.waitForWanted(deadline); // none is wanted any more
    EXPECT_LT(std::chrono::steady_clock::now(), deadline);
}

// Of ten chunks' room two are the loaders', and of the rest at most half are loaded ahead.
TEST_F(Cache, WhatIsWantedLeavesRoomForRequests) {
    BrickCache cache(store, ram, 10 * chunk, 2);
    cache.want(allKeys());
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (cache.counters().heldBytes < 4 * chunk && std::chrono::steady_clock::now() < deadline)
        std::this_thread::sleep_for(1ms);
    std::this_thread::sleep_for(30ms);
    EXPECT_EQ(cache.counters().heldBytes, 4 * chunk);
}

TEST_F(Cache, RequestsGoBeforeWhatIsWanted) {
    BrickCache cache(store, ram, 9 * chunk, 1);
    std::vector<ChunkPointer> pinned;
    for (int i = 0; i < 9; ++i)
        pinned.push_back(cache.get({0, i % 5, i / 5, 0}));
    cache.want(std::vector{ChunkKey{0, 0, 2, 0}, ChunkKey{0, 1, 2, 0}});
    const auto asked = cache.request(std::vector{ChunkKey{0, 2, 2, 0}});
    pinned.pop_back(); // room for one
    ASSERT_EQ(asked.front().wait_for(20s), std::future_status::ready);
    EXPECT_TRUE(right({0, 2, 2, 0}, asked.front().get()));
}

TEST_F(Cache, AWantedChunkThatFailsIsToldAndMayBeTriedAgain) {
    ScratchFolder scratch;
    fs::copy(*folder_ / "v.zarr", scratch / "v.zarr", fs::copy_options::recursive);
    const fs::path shard = scratch / "v.zarr/0/c/0/0/0";
    const std::string text = fileText(shard);
    std::string damaged = text;
    damaged[40] = static_cast<char>(damaged[40] ^ 1); // chunk (0,0,0) stands first
    setFileText(shard, damaged);
    const StoreReader bad(scratch / "v.zarr", ram);
    BrickCache cache(bad, ram, 10 * chunk, 2);
    const std::vector<ChunkKey> key = {{0, 0, 0, 0}};
    for (int again = 0; again < 2; ++again) { // taken; then left where it is
        cache.want(key);
        const auto deadline = std::chrono::steady_clock::now() + 20s;
        cache.waitForWanted(deadline);
        ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "nobody tells that it failed";
        if (again == 0) {
            EXPECT_THROW(cache.take(key.front()), InputError);
            EXPECT_FALSE(cache.take(key.front())) << "told once";
        }
    }
    std::ofstream(shard, std::ios::binary | std::ios::in).write(text.data(), 64); // repaired in place
    cache.want(key);
    EXPECT_EQ(takeAll(cache, key, [&](const auto& k, const auto& found) { return right(k, found); }), 1);
}

TEST_F(Cache, CountersTellWhatWasWanted) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    const auto expectCounters = [&](const BrickCache& cache, std::uint64_t hits, std::uint64_t misses,
                                    std::uint64_t forgotten) {
        const auto counters = cache.counters();
        EXPECT_EQ(counters.hits, hits);
        EXPECT_EQ(counters.misses, misses);
        EXPECT_EQ(counters.forgotten, forgotten);
        EXPECT_EQ(counters.joins, 0u);
        EXPECT_EQ(counters.bytesDecoded, misses * chunk);
        EXPECT_EQ(counters.heldBytes, misses * chunk);
        EXPECT_EQ(counters.peakBytes, misses * chunk);
    };
    const ChunkKey a{0, 0, 0, 0}, b{0, 1, 0, 0};
    {
        BrickCache cache(store, ram, 20 * chunk, 1);
        cache.get(a);
        expectCounters(cache, 0, 1, 0);
        cache.want(std::vector{a});
        cache.waitForWanted(deadline);
        expectCounters(cache, 1, 1, 0); // it is there
        EXPECT_TRUE(cache.take(a));
        expectCounters(cache, 1, 1, 0);
        cache.want(std::vector{b});
        cache.waitForWanted(deadline);
        expectCounters(cache, 1, 2, 0);
        cache.want({}); // loaded, and not asked for any more: nothing was spared
        expectCounters(cache, 1, 2, 0);
        EXPECT_TRUE(cache.take(b)); // it is still there
        expectCounters(cache, 2, 2, 0);
        EXPECT_FALSE(cache.take({0, 2, 0, 0})); // nobody has asked for it
        expectCounters(cache, 2, 2, 0);
    }
    BrickCache full(store, ram, 9 * chunk, 1);
    std::vector<ChunkPointer> pinned;
    for (int i = 0; i < 9; ++i)
        pinned.push_back(full.get({0, i % 5, i / 5, 0}));
    full.want(std::vector{ChunkKey{0, 0, 2, 0}, ChunkKey{0, 1, 2, 0}, ChunkKey{0, 2, 2, 0}});
    expectCounters(full, 0, 9, 0);
    full.want(std::vector{ChunkKey{0, 1, 2, 0}});
    expectCounters(full, 0, 9, 2);
    full.want({});
    expectCounters(full, 0, 9, 3);
}

TEST_F(Cache, ANewListTakesTheOldOnesPlaceWhileOthersWork) {
    BrickCache cache(store, ram, 20 * chunk, 2);
    const std::vector<ChunkKey> keys = allKeys();
    std::atomic<bool> done{false};
    std::atomic<int> wrong{0};
    std::vector<std::jthread> others; // one pin each at a time
    for (unsigned t = 0; t < 2; ++t)
        others.emplace_back([&, t] {
            std::mt19937 random(t);
            while (!done) {
                const ChunkKey key = keys[random() % keys.size()];
                if (!right(key, cache.get(key)))
                    ++wrong;
            }
        });
    std::mt19937 random(7);
    for (int list = 0; list < 60; ++list) {
        std::vector<ChunkKey> wanted = keys;
        std::shuffle(wanted.begin(), wanted.end(), random);
        wanted.resize(1 + random() % 12);
        cache.want(wanted);
        if (list % 3 != 0)
            continue; // dropped half done
        EXPECT_EQ(
            takeAll(cache, wanted, [&](const auto& key, const auto& found) { return right(key, found); }),
            static_cast<int>(wanted.size()));
    }
    done = true;
    others.clear();
    EXPECT_EQ(wrong, 0);
    EXPECT_LE(cache.counters().peakBytes, 20 * chunk);
}

} // namespace
} // namespace tessera
