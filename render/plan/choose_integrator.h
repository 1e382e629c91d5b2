// render/plan/choose_integrator.h: chooses the integrator for a transfer function on a volume, where the
// scene leaves it open. The midpoint rule is cheapest and, where the function changes little over a segment,
// the most exact. It misses or doubles features that are narrower than the change of the value over a
// segment. There pre-integration is exact but for the value's own bend. docs/measurements/accuracy.md shows
// both sides of the threshold.
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"

namespace tessera {

/// The change of the value over a voxel where the picture is made. It is the 90th percentile, over the cells
/// that can show something, of a third of their range, for edges are some three voxels wide. Physical units.
double typicalChangePerVoxel(const Statistics& statistics, const TransferTable& table,
                             const VolumeInfo& info);

/// The error of the midpoint rule on the integral of extinction where the value rises steadily from lowest to
/// highest by `change` a segment: rms over where segments begin, relative to the integral. 0
/// where nothing shows.
double midpointRampError(const TransferTable& table, double change, double lowest, double highest);

/// The largest difference in premultiplied colour, over the same rise and fall, that attenuation inside
/// segments makes.
/// @param segmentMm  length of a segment
double attenuationDifference(const TransferTable& table, double change, double segmentMm);

/// For a step in voxels: the midpoint rule misses features; or there is no doubt that it does not.
bool isSharp(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
             double stepVoxels);
bool isSmooth(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
              double stepVoxels);

} // namespace tessera
