// viewer/session/disc_values.h: statistics of the values in a measured circle.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/volume.h"
#include "core/scene/measurement.h"
#include "viewer/session/viewing.h"

namespace tessera {

/// Values on the circle's disc by trilinear interpolation of level 0, at points half a voxel apart along two
/// axes, further apart for a large disc. Points outside the volume do not count. No samples if the three
/// points form no circle. Throws what decoding threw.
DiscValues discValues(BrickCache& cache, const VolumeInfo& info, const Measurement& circle);

} // namespace tessera
