// bricking/store/shard.h: the division of a level's array into shard files, and the index that ends each
// file. A shard is 512^3 samples. Along an axis where the array is shorter, it is the array rounded up to
// whole chunks. The file holds encoded chunks in any order, then the index, then CRC-32C. The index has two
// uint64 (offset, bytes) per chunk of the shard, [z][y][x]. Both are all ones for a chunk that is left out
// because it holds the fill value only.
#pragma once

#include "core/base/brick.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tessera {

constexpr int kShardExtent = 512; // 4096 chunks, 256 MiB of int16: 64 files for level 0 of 2048^3
constexpr std::uint64_t kAbsentChunk = ~std::uint64_t{0};

struct ShardLayout {
    glm::ivec3 shardExtent{0}; // samples, multiples of kChunkExtent
    glm::ivec3 shards{0};      // grid of shards over the array
    glm::ivec3 chunks{0};      // grid of chunks inside one shard

    std::size_t entries() const { return cellCount(chunks); }
    std::size_t indexBytes() const { return 16 * entries() + 4; }
    /// Shard that holds a chunk, and the chunk's index in it.
    glm::ivec3 shardOf(const ChunkKey& key) const { return glm::ivec3(key.i, key.j, key.k) / chunks; }
    std::size_t entryOf(const ChunkKey& key) const;
};
ShardLayout shardLayout(const glm::ivec3& arrayExtent);

/// "2/c/0/1/0": path of a shard (grid position x,y,z) below the store; Zarr's keys run z, y, x.
std::string shardPath(int level, const glm::ivec3& shard);
/// "level 2 chunk (1,0,3)", x, y, z.
std::string describe(const ChunkKey& key);

struct ShardEntry {
    std::uint64_t offset = kAbsentChunk, bytes = kAbsentChunk;
    bool absent() const { return offset == kAbsentChunk && bytes == kAbsentChunk; }
};

/// The index as in the file, checksum included.
std::vector<std::byte> encodeIndex(std::span<const ShardEntry> entries);
/// Checks the checksum, and every entry against the file's size.
/// @param file  layout.indexBytes() last bytes
/// Throws InputError that begins with where, and names the chunk by its position in the shard.
std::vector<ShardEntry> decodeIndex(std::span<const std::byte> file, const ShardLayout& layout,
                                    std::uint64_t fileBytes, const std::string& where);

} // namespace tessera
