// bricking/store/shard.h: the division of a level's array into shard files, and the index that ends each
// file. A shard is 512^3 samples. Along an axis where the array is shorter, it is the array rounded up to
// whole chunks. The file holds encoded chunks in any order, then the index, then CRC-32C. The index has two
// uint64 (offset, bytes) per chunk of the shard, [z][y][x]. Both are all ones for a chunk that is left out
// because it holds the fill value only. The shards that a reader has open: descriptor and checked index. A
// fixed number of slots bounds descriptors and memory. The least recently used shard without readers is
// evicted.
#pragma once

#include "bricking/store/codec.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_metadata.h" // ShardRecord
#include "core/base/brick.h"
#include "core/base/budget.h"

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <tuple>
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

/// Fills whole values with the fill value.
void fillWith(const VolumeInfo& info, std::span<std::byte> out);
/// Samples of one chunk as they are stored: fill only is left out.
/// @param fillChunk  a chunk of fill
/// @return 0 bytes: left out
EncodedChunk encodeUnlessFill(std::span<const std::byte> raw, std::span<const std::byte> fillChunk,
                              std::size_t valueBytes, std::span<std::byte> out, Codec codec);
/// What zarr.json says of a shard.
/// @param crcs  per entry, of the chunks that are not absent
/// @param index  as encodeIndex() gives it
ShardRecord shardRecord(std::span<const ShardEntry> entries, std::span<const std::uint32_t> crcs,
                        std::span<const std::byte> index);

/// The index as in the file, checksum included.
std::vector<std::byte> encodeIndex(std::span<const ShardEntry> entries);
/// Checks the checksum, and every entry against the bytes that hold chunks.
/// @param encoded  the index, its checksum at the end
/// @param payloadBytes  of the file up to the index; all of it where the index is in front
/// Throws InputError that begins with where, and names the chunk by its position in the shard.
std::vector<ShardEntry> decodeIndex(std::span<const std::byte> encoded, std::uint64_t payloadBytes,
                                    const std::string& where);

struct OpenShard {
    StoreFile file;
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
        bool isLoading = false;          // by a thread that will hold it
        std::list<Key>::iterator idleAt; // valid while pins == 0 and it is not loading
    };
    const OpenShard& pin(const Key& key, const std::function<OpenShard()>& load);
    void unpin(const Key& key);

    const std::size_t slots_;
    Charge charge_;
    std::mutex mutex_;
    std::condition_variable released_;
    std::map<Key, Slot> open_;
    std::list<Key> idle_; // least recently used first
};

} // namespace tessera
