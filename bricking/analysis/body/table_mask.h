// bricking/analysis/body/table_mask.h: the table under a patient, found in a CT, as a mask that hides it.
// Where it is not sure that something is a table, nothing is hidden.
//
// A table is above -900 HU, is not body (body_box.h), runs along the whole volume with much the same
// cross-section, and has the patient on one side only. What lies beyond it as seen from the patient is hidden
// with it, what is not dense within kCushionMm of it, such as a mattress, hard thin walls that go on from it,
// and crumbs of it. What touches the body stays, and what is dense and not the table, or thick and less even
// than a table: a hand.
#pragma once

#include "bricking/cache/chunk_source.h"
#include "bricking/mask/mask.h"
#include "core/base/budget.h"

#include <cstddef>
#include <memory>
#include <string>

namespace tessera {

constexpr double kCushionMm = 50;

struct TableReport {
    double litres = 0;      // of dense voxels that are hidden
    std::string why;        // the reason, a clause, where nothing is
    bool isUnknown = false; // there was no room for looking, or voxels cannot be read
};
struct FoundTable : TableReport {
    std::shared_ptr<const Mask> mask; // null: nothing is hidden
};

/// Independent of the number of threads. Values must be in HU. Reads the finest level of at most 5 * 2^20
/// samples, or the coarsest.
/// @param ram  the mask stays charged to it
/// Throws InputError if ram cannot hold tableMaskBytes().
FoundTable findTable(const ChunkSource& volume, MemoryBudget& ram, int threads);

/// Memory that it takes while it runs.
std::size_t tableMaskBytes(const VolumeInfo& info);

} // namespace tessera
