// bricking/import/importer.h: streams a SlabSource into a store: levels, shards, checksums, statistics.
// Belongs to tessera_bricking: it needs no format library.
#pragma once

#include "bricking/import/source/slab_source.h"
#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera {

// The version of import results, a part of their key in the import cache.

/// Raise it with every change of the result for the same files: voxels, values, geometry, or the store's
/// metadata. Cached imports of another version are made again.
constexpr int kImportVersion = 6;

struct ImportOptions {
    bool force = false;           // replace an existing store
    int threads = 0;              // 0: all processors
    bool durable = true;          // synchronise to disk before the rename; off for scratch stores and tests
    Progress* progress = nullptr; // null: silent
    std::string unit = {};        // of the physical values if the source has none; "": the source's
};
struct ImportReport {
    std::uint64_t voxels = 0, bytesIn = 0, bytesOut = 0, chunksWritten = 0, chunksFill = 0;
    double seconds = 0;
};

/// Least memory for importing such a volume.
std::size_t importFloorBytes(const VolumeInfo& info, int threads);

/// Writes to a temporary folder beside `store`, then renames: an unfinished store never has the final name.
/// Memory: one slab of 32 slices per level, charged to ram. Throws InputError naming the minimum if that does
/// not fit. Throws it if the store exists and force is off, if the existing path is not a store, and for a
/// unit other than the source's own. The source's slice order and infos are kept; texts are cut to 64
/// printable ASCII characters.
ImportReport importToStore(SlabSource& source, const std::filesystem::path& store, MemoryBudget& ram,
                           const ImportOptions& options);

} // namespace tessera
