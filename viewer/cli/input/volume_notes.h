// viewer/cli/input/volume_notes.h: notes about an import: voxels that it changed or could not read.
#pragma once

#include "core/base/volume.h"

#include <string>
#include <vector>

namespace tessera {

/// "1234 voxels without a number (NaN or infinite), stored as the lowest value, -1000 HU";
/// nonFiniteVoxels > 0.
std::string sayAbsent(const VolumeInfo& info);
/// "with loss, ratio 8.2 as the header says"; lossy.
std::string sayLoss(const VolumeInfo& info);
/// A note on pictures of label maps; "" for other volumes.
std::string sayLabels(const VolumeInfo& info);
/// All notes on a volume, one per line.
std::vector<std::string> sayChanges(const VolumeInfo& info);

} // namespace tessera
