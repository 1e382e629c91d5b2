// bricking/analysis/lumen/value_noise.h: the noise of the values around a point, measured from the values
// themselves. Scanners and exports clip air at the lowest value, so only unclipped values count.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"

namespace tessera {

struct ValueNoise {
    double deviation = 0;    ///< standard deviation, physical units; 0: none, or nothing to tell it from
    double clippedShare = 0; ///< of the voxels around, that have the lowest value there; 0 below a fiftieth
};

/// Differences of voxels two apart along the two axes with the finest spacing, in blocks of 4^3 voxels within
/// 20 mm, 8 to 16 voxels. The quarter of the blocks with the least decides: the others have edges. Pairs with
/// a clipped value do not count. Of a block that is clipped in part, what is left of its noise is scaled to
/// the whole of a normal distribution.
/// @param place  voxel space, in the volume
ValueNoise noiseAround(LumenValues& values, const glm::dvec3& place);

} // namespace tessera
