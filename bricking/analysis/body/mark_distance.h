// bricking/analysis/body/mark_distance.h: distances between voxel centres, of sets of voxels: what is near a
// set, and how deep another one is. Internal to this room.
//
// Squared distances are in mm2, added axis by axis, x first, each sum rounded to float.
#pragma once

#include "bricking/analysis/body/marks.h"

#include <glm/vec3.hpp>

namespace tessera {

constexpr float kFarAway = 1e30f; // of a set without voxels

/// Marks of all voxels whose squared distance to the nearest marked one is at most mostMm2. Independent of
/// the number of threads.
Marks within(const Marks& marks, const glm::dvec3& spacingMm, double mostMm2, int threads);

/// The largest squared distance of a marked voxel to one that is not: 0 if none is marked, kFarAway if all
/// are. Branch and bound: a block is split only if its middle is so deep that some voxel of the block could
/// be the deepest.
float largestDepth(const Marks& marks, const glm::dvec3& spacingMm);
/// Memory that it takes.
std::size_t depthBytes(const glm::ivec3& extent);

} // namespace tessera
