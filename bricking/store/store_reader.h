// bricking/store/store_reader.h: reads chunks of a store: an OME-Zarr 0.5 group, sharded, checksummed.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/store/remote_files.h"
#include "core/base/brick.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <cstddef>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace tessera {

class StoreReader : public ChunkSource {
  public:
    /// Reads and checks all metadata; no voxels. Shard indices are read on first use and checked. Their
    /// memory and that for decoding is charged to ram at once: at most a quarter of its free bytes, but at
    /// least readerFloorBytes(). With less memory shards are opened more often. A store behind an address
    /// takes besides what its files need in flight. ram must outlive the reader.
    /// Throws InputError naming the file for anything missing, unreadable or inconsistent.
    /// @param moved  to patient space from the store's, which the volume is moved by
    StoreReader(const std::filesystem::path& path, MemoryBudget& ram,
                const glm::dmat4& moved = glm::dmat4(1));
    ~StoreReader() override;
    StoreReader(const StoreReader&) = delete;
    StoreReader& operator=(const StoreReader&) = delete;

    const std::filesystem::path& path() const;
    const VolumeInfo& info() const override;
    /// Of the stored values of level 0, as the metadata say.
    std::pair<double, double> storedRange() const;
    /// Decodes one chunk: [z][y][x] of kChunkExtent^3 stored values; beyond the array's edge the fill value.
    /// Thread-safe. out.size() == chunkBytes(). A chunk that the store leaves out is all fill.
    /// Throws InputError naming shard and chunk if a checksum or an index is wrong.
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;
    void willRead(std::span<const ChunkKey> keys) const override;
    /// Identity of the content: hex digest over metadata and shard indices (whose entries hold the chunks'
    /// offsets and sizes; the chunks' own CRCs represent their bytes).
    std::string contentHash() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Those of a scene's volumes, in order.
using Stores = std::span<const StoreReader* const>;

/// What servers were asked for so far, for the stores behind addresses; nullopt: none lies behind one.
std::optional<RemoteFiles::Counters> fetchedFor(Stores stores);

/// Minimum memory of a reader of such a volume: one shard's index and one encoded chunk.
std::size_t readerFloorBytes(const VolumeInfo& info);

/// Of a store that has a preview: a small, lossy store of its own (export/preview.h).
constexpr char kPreviewFolder[] = "preview";

/// True if path looks like a store of ours (a folder whose zarr.json has attributes.tessera).
bool isStore(const std::filesystem::path& path);

} // namespace tessera
