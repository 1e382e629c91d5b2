// bricking/import/importer.h: streams a SlabSource into a store: levels, shards, checksums, statistics. It
// goes on after a kill, and several processes can share one import. Belongs to tessera_bricking: it needs no
// format library.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "bricking/store/codec.h"
#include "bricking/store/volume_parts.h" // kPartSlices
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tessera {

// The version of import results, a part of their key in the import cache.

/// Raise it with every change of the result for the same files: voxels, values, geometry, or the store's
/// metadata. Cached imports of another version are made again.
constexpr int kImportVersion = 6;

struct ImportOptions {
    bool force = false;           // replace an existing store
    Codec codec = Codec::lz4;     // of the store's chunks
    int threads = 0;              // 0: all processors
    bool durable = true;          // synchronise to disk before the rename; off for scratch stores and tests
    Progress* progress = nullptr; // null: silent
    std::string unit = {};        // of the physical values if the source has none; "": the source's
    /// 32 hex digits of everything that the store depends on: files, options, codec, kImportVersion. After a
    /// kill the next import with the same key goes on with the finished ones of several parts. "": none does.
    std::string key = {};
    bool shared = false; // several processes with the same key may import together
    /// The source anew, for one that can only read on, if a part before its place is left to make.
    std::function<std::unique_ptr<SlabSource>()> reopen = {};
    /// Throws InputError if the source's files are no longer those of `key`.
    std::function<void()> checkSource = {};
    int partSlices = kPartSlices; // tests have fewer
};
struct ImportReport {
    std::uint64_t voxels = 0, bytesIn = 0, bytesOut = 0, chunksWritten = 0, chunksFill = 0;
    double seconds = 0;
    VolumeInfo info;                // of the source, with what all voxels told
    std::vector<std::string> notes; // SlabSource::notes() and those of the tally, of all parts
    int parts = 0, partsFound = 0;  // found: finished by an earlier process
    bool byOthers = false;          // another process finished the store; then only `info` says more
};

/// Least memory for importing the source's volume.
/// @param info  of the store
std::size_t importFloorBytes(const SlabSource& source, const VolumeInfo& info, int threads);

/// Writes the parts of the volume to a folder beside `store` (WorkFolder), joins them and renames the result:
/// an unfinished store never has the final name. The store's bytes depend neither on who made which part nor
/// on kills, nor on the budget. Memory: one slab of 32 slices per level, charged to ram; where these do not
/// fit, bands of their rows, and files in the folder (slab_feed.h). Throws InputError naming the minimum if
/// neither fits. Throws it if the store exists and force is off, if the existing path is not a store,
/// for a unit other than the source's own, and if another process imports with the same key and either does
/// not share. With `shared` a store that exists counts as finished by others if slices of the source are in
/// it. The source's slice order and infos are kept; texts are cut to 64 printable ASCII characters. Finished
/// parts stay for the next import after Interrupted and errors other than InputError.
/// @param source  at its first slice
ImportReport importToStore(SlabSource& source, const std::filesystem::path& store, MemoryBudget& ram,
                           const ImportOptions& options);

} // namespace tessera
