// bricking/analysis/body/kept_table.h: the mask of a table, kept beside a store's statistics: found once, at
// import or at first use.
#pragma once

#include "bricking/analysis/body/table_mask.h"
#include "bricking/store/store_reader.h"

#include <filesystem>
#include <optional>

namespace tessera {

/// Writes what was found as FOLDER/stats/table.
/// @param folder  of the store, or where it is being made
void keepTable(const FoundTable& found, const StoreReader& store, const std::filesystem::path& folder);

/// What a store keeps; nullopt where it keeps nothing. Throws BadFile naming what is damaged, of another
/// store or version.
std::optional<FoundTable> keptTableOf(const StoreReader& store, MemoryBudget& ram);

/// The table of a store with values in HU: what is kept, else found now and kept where the store can be
/// written. Missing, damaged or foreign files count as none. Throws InputError if ram cannot hold
/// tableMaskBytes(), where it must be found.
FoundTable tableOf(const StoreReader& store, MemoryBudget& ram, int threads);

} // namespace tessera
