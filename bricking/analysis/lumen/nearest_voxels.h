// bricking/analysis/lumen/nearest_voxels.h: the voxel of a set that is nearest to a point, and the nearest
// voxels of two sets.
#pragma once

#include "bricking/analysis/lumen/lumen_shape.h"

namespace tessera {

struct NearestVoxel {
    glm::ivec3 voxel{0};
    double mm = 0; ///< from the point to the voxel's centre
};
/// Of a set that is not empty.
NearestVoxel nearestVoxel(const LumenShape& shape, const glm::dvec3& mm);

struct Gap {
    glm::dvec3 fromMm{0}, toMm{0}; ///< centres of the two voxels
    double mm = 0;
};
/// The nearest voxels of two sets, neither empty. Memory for the candidates is charged.
Gap nearestGap(const LumenShape& a, const LumenShape& b, MemoryBudget& ram);

} // namespace tessera
