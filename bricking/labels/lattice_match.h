// bricking/labels/lattice_match.h: how the voxels of a layer of labels lie to those of a scan.
#pragma once

#include "core/base/volume.h"

#include <array>

namespace tessera {

/// How the voxels of a layer lie to those of a scan.
struct LatticeMatch {
    bool isSame = false;                 // in any order of axes, to kSameVoxels (label_volume.h) of a voxel
    std::array<int, 3> axis = {0, 1, 2}; // of the layer, nearest to each of the scan's
    std::array<bool, 3> isFlipped = {false, false, false}; // it runs the other way
};
LatticeMatch latticeMatch(const VolumeInfo& layer, const VolumeInfo& scan);

} // namespace tessera
