// bricking/store/store_writer.h: writes a store, slab by slab, into a temporary folder beside the target.
// Only commit() gives it the final name. An uncommitted writer removes its folder.
//
//     StoreWriter writer(target, info, ram, threads, force);
//     while (writer.nextSlices() > 0) { fill writer.next(); writer.push(); }
//     writer.finish(info);   // indices and metadata: folder() is now a readable store
//     writer.commit();       // durable, then renamed
#pragma once

#include "bricking/store/level_writer.h"
#include "bricking/store/pyramid.h"
#include "bricking/store/zarr_metadata.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace tessera {

/// Throws InputError where StoreWriter would: for a target that exists and force is off, or that is no store,
/// and for an info that cannot be stored.
void checkStoreTarget(const std::filesystem::path& target, const VolumeInfo& info, bool force);

/// What is known from voxels (SlabSource::info), into the info of a store.
void keepVoxelFindings(VolumeInfo& info, const VolumeInfo& final);
/// The metadata of a store whose files were all written; without a rule.
StoreMetadata metadataOf(const VolumeInfo& info, const WrittenLevels& written);
/// Writes the JSON documents of the group and of its levels.
/// @return their bytes. Throws Error if the disk fails.
std::uint64_t writeDocuments(const std::filesystem::path& folder, const StoreMetadata& metadata);

class StoreWriter {
  public:
    /// Charges floorBytes() to ram.
    /// @param threads  that compress; 0: all processors
    /// @param rule  by which levels are made
    /// Throws InputError: the target exists and force is off, or is no store; its parent is missing; the
    /// budget is below the floor; info cannot be stored. Throws Error if the folder cannot be made.
    StoreWriter(const std::filesystem::path& target, const VolumeInfo& info, MemoryBudget& ram, int threads,
                bool force, PyramidRule rule = {});
    ~StoreWriter();
    StoreWriter(const StoreWriter&) = delete;
    StoreWriter& operator=(const StoreWriter&) = delete;

    /// Memory for writing such a volume: a slab of 32 slices per level, indices, compression buffers.
    static std::size_t floorBytes(const VolumeInfo& info, int threads);

    /// Slices of the next slab: kChunkExtent, fewer at the end, 0 after the last one.
    int nextSlices() const;
    /// Buffer for the next slab: [nextSlices()][y][x] stored values.
    std::span<std::byte> next();
    /// Processes the slab: reduces it to all levels and writes the completed chunks. Throws Error if the disk
    /// fails, InputError if a float value is not finite.
    void push();
    /// After the last slab.
    /// @param final  info with values from voxels (SlabSource::info) Gives the memory back.
    /// @param imageLabel  of a volume of labels, the JSON of OME's "image-label"; "": none
    void finish(const VolumeInfo& final, const std::string& imageLabel = {});
    /// Renames the temporary folder to the target, replacing a store if force was given.
    /// @param durable  synchronise to disk first, so that a power cut cannot leave the name without the data
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
