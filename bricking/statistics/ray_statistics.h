// bricking/statistics/ray_statistics.h: the sampled rays of bricks (brick_rays.h), read from a store's
// statistics for visible bricks. They take 1176 bytes per brick, half of that with one part.
#pragma once

#include "bricking/statistics/brick_rays.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"

#include <cstdint>
#include <span>

namespace tessera {

/// Initially of no brick.
/// @param parts  1 or kBrickRayParts; one takes half the memory, for a less accurate prediction
/// Throws InputError when ram cannot hold four bytes a brick.
BrickRays noBrickRays(const VolumeInfo& info, int parts, MemoryBudget& ram);

/// Adds the missing bricks with wanted[brick] != 0; present ones do not move. Missing or damaged statistics,
/// or those of another version, are no error: rays are then sampled from the voxels, which takes as long as
/// at import.
/// @param wanted  [z][y][x] over bricks
/// Throws InputError when ram cannot hold them, or when voxels cannot be read.
void addBrickRays(const StoreReader& store, std::span<const std::uint8_t> wanted, BrickRays& rays,
                  MemoryBudget& ram, int threads = 0);

} // namespace tessera
