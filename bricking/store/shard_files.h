// bricking/store/shard_files.h: ShardFiles, the shard files of a store: their indices, checked against
// zarr.json, and their chunks as they are stored.
#pragma once

#include "bricking/store/shard.h"
#include "bricking/store/store_files.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/brick.h"
#include "core/base/budget.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace tessera {

class ShardFiles {
  public:
    /// Charges the indices of `slots` open shards to ram. Throws InputError if the folder cannot be opened.
    /// @param metadata  outlives this, as ram does
    ShardFiles(const std::filesystem::path& path, const StoreMetadata& metadata, MemoryBudget& ram,
               std::size_t slots);

    const std::filesystem::path& path() const { return path_; }
    const StoreFolder& folder() const { return folder_; }
    const ShardLayout& layout(int level) const { return layouts_[static_cast<std::size_t>(level)]; }
    const ShardRecord& record(int level, const glm::ivec3& shard) const;
    /// "STORE/1/c/0/0/2", for messages.
    std::string shown(int level, const glm::ivec3& shard) const;

    /// Opens the file of a shard with chunks and reads its index. Throws BadFile naming it if it is missing,
    /// cut short, or not the one that zarr.json describes.
    OpenShard open(int level, const glm::ivec3& shard) const;
    /// Where a chunk is in the store's files; nullopt: it is left out. Thread-safe. Throws as open() does.
    std::optional<RemoteRange> placeOf(const ChunkKey& key) const;
    /// Reads a chunk as it is stored. Thread-safe.
    /// @param room  at least encodedBound() of a chunk
    /// @return the used part of room; empty: the chunk is left out, because it is all fill
    /// Throws InputError naming shard and chunk.
    std::span<std::byte> read(const ChunkKey& key, std::span<std::byte> room) const;

  private:
    std::filesystem::path path_;
    StoreFolder folder_;
    const StoreMetadata& metadata_;
    std::array<ShardLayout, kLevelCount> layouts_;
    mutable ShardTable shards_;
};

/// Bytes of the largest index of a store of such a volume.
std::size_t largestIndexBytes(const VolumeInfo& info);

} // namespace tessera
