// bricking/validate/validate_store.h: what is wrong with a store, and what can be made again of it.
#pragma once

#include "core/base/budget.h"
#include "core/base/progress.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct ValidateOptions {
    bool repair = false;   // make again what follows from the rest of the store
    bool thorough = false; // make again what follows from the voxels, to compare it
    int threads = 0;       // 0: all processors
    Progress* progress = nullptr;
};

struct ValidateReport {
    std::vector<std::string> lines; // a fault each: "FILE: expected ..., found ...", and what became of it
    std::vector<std::string> notes; // what is no fault, or could not be checked
    std::uint64_t faults = 0;       // lines are at most StoreFaults::kMostLines of them
    std::uint64_t mended = 0;       // of those
    std::uint64_t shards = 0, chunks = 0;
};

/// Checks a store: the documents of metadata, every shard's index, every chunk, every level against the one
/// before, statistics and what else is kept beside them, and files that dead processes left. Nothing is
/// written without `repair`, but with `thorough` statistics, or the cells of labels, in the system's folder
/// for temporary files.
///
/// Repair writes beside a file and renames. It makes level documents, chunks above level 0, statistics and
/// the mask of a table byte for byte as the import made them; it removes damaged local histograms, which are
/// made again when light asks for them, and files that dead processes left. Level 0, the group's document and
/// labels stay as they are.
///
/// Throws InputError for a path that is no store of Tessera, for one that another process is writing, and if
/// ram has no room for one thread.
ValidateReport validateStore(const std::filesystem::path& path, MemoryBudget& ram,
                             const ValidateOptions& options);

} // namespace tessera
