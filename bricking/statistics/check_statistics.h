// bricking/statistics/check_statistics.h: what is wrong with the statistics that a store keeps.
#pragma once

#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/base/error.h"

#include <functional>
#include <string>
#include <vector>

namespace tessera {

/// Gets a fault and the part of the statistics that has it: one of statisticsParts().
using StatisticsFault = std::function<void(const std::string& part, const BadFile& problem)>;

/// "stats/cell_min", "stats/rays", "stats/zarr.json", ...: files and folders that can be made again one by
/// one, the group's document last.
const std::vector<std::string>& statisticsParts();

/// The version that is written.
int newestStatistics();

/// Reads all statistics of a store, with every checksum. A missing array is a fault of its part; so are
/// statistics of another version that loadStatistics() does not read.
/// @return the version of what is kept, 0 where nothing tells it
/// Throws InputError if ram cannot hold a layer of an array.
int checkStatistics(const StoreReader& store, MemoryBudget& ram, const StatisticsFault& found);

/// The same for local histograms (local_histograms.h), where the store has some.
void checkLocalHistograms(const StoreReader& store, MemoryBudget& ram, const StatisticsFault& found);

/// Makes local histograms again, where the store has some that can be read, and compares them. The statistics
/// are whole.
/// @return why they were not compared; "": they were, or there are none
std::string compareLocalHistograms(const StoreReader& store, MemoryBudget& ram, int threads,
                                   const StatisticsFault& found);

} // namespace tessera
