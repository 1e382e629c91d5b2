// bricking/cache/level_source.h: LevelSource, a coarser level of a volume as a volume of its own.
#pragma once

#include "bricking/cache/chunk_source.h"

#include <span>

namespace tessera {

/// Its level 0 is that level; it has as many levels fewer, which count from there. A sample's place in the
/// patient is that of the voxels that it is the mean of.
class LevelSource final : public ChunkSource {
  public:
    /// @param volume  outlives this
    /// @param level   in [0,kLevelCount)
    LevelSource(const ChunkSource& volume, int level);

    const VolumeInfo& info() const override { return info_; }
    void readChunk(const ChunkKey& key, std::span<std::byte> out) const override;
    void willRead(std::span<const ChunkKey> keys) const override;

  private:
    ChunkKey below(ChunkKey key) const;
    const ChunkSource& volume_;
    int level_;
    VolumeInfo info_;
};

/// A level's extent, and its affine.
VolumeInfo infoOfLevel(const VolumeInfo& info, int level);

} // namespace tessera
