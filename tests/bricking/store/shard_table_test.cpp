// tests/bricking/store/shard_table_test.cpp: a shard with readers stays open, and threads that wait for its
// room are woken when the last reader is done.
#include "bricking/store/shard.h"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <future>
#include <gtest/gtest.h>
#include <memory>
#include <thread>

namespace tessera {
namespace {

using namespace std::chrono_literals;

TEST(ShardTable, AShardStaysOpenUntilItsLastReaderIsDone) {
    MemoryBudget ram("RAM", "--ram", 1 << 20);
    ShardTable table(ram, 1, 100);
    EXPECT_EQ(ram.usedBytes(), 100u);
    std::atomic<int> loads{0};
    const auto load = [&] {
        ++loads;
        OpenShard shard;
        shard.index.resize(3);
        return shard;
    };
    const auto read = [&](int x) {
        return std::make_unique<ShardTable::Lease>(table, ShardTable::Key{0, x, 0, 0}, load);
    };
    auto first = read(1), second = read(1);
    EXPECT_EQ(loads, 1);
    auto other = std::async(std::launch::async, [&] { return read(2); });
    first.reset();
    EXPECT_EQ(other.wait_for(50ms), std::future_status::timeout) << "the room of a shard that is being read";
    EXPECT_EQ((*second)->index.size(), 3u);
    second.reset();
    if (other.wait_for(20s) != std::future_status::ready) {
        ADD_FAILURE() << "nobody told it that there is room";
        std::abort(); // nor will anybody: the thread could not be joined
    }
    EXPECT_EQ(loads, 2);
    other.get().reset();
    read(2).reset(); // still open
    EXPECT_EQ(loads, 2);
    read(1).reset();
    EXPECT_EQ(loads, 3);
}

} // namespace
} // namespace tessera
