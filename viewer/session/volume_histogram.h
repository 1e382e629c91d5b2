// viewer/session/volume_histogram.h: the histogram of a volume, fine enough to edit a transfer
// function over it.
#pragma once

#include "render/plan/frame_plan.h"

#include <vector>

namespace tessera {

/// Counts over equal bins of [lowest, highest], physical units, of all samples of the finest level that has
/// at most two million. Read through the cache.
/// @param bins  at least 1
/// Throws what decoding threw.
std::vector<double> volumeHistogram(const Layer& volume, double lowest, double highest, int bins);

} // namespace tessera
