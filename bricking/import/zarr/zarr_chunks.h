// bricking/import/zarr/zarr_chunks.h: ZarrChunks: the chunks of an array, decoded one at a time.
#pragma once

#include "bricking/import/zarr/zarr_array.h"
#include "bricking/store/shard.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace tessera {

class ZarrChunks {
  public:
    /// @param array  must outlive it
    explicit ZarrChunks(const ZarrArray& array);
    /// Most memory that it takes.
    static std::size_t bytesNeeded(const ZarrArray& array);

    /// False for an array whose chunks need not be told.
    bool isToBeTold() const { return folder_.remote && array_.shard.empty(); }
    /// Tells an array behind an address that these chunks will be read (RemoteFiles::willRead()). Chunks of
    /// shards are not told.
    void tell(const std::vector<std::vector<std::int64_t>>& places) const;
    /// The chunk at a place of the grid of chunks, as its bytes are ordered; empty: the array has none there,
    /// and all is fill. Valid until the next call. Memory is taken for what its first bytes justify. Throws
    /// InputError naming file and chunk for damage, and for a chunk of another size than the array says.
    std::span<const std::byte> read(std::span<const std::int64_t> at);

    /// The file of a chunk, or of a shard: its name below the array.
    static std::string fileOf(const ZarrArray& array, std::span<const std::int64_t> at);

    /// Chunks that were read. Missing are those that have no file, or whose shard has none: what a shard
    /// itself leaves out is fill.
    struct Tally {
        std::uint64_t read = 0, missing = 0;
        std::string firstMissing; // its file
        bool lacksAll() const { return read > 0 && missing == read; }
    };
    const Tally& tally() const { return tally_; }

  private:
    std::span<const std::byte> encodedFile(std::span<const std::int64_t> at);
    std::span<const std::byte> ofShard(std::span<const std::int64_t> at);
    const OpenShard* shardOf(const std::vector<std::int64_t>& at);
    void countMissing(std::string file);
    std::span<const std::byte> fetched(const StoreFile& file, std::uint64_t offset, std::uint64_t bytes);
    std::span<const std::byte> decoded(std::span<const std::byte> encoded);

    const ZarrArray& array_;
    const StoreFolder& folder_;
    std::map<std::vector<std::int64_t>, OpenShard> shards_; // by place; without a file: missing
    std::vector<std::byte> encoded_, decoded_;
    std::string where_; // of the chunk that is read
    Tally tally_;
};

/// Sets the separator of an array whose metadata do not say it (ZarrArray::isSeparatorSaid) by the chunks
/// that are there: the middle one, else the first or the last. Throws InputError as openIn() does.
void findSeparator(ZarrArray& array);

} // namespace tessera
