// render/plan/choose_integrator.h: chooses the integrator for a transfer function on a volume, if the scene
// does not. The midpoint rule is cheapest and, if the function changes little over a segment, the most
// accurate. It misses or doubles features that are narrower than the change of the value over a segment.
// There pre-integration is exact apart from the curvature of the value. docs/measurements/accuracy.md shows
// both sides of the threshold.
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "core/scene/transfer_function.h"

namespace tessera {

/// The change of the value over a voxel in visible regions. It is the 90th percentile, over occupied cells,
/// of a third of their range, because edges are some three voxels wide. Physical units.
double typicalChangePerVoxel(const Statistics& statistics, const TransferTable& table,
                             const VolumeInfo& info);

/// The error of the midpoint rule on the integral of extinction for a value that rises linearly from lowest
/// to highest by `change` per segment. It is the rms over offsets of segments, relative to the integral. 0
/// for an invisible function.
double midpointRampError(const TransferTable& table, double change, double lowest, double highest);

/// The largest effect of attenuation inside segments on premultiplied colour, over the same rise and fall.
/// @param segmentMm  length of a segment
double attenuationDifference(const TransferTable& table, double change, double segmentMm);

/// For a step in voxels: true if the midpoint rule misses features; true if it certainly does not.
bool isSharp(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
             double stepVoxels);
bool isSmooth(const Statistics& statistics, const TransferTable& table, const VolumeInfo& info,
              double stepVoxels);

} // namespace tessera
