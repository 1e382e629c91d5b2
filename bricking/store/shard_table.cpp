// bricking/store/shard_table.cpp: see shard_table.h.
#include "bricking/store/shard_table.h"

#include <utility>

namespace tessera {

ShardTable::ShardTable(MemoryBudget& ram, std::size_t slots, std::size_t largestIndex)
    : slots_(slots), charge_(ram.charge(slots * largestIndex, "the indices of open shards")) {}

const OpenShard& ShardTable::pin(const Key& key, const std::function<OpenShard()>& load) {
    std::unique_lock lock(mutex_);
    while (true) {
        if (const auto found = open_.find(key); found != open_.end()) {
            Slot& slot = found->second;
            if (slot.pins++ == 0)
                idle_.erase(slot.idleAt);
            return slot.shard;
        }
        if (open_.size() < slots_)
            break;
        if (!idle_.empty()) {
            open_.erase(idle_.front());
            idle_.pop_front();
            break;
        }
        released_.wait(lock);
    }
    OpenShard shard = load(); // throws: the slot stays free
    Slot& slot = open_[key];
    slot.shard = std::move(shard);
    slot.pins = 1;
    return slot.shard;
}

void ShardTable::unpin(const Key& key) {
    {
        const std::lock_guard lock(mutex_);
        Slot& slot = open_.at(key);
        if (--slot.pins == 0)
            slot.idleAt = idle_.insert(idle_.end(), key);
    }
    released_.notify_all();
}

} // namespace tessera
