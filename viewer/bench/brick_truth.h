// viewer/bench/brick_truth.h: what levels really cost each brick, from all of its voxels: the slow truth that
// predictions are measured against.
#pragma once

#include "bricking/brick_rays.h"
#include "bricking/level_error.h"
#include "bricking/store/store_reader.h"
#include "render/optics.h"

#include <array>
#include <vector>

namespace tessera::bench {

/// A whole volume in memory, every level of it, as stored values.
class VolumeLevels {
  public:
    /// Charged to ram. Throws InputError where the budget cannot hold it.
    VolumeLevels(const StoreReader& store, Ledger& ram);
    const VolumeInfo& info() const { return info_; }
    /// The fields of one brick; valid until `room` changes.
    BrickFields brick(const glm::ivec3& at, std::vector<float>& room) const;

  private:
    VolumeInfo info_;
    std::array<std::vector<float>, kLevelCount> values_; // [z][y][x]
    Charge charge_;
};

/// Picture errors as level_error.h defines them, but from every row of voxels along the three axes and with
/// unrounded samples: no ray is left out.
LevelErrors trueErrors(const VolumeLevels& volume, std::vector<std::uint8_t> shows, const Optics& optics);
/// Root mean square distance of each level's field from the voxels, stored units: what a choice that does not
/// know the function can go by.
LevelErrors dataErrors(const VolumeLevels& volume, std::vector<std::uint8_t> shows);

/// Spearman's rank correlation; equal values share the mean of their ranks. 0 for fewer than 3 pairs or where
/// one side is constant. a and b of one length.
double rankCorrelation(const std::vector<double>& a, const std::vector<double>& b);

} // namespace tessera::bench
