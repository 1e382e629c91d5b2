// core/base/gantry_tilt.h: the tilt of a volume's slices against their stacking direction, from its affine. A
// CT's tilted gantry appears there as a shear.
#pragma once

#include "core/base/volume.h"

namespace tessera {

/// Degrees between the slices' normal and the direction in which slices follow each other; 0 for a box.
/// Positive where the slices' anterior edge lies nearer to the head than their posterior edge, negative the
/// other way. Positive is a gantry whose top leans away from the table (patient on the back, head first).
/// @param stackAxis  the axis along which slices follow each other
double gantryTiltDegrees(const glm::dmat4& patientFromVoxel, int stackAxis = 2);
/// Of a volume; its originalOrder gives the slice axis of its source.
double gantryTiltDegrees(const VolumeInfo& info);

} // namespace tessera
