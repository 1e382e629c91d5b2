// bricking/statistics/ray_statistics.h: the sampled rays of bricks (brick_rays.h), read from a store's
// statistics for the bricks that show something. They take 1176 bytes a brick, half of it for one part.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"

#include <cstdint>
#include <span>

namespace tessera {

/// Of no brick yet.
/// @param parts  1 or kBrickRayParts; with one, half the memory and a rougher prediction
/// Throws InputError when ram cannot hold four bytes a brick.
BrickRays noBrickRays(const VolumeInfo& info, int parts, MemoryBudget& ram);

/// Adds the bricks with wanted[brick] != 0 that are not there yet; those that are stay where they are.
/// Statistics that are missing, damaged or of another version are no error: rays are then sampled from the
/// voxels, which takes as long as at import.
/// @param wanted  [z][y][x] over bricks
/// Throws InputError when ram cannot hold them, or when voxels cannot be read.
void addBrickRays(const StoreReader& store, std::span<const std::uint8_t> wanted, BrickRays& rays,
                  MemoryBudget& ram, int threads = 0);

} // namespace tessera
