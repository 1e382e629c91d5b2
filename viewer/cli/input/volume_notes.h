// viewer/cli/input/volume_notes.h: notes about an import: what it changed or missed in a volume's voxels.
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
/// What a picture of a volume of labels shows; "" for other volumes.
std::string sayLabels(const VolumeInfo& info);
/// All that is so of a volume, a line each, for notes.
std::vector<std::string> sayChanges(const VolumeInfo& info);

} // namespace tessera
