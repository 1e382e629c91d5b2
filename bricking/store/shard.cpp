// bricking/store/shard.cpp: see shard.h.
#include "bricking/store/shard.h"

#include "core/base/error.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera {

std::size_t ShardLayout::entryOf(const ChunkKey& key) const {
    const glm::ivec3 at(key.i, key.j, key.k);
    return linearIndex(at - shardOf(key) * chunks, chunks);
}

ShardLayout shardLayout(const glm::ivec3& arrayExtent) {
    ShardLayout layout;
    layout.chunks = glm::min(ceilDiv(arrayExtent, kChunkExtent), glm::ivec3(kShardExtent / kChunkExtent));
    layout.shardExtent = layout.chunks * kChunkExtent;
    layout.shards = (arrayExtent + layout.shardExtent - 1) / layout.shardExtent;
    return layout;
}

std::string shardPath(int level, const glm::ivec3& shard) {
    return std::to_string(level) + "/c/" + std::to_string(shard.z) + "/" + std::to_string(shard.y) + "/" +
           std::to_string(shard.x);
}

std::string describe(const ChunkKey& key) {
    return "level " + std::to_string(key.level) + " chunk (" + std::to_string(key.i) + "," +
           std::to_string(key.j) + "," + std::to_string(key.k) + ")";
}

void fillWith(const VolumeInfo& info, std::span<std::byte> out) {
    std::byte fill[8];
    const std::size_t valueBytes = bytesPerValue(info.type);
    storeFill(info, fill);
    for (std::size_t at = 0; at < out.size(); at += valueBytes)
        std::memcpy(out.data() + at, fill, valueBytes);
}

EncodedChunk encodeUnlessFill(std::span<const std::byte> raw, std::span<const std::byte> fillChunk,
                              std::size_t valueBytes, std::span<std::byte> out, Codec codec) {
    if (std::memcmp(raw.data(), fillChunk.data(), raw.size()) == 0)
        return {};
    return encodeChunk(raw, valueBytes, out, codec);
}

ShardRecord shardRecord(std::span<const ShardEntry> entries, std::span<const std::uint32_t> crcs,
                        std::span<const std::byte> index) {
    ShardRecord record;
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (!entries[i].absent()) {
            ++record.chunks;
            record.payloadCrc = crc32c(std::as_bytes(crcs.subspan(i, 1)), record.payloadCrc);
        }
    record.indexCrc = crc32c(index.first(index.size() - kCrcBytes));
    return record;
}

std::vector<std::byte> encodeIndex(std::span<const ShardEntry> entries) {
    static_assert(sizeof(ShardEntry) == 16);
    std::vector<std::byte> bytes(entries.size_bytes() + kCrcBytes);
    std::memcpy(bytes.data(), entries.data(), entries.size_bytes());
    const std::uint32_t crc = crc32c(std::span(bytes).first(entries.size_bytes()));
    std::memcpy(bytes.data() + entries.size_bytes(), &crc, kCrcBytes);
    return bytes;
}

std::vector<ShardEntry> decodeIndex(std::span<const std::byte> encoded, std::uint64_t payloadBytes,
                                    const std::string& where) {
    TESSERA_CHECK(encoded.size() >= kCrcBytes && (encoded.size() - kCrcBytes) % sizeof(ShardEntry) == 0);
    const auto body = encoded.first(encoded.size() - kCrcBytes);
    std::uint32_t expected = 0;
    std::memcpy(&expected, encoded.data() + body.size(), kCrcBytes);
    if (crc32c(body) != expected)
        throw badFile(where, "a shard index whose checksum is right", "a damaged index");
    std::vector<ShardEntry> entries(body.size() / sizeof(ShardEntry));
    std::memcpy(entries.data(), body.data(), body.size());
    for (std::size_t at = 0; at < entries.size(); ++at) {
        const ShardEntry& entry = entries[at];
        if (entry.absent())
            continue;
        // Compared without a sum, which could overflow with a wrong offset.
        if (entry.offset > payloadBytes || entry.bytes > payloadBytes - entry.offset)
            throw badFile(where, "index entry " + std::to_string(at) + " inside the file",
                          std::to_string(entry.bytes) + " bytes at offset " + std::to_string(entry.offset) +
                              " of " + std::to_string(payloadBytes));
    }
    return entries;
}

ShardTable::ShardTable(MemoryBudget& ram, std::size_t slots, std::size_t largestIndex)
    : slots_(slots), charge_(ram.charge(slots * largestIndex, "the indices of open shards")) {}

const OpenShard& ShardTable::pin(const Key& key, const std::function<OpenShard()>& load) {
    std::unique_lock lock(mutex_);
    while (true) {
        if (const auto found = open_.find(key); found != open_.end()) {
            Slot& slot = found->second;
            if (slot.isLoading) {
                released_.wait(lock);
                continue;
            }
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
    Slot& slot = open_[key]; // stays where it is: no one removes one that is loading
    slot.isLoading = true;
    lock.unlock(); // others read other shards meanwhile: an index may come from far away
    try {
        slot.shard = load();
    } catch (...) {
        lock.lock();
        open_.erase(key);
        released_.notify_all();
        throw;
    }
    lock.lock();
    slot.isLoading = false;
    slot.pins = 1;
    released_.notify_all();
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
