// bricking/analysis/lumen/nearest_voxels.h: the voxel of a set that is nearest to a point, and the nearest
// voxels of two sets.
#pragma once

#include "bricking/analysis/lumen/lumen_shape.h"

namespace tessera {

struct NearestVoxel {
    glm::ivec3 voxel{0};
    double mm = 0; ///< from the place to the voxel's middle
};
/// Of a set that is not empty.
NearestVoxel nearestVoxel(const LumenShape& shape, const glm::dvec3& mm);

struct Gap {
    glm::dvec3 fromMm{0}, toMm{0}; ///< middles of the two voxels
    double mm = 0;
};
/// Where two sets, neither empty, come nearest. Memory for what may be nearest is charged.
Gap nearestGap(const LumenShape& a, const LumenShape& b, MemoryBudget& ram);

} // namespace tessera
