// viewer/session/disc_values.h: statistics of the values in a measured circle.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/volume.h"
#include "core/scene/measurement.h"
#include "viewer/session/viewing.h"

namespace tessera {

/// Of the field on the circle's disc, as trilinear interpolation of level 0 has it, at points half a voxel
/// apart along two axes, further where a disc is large. What is outside the volume does not count. No samples
/// where the three places make no circle. Throws what decoding threw.
DiscValues discValues(BrickCache& cache, const VolumeInfo& info, const Measurement& circle);

} // namespace tessera
