// tests/bench/lod/brick_truth.h: the truth of what selection predicts, computed from every voxel. It is the
// true error of each brick and level as level_error.h defines it, and the errors of simpler measures to
// compare with. Slow; whole levels in memory.
#pragma once

#include "bricking/levels/level_error.h"
#include "bricking/levels/view_weight.h"
#include "bricking/store/store_reader.h"
#include "core/scene/transfer_function.h"

#include <array>
#include <vector>

namespace tessera::bench {

/// All levels of a volume, stored values as floats.
struct WholeLevels {
    VolumeInfo info;
    std::array<glm::ivec3, kLevelCount> extents{};
    std::array<std::vector<float>, kLevelCount> values; // [z][y][x]
};
WholeLevels loadLevels(const StoreReader& store);

/// Mean over all rows of voxels of each brick, along all three axes from both ends, of the distance in L*u*v*
/// between level 0 and each level, sampled at every voxel, before black. Of bricks with shows[brick] != 0.
LevelErrors trueErrors(const WholeLevels& levels, const std::vector<std::uint8_t>& shows,
                       const TransferTable& table, int threads);

/// The measure of data-error approaches (course notes 2.8.2): root mean square difference of stored values.
LevelErrors dataErrors(const WholeLevels& levels, const std::vector<std::uint8_t>& shows, int threads);

/// The measure of view-dependent approaches (course notes 2.8.1): the size of a sample alone.
LevelErrors sizeErrors(const glm::ivec3& bricks, const std::vector<std::uint8_t>& shows);
/// Weights for sizeErrors: one over the distance, which is what projected lengths fall with.
ViewWeights distanceWeights(ViewWeights weights);

/// Spearman's rank correlation, ties sharing their mean rank; NaN where either does not vary.
double rankCorrelation(const std::vector<double>& a, const std::vector<double>& b);

} // namespace tessera::bench
