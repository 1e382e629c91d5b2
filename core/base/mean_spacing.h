// core/base/mean_spacing.h: the mean spacing of voxels, by which lengths per voxel become lengths per
// millimetre (core/scene/gradient_opacity.h).
#pragma once

#include "core/base/volume.h"

namespace tessera {

/// Millimetres: the mean of the three spacings.
inline double meanSpacingMm(const VolumeInfo& info) {
    const glm::dvec3 spacing = info.spacingMm();
    return (spacing.x + spacing.y + spacing.z) / 3;
}

} // namespace tessera
