// bricking/analysis/lumen/value_noise.h: the noise of the values around a point, measured from the values
// themselves. Scanners and exports clip air at the lowest value, so only unclipped values count.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"

namespace tessera {

struct ValueNoise {
    double deviation = 0;    ///< standard deviation, physical units; 0: none, or unknown
    double clippedShare = 0; ///< share of voxels around with the lowest value there; 0 below a fiftieth
};

/// Differences of voxels two apart along the two axes with the finest spacing, in blocks of 4^3 voxels within
/// 20 mm, 8 to 16 voxels. The quarter of the blocks with the least noise decides: the others have edges.
/// Pairs with a clipped value do not count. In a partly clipped block the remaining noise is scaled to a full
/// normal distribution.
/// @param place  voxel space, in the volume
ValueNoise noiseAround(LumenValues& values, const glm::dvec3& place);

} // namespace tessera
