// bricking/cache/chunk_source.h: ChunkSource, the interface that the cache reads: a volume with its levels,
// in boxes of kChunkExtent^3 samples. Our stores are such sources (store/store_reader.h). Foreign and remote
// stores can implement it with chunks of any size (RechunkedSource).
#pragma once

#include "core/base/brick.h"
#include "core/base/volume.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>

namespace tessera {

class ChunkSource {
  public:
    virtual ~ChunkSource() = default;
    virtual const VolumeInfo& info() const = 0;
    /// Reads one chunk: [z][y][x] of kChunkExtent^3 stored values; beyond the level's edge the fill value.
    /// Thread-safe. out.size() == chunkBytes(). Throws InputError that names what cannot be read.
    virtual void readChunk(const ChunkKey& key, std::span<std::byte> out) const = 0;
    /// Tells that these chunks will be read soon, the first ones first: a source that waits for servers may
    /// ask for them together. Thread-safe.
    virtual void willRead(std::span<const ChunkKey> keys) const { static_cast<void>(keys); }
    /// Bytes of one chunk: kChunkExtent^3 * bytesPerValue.
    std::size_t chunkBytes() const {
        return cellCount(glm::ivec3(kChunkExtent)) * bytesPerValue(info().type);
    }
};

/// A source whose own chunks have another size: every requested chunk is assembled from those that it
/// overlaps.
class RechunkedSource : public ChunkSource {
  public:
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const final;

  protected:
    /// Samples of one of its own chunks along each axis, at least 1.
    virtual glm::ivec3 ownExtent(int level) const = 0;
    /// Reads one of its own chunks: [z][y][x] of ownExtent() stored values; values beyond the level's edge
    /// are not used. Thread-safe.
    virtual void readOwn(int level, const glm::ivec3& chunk, std::span<std::byte> out) const = 0;
};

} // namespace tessera
