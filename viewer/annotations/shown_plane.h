// viewer/annotations/shown_plane.h: the plane of a slice, beside which measurements and arrows are left out.
#pragma once

#include "core/base/volume.h"
#include "core/scene/mode.h"
#include "viewer/annotations/figure.h"

namespace tessera {

/// A slice of a volume, as thick as a voxel at least.
ShownPlane planeOf(const SlicePlane& slice, const VolumeInfo& info);

} // namespace tessera
