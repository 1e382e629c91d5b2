// bricking/validate/stored_levels.h: StoredLevels, the shards and chunks of a store: what is wrong with them,
// and shards above level 0 made again from the level before them.
//
// A level's chunks are read once for their own sake and, above level 0, once more to be compared with what
// the level before gives by the store's rule: 2^3 chunks of it make one.
#pragma once

#include "bricking/store/buffer_pool.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/shard_files.h"
#include "bricking/validate/store_faults.h"
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class StoredLevels {
  public:
    /// Charges what it holds, and room for each thread, to ram: fewer threads where it is scarce.
    /// @param metadata  the group's; all references outlive this
    /// Throws InputError where ram has no room for one thread.
    StoredLevels(const std::filesystem::path& path, const StoreMetadata& metadata, MemoryBudget& ram,
                 int threads, StoreFaults& faults);
    /// Checks the files of shards, then every chunk and every level against the one before. Faults belong to
    /// the shard's path in the store ("1/c/0/0/0").
    void check(const ShareDone& progress);
    /// Makes shards above level 0 again that have faults, byte for byte as zarr.json describes them; leaves
    /// what cannot be made so as it is.
    void repair(const ShareDone& progress);
    /// True if nothing is wrong, or nothing any more.
    bool areWhole() const;
    /// True if levels could not be compared, because level 0 of a volume of labels is not whole.
    bool isWithoutRule() const { return !reduce_; }
    std::uint64_t chunks() const { return chunks_; }
    std::uint64_t shards() const { return shards_; }

  private:
    // Of a chunk; several may hold.
    static constexpr std::uint8_t kDamaged = 1; // it cannot be read
    static constexpr std::uint8_t kForeign = 2; // it is not what the level before gives
    // Of a shard.
    static constexpr std::uint8_t kBroken = 1;    // file or index, or a file that should not be there
    static constexpr std::uint8_t kExchanged = 2; // other chunks than zarr.json describes, perhaps whole ones

    struct Level {
        glm::ivec3 extent{0}, grid{0};            // samples; chunks
        std::vector<std::uint8_t> chunks, shards; // states, [z][y][x]
    };
    /// A thread's room.
    struct Room {
        std::span<std::byte> box, raw, made, encoded;
    };
    struct Slot {
        ChunkKey key;
        std::vector<std::byte> encoded;
        EncodedChunk result; // 0 bytes: left out
        std::string problem;
    };

    std::size_t roomBytes() const;
    Room roomOf(const BufferPool::Lease& lease) const;
    std::uint8_t& stateOf(const ChunkKey& key);
    void checkShard(int level, std::size_t shard);
    void findRule();
    void checkLevel(int level, const ShareDone& progress);
    void checkRange(const ChunkKey& key, std::span<const std::byte> raw);
    void finishShards();
    bool readWhole(const ChunkKey& key, const Room& room, std::span<std::byte> out, bool tell);
    bool assemble(const ChunkKey& coarse, const Room& room, bool tell);
    void reduce(const ChunkKey& coarse, const Room& room);
    bool hasFault(int level, std::size_t shard) const;
    std::string makeShard(int level, const glm::ivec3& at, bool deriveAll);
    void makeChunk(Slot& slot, bool deriveAll);
    void mendShard(int level, std::size_t shard);

    const StoreMetadata& metadata_;
    MemoryBudget& ram_;
    StoreFaults& faults_;
    std::size_t threads_ = 1;
    std::size_t valueBytes_ = 0, chunkBytes_ = 0;
    std::array<Level, kLevelCount> levels_;
    Charge charge_;
    std::optional<ShardFiles> files_;
    std::optional<BufferPool> pool_;
    std::vector<std::byte> fillChunk_;
    decltype(PyramidRule::reduce) reduce_; // empty: not known
    std::mutex mutex_;
    double lowest_ = 0, highest_ = 0; // of level 0
    std::uint64_t chunks_ = 0, shards_ = 0;
};

} // namespace tessera
