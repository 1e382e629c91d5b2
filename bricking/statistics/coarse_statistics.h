// bricking/statistics/coarse_statistics.h: statistics of few bytes, for a picture of a coarse level before
// loadStatistics() (statistics.h) has read all. The arrays over bricks are a sixty-fourth of those over
// cells.
#pragma once

#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/volume.h"

#include <optional>

namespace tessera {

/// Statistics whose cells have the range of their brick and of two layers around it, which bounds their own;
/// so have bricks. The rest is as loadStatistics() has it. Nullopt: the store keeps none for bricks, or
/// damaged ones.
/// Throws InputError where ram cannot hold them, and OutOfReach.
std::optional<Statistics> loadCoarseStatistics(const StoreReader& store, MemoryBudget& ram, int threads);

/// Statistics of a coarser level as a volume of its own (LevelSource): bounds of its cells and bricks by
/// those of the bricks below. Histogram and means are empty.
/// @param all    of the volume
/// @param level  in [0,kLevelCount)
/// Throws InputError where ram cannot hold them.
Statistics boundsOfLevel(const Statistics& all, const VolumeInfo& info, int level, MemoryBudget& ram,
                         int threads);

} // namespace tessera
