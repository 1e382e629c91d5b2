// bricking/statistics/fill_values.h: which extremes of a volume are fill values: those of voxels without a
// measurement, such as -9999 outside of a round field of view. Internal to this room.
//
// A volume's lowest or highest value is one where it is at least as far from the next value as all others
// are from each other. Both ends may be. Then the same holds of the rest, up to kMostFillValues.
// Natural backgrounds stay: 0, a stored 0 of unsigned types, -1000 and -1024, and in HU all from -1100 on.
// What is left must be a measurement: values in at least eight of its histogram's 64 bins.
#pragma once

#include "bricking/statistics/statistics.h"
#include "bricking/statistics/statistics_pass.h"
#include "bricking/store/buffer_pool.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/store_reader.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

constexpr std::size_t kMostFillValues = 4;

/// True if a volume of such values may have fill values, by its histogram: false of nearly all volumes.
bool mayHaveFills(const WholeRange& whole, const VolumeInfo& info);

/// Reads the store's voxels twice for each end that is left out, and not at all where mayHaveFills() is
/// false.
/// @param pool  buffers of store.chunkBytes(), one per thread
FillValues findFills(const StoreReader& store, const WholeRange& whole, BufferPool& pool, int threads);

/// For the statistics' document.
Json fillsJson(const FillValues& fills);
/// The inverse, of the value at `pointer`. Throws InputError naming `where` for what does not count `voxels`.
FillValues readFills(const Json& document, const std::string& pointer, std::uint64_t voxels,
                     const std::string& where);

} // namespace tessera
