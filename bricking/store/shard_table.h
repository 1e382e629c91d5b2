// bricking/store/shard_table.h: the shards that a reader has open: descriptor and checked index. A fixed
// number of slots bounds descriptors and memory. The least recently used shard without readers is evicted.
#pragma once

#include "bricking/store/file_io.h"
#include "bricking/store/shard.h"
#include "core/base/budget.h"

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <vector>

namespace tessera {

struct OpenShard {
    FileHandle file;
    std::string shown; // path for messages
    std::vector<ShardEntry> index;
};

class ShardTable {
  public:
    using Key = std::tuple<int, int, int, int>; // level, x, y, z of the shard grid
    /// @param slots  at least 1; shards open at once
    /// @param largestIndex  bytes of the largest index in the store; slots times that is charged to ram
    ShardTable(MemoryBudget& ram, std::size_t slots, std::size_t largestIndex);

    /// A shard in use: it stays open while the lease lives. A thread holds one lease at a time.
    class Lease {
      public:
        Lease(ShardTable& table, const Key& key, const std::function<OpenShard()>& load)
            : table_(table), key_(key), shard_(table.pin(key, load)) {}
        ~Lease() { table_.unpin(key_); }
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        const OpenShard& operator*() const { return shard_; }
        const OpenShard* operator->() const { return &shard_; }

      private:
        ShardTable& table_;
        Key key_;
        const OpenShard& shard_;
    };

    static constexpr std::size_t kMaxSlots =
        128; // 8 MiB of full indices, and far below the usual 1024 descriptors

  private:
    struct Slot {
        OpenShard shard;
        int pins = 0;
        std::list<Key>::iterator idleAt; // valid while pins == 0
    };
    const OpenShard& pin(const Key& key, const std::function<OpenShard()>& load);
    void unpin(const Key& key);

    const std::size_t slots_;
    Charge charge_;
    std::mutex mutex_; // held while an index is read: 64 KiB, once per shard
    std::condition_variable released_;
    std::map<Key, Slot> open_;
    std::list<Key> idle_; // least recently used first
};

} // namespace tessera
