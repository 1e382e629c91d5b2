// bricking/store/shard.cpp: see shard.h.
#include "bricking/store/shard.h"

#include "bricking/store/codec.h"
#include "bricking/store/crc32c.h"
#include "core/base/error.h"

#include <algorithm>
#include <cstring>

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

std::vector<std::byte> encodeIndex(std::span<const ShardEntry> entries) {
    static_assert(sizeof(ShardEntry) == 16);
    std::vector<std::byte> bytes(entries.size_bytes() + kCrcBytes);
    std::memcpy(bytes.data(), entries.data(), entries.size_bytes());
    const std::uint32_t crc = crc32c(std::span(bytes).first(entries.size_bytes()));
    std::memcpy(bytes.data() + entries.size_bytes(), &crc, kCrcBytes);
    return bytes;
}

std::vector<ShardEntry> decodeIndex(std::span<const std::byte> file, const ShardLayout& layout,
                                    std::uint64_t fileBytes, const std::string& where) {
    TESSERA_CHECK(file.size() == layout.indexBytes() && fileBytes >= file.size());
    const auto body = file.first(file.size() - kCrcBytes);
    std::uint32_t expected = 0;
    std::memcpy(&expected, file.data() + body.size(), kCrcBytes);
    if (crc32c(body) != expected)
        throw badFile(where, "a shard index whose checksum is right", "a damaged index");
    std::vector<ShardEntry> entries(layout.entries());
    std::memcpy(entries.data(), body.data(), body.size());
    const std::uint64_t payloadBytes = fileBytes - file.size();
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

} // namespace tessera
