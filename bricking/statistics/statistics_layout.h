// bricking/statistics/statistics_layout.h: where statistics are in a store, and how (statistics.cpp).
// Internal to this room.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/zarr_array.h"

#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <string>

namespace tessera {

constexpr const char* kStatisticsFile = "stats/zarr.json";
constexpr const char* kFillsKey = "fill"; // of the group; only where a volume may have fill values
constexpr const char* kRayGroupFile = "stats/rays/zarr.json";
// 1: brick histograms; 2: no rays through the extremes; 3: fewer rays and samples; 4: no brick_min, brick_max
constexpr std::int64_t kStatisticsVersion = 5, kOldestStatistics = 4;

/// Of cells and bricks.
ArraySpec floatSpec(const glm::ivec3& grid);
/// Of one part of the rays of bricks.
ArraySpec raySpec(const glm::ivec3& bricks);
/// Its path in the store.
std::string rayPath(int part);

/// Bytes of one part of the rays of one group of layers.
std::size_t rayLayerBytes(const VolumeInfo& info);
/// For reading or writing a layer of any of the arrays.
std::size_t scratchBytes(const VolumeInfo& info);
/// @param threads  0: all processors
std::size_t threadCount(int threads);

/// The document of a group without attributes.
Json plainGroup();
/// The document of the statistics' group. Throws BadFile where it is missing, damaged, of another version or
/// of another store.
Json readStatisticsGroup(const StoreFolder& folder, const StoreReader& store);

} // namespace tessera
