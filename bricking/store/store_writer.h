// bricking/store/store_writer.h: writes a store, slab by slab, into a temporary folder beside the target.
// Only commit() gives it the final name. A writer that dies uncommitted removes what it wrote.
//
//     StoreWriter writer(target, info, ram, threads, force);
//     while (writer.nextSlices() > 0) { fill writer.next(); writer.push(); }
//     writer.finish(info);   // indices and metadata: folder() is now a readable store
//     writer.commit();       // durable, then renamed
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace tessera {

class StoreWriter {
  public:
    /// Charges floorBytes() to ram.
    /// @param threads  that compress; 0: all processors
    /// Throws InputError: the target exists and force is off, or is no store; its parent is missing; the
    /// budget is below the floor; info cannot be stored. Throws Error when the folder cannot be made.
    StoreWriter(const std::filesystem::path& target, const VolumeInfo& info, MemoryBudget& ram, int threads,
                bool force);
    ~StoreWriter();
    StoreWriter(const StoreWriter&) = delete;
    StoreWriter& operator=(const StoreWriter&) = delete;

    /// Memory that writing such a volume takes: a slab of 32 slices per level, indices, compression buffers.
    static std::size_t floorBytes(const VolumeInfo& info, int threads);

    /// Slices that the next slab has: kChunkExtent, fewer at the end, 0 when all have come.
    int nextSlices() const;
    /// Where the next slab goes: [nextSlices()][y][x] stored values.
    std::span<std::byte> next();
    /// Takes the slab: reduces it to all levels and writes the chunks that this completes. Throws Error when
    /// the disk refuses, InputError when a float value is not finite.
    void push();
    /// After the last slab.
    /// @param final  info with what only the voxels told (SlabSource::info)
    /// Gives the memory back.
    void finish(const VolumeInfo& final);
    /// Renames the temporary folder to the target, replacing a store where force was given.
    /// @param durable  wait for the disk first, so that not even a power cut leaves the name without the data
    void commit(bool durable = true);

    /// The temporary folder.
    const std::filesystem::path& folder() const;

    struct Counters {
        std::uint64_t chunksWritten = 0, chunksFill = 0, bytesWritten = 0;
    };
    Counters counters() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace tessera
