// render/engines/native/fine_blocks.h: which blocks of 2^3 voxels of an occupied cell can show anything: bits
// of the map of empty space (render/empty_space/distance_map.h), from the samples that the engine holds
// (block_ranges.h).
#pragma once

#include "bricking/statistics/statistics.h"
#include "core/transfer_function.h"
#include "render/contract/optics.h"
#include "render/empty_space/occupancy.h"
#include "render/engines/native/host_plane.h"

#include <span>

namespace tessera {

/// Whether one picture gains more than that costs.
bool fineBlocksPay(const Occupancy& occupancy, bool mixed, std::size_t rays);

/// Sets the bits of all occupied cells. Needs a map of cells, and all bricks. Cells whose every value shows
/// are passed over: all their blocks show.
/// @param levels  of mixed levels, or null; @param level  else: of all bricks
/// @param map  a copy of the occupancy's. Returns how many cells were looked at.
std::size_t refineBlocks(const HostPlane& plane, const Occupancy& occupancy, const Statistics& statistics,
                         const LevelMap* levels, int level, const TransferTable& table, const Optics& optics,
                         const native::PacketTarget& target, int threads, std::span<SkippingTexel> map);

} // namespace tessera
