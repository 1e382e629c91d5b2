// viewer/session/slice_views.h: planes through a volume: samples of the contract's field at screen
// resolution, read through a cache.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "viewer/session/slice_frame.h"

#include <cstdint>
#include <vector>

namespace tessera {

/// The finest level that a pixel can show of such a plane, made coarser until at most `chunks` chunks are
/// needed.
int sliceLevel(const VolumeInfo& info, const SliceFrame& frame, std::size_t chunks);

/// The plane's values at pixel centres, physical units, row by row: trilinear interpolation of the level's
/// samples. NaN outside the volume. Throws what decoding threw.
std::vector<float> sliceValues(BrickCache& cache, const VolumeInfo& info, const SliceFrame& frame, int level,
                               int threads);

/// Greys of a window as display values, in the layout of displayPixels(); black outside the volume.
std::vector<std::uint32_t> greyPixels(const std::vector<float>& values, const GreyWindow& window);

} // namespace tessera
