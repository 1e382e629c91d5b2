// bricking/statistics/statistics_reader.h: StatisticsReader: the arrays of a store's statistics, without
// rays. Internal to this room.
#pragma once

#include "bricking/statistics/statistics.h"
#include "bricking/store/checked_json.h"
#include "bricking/store/store_files.h"
#include "bricking/store/store_reader.h"
#include "bricking/store/zarr_array.h"

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

namespace tessera {

/// Memory of statistics of such a volume.
std::size_t heldStatisticsBytes(const VolumeInfo& info);
/// Sized and charged, not yet filled.
Statistics emptyStatistics(const VolumeInfo& info, MemoryBudget& ram);
/// The slices of an array that one layer of its chunks holds.
std::span<std::byte> layerOfArray(std::vector<float>& values, const ArraySpec& spec, int layer);

class StatisticsReader {
  public:
    /// Reads the group's document. Arrays are told first: a server is asked for all of them together.
    /// @param told  names of arrays that will be read, the first ones last
    /// Throws InputError naming what is missing, damaged or of another store.
    StatisticsReader(const StoreReader& store, std::initializer_list<const char*> told);

    std::int64_t version() const { return version_; }
    /// Range, histogram and fill values.
    void summary(Statistics& statistics) const;
    /// False of statistics by an earlier program, which did not look for fill values.
    bool knowsFills() const;
    /// Two arrays over cells or bricks at once, layer by layer.
    /// @param threads  at most so many, each with ArraySpec::scratchBytes() of floatSpec(grid)
    void pair(const char* low, std::vector<float>& lows, const char* high, std::vector<float>& highs,
              const glm::ivec3& grid, int threads) const;

  private:
    const StoreReader& store_;
    StoreFolder folder_;
    std::string where_;
    Json group_;
    std::int64_t version_ = 0;
};

} // namespace tessera
