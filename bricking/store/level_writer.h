// bricking/store/level_writer.h: LevelWriter: slabs of a volume's levels, as chunks in the shard files of a
// folder. The folder has the whole volume, or a part of it along z.
#pragma once

#include "bricking/store/codec.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/zarr_metadata.h" // ShardRecord
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <limits>
#include <memory>
#include <vector>

namespace tessera {

/// A shard's file as it was written. Of a part its index has the chunks of the part alone.
struct ShardFile {
    int level = 0;
    glm::ivec3 at{0};        // in the grid of shards
    std::uint64_t bytes = 0; // index included
    ShardRecord record;
};

/// What was written.
struct WrittenLevels {
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest; // stored values of level 0
    std::uint64_t chunksWritten = 0, chunksFill = 0;
    std::vector<ShardFile> files; // none for a shard of fill alone
    std::uint64_t bytes() const;
};

class LevelWriter {
  public:
    /// Charges bytesNeeded() to ram.
    /// @param info  of the whole volume
    /// @param threads  that compress; 0: all processors
    LevelWriter(std::filesystem::path folder, const VolumeInfo& info, MemoryBudget& ram, int threads,
                Codec codec = Codec::lz4);
    ~LevelWriter();
    LevelWriter(const LevelWriter&) = delete;
    LevelWriter& operator=(const LevelWriter&) = delete;
    /// Indices of a row of shards of every level, and buffers for compression.
    static std::size_t bytesNeeded(const VolumeInfo& info, int threads);

    /// Writes the chunks of a slab, or of a band of its rows. Of a level they come with z ascending, of a
    /// slab with y ascending.
    /// @param slab  its first slice: of the whole volume's level
    /// Throws Error if the disk fails, InputError if a value of level 0 is not finite.
    void write(const SlabPyramid::Slab& slab);
    /// Ends the shards that are still open, and gives the memory back.
    void close();
    const WrittenLevels& written() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
