// bricking/analysis/lumen/grow_lumen.h: region growing: the voxels of level 0 that a threshold takes and that
// are connected to a seed over faces. It goes chunk by chunk. Only chunks that it meets are read, each once
// while the cache has room, and only bits of them are kept.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/voxel_set.h"
#include "core/base/progress.h" // ShareDone

#include <cstdint>
#include <functional>
#include <optional>

namespace tessera {

/// Values that are lumen like the seed's: how much of what has grown is unlike tells a leak.
struct LikeSeed {
    LumenRule rule;                               ///< what is taken is like the seed
    std::uint64_t mostUnlike = ~std::uint64_t{0}; ///< voxels; growing stops beyond, and most of them unlike
};

struct GrownLumen {
    VoxelSet voxels;
    std::uint64_t count = 0;  ///< voxels
    std::uint64_t unlike = 0; ///< of them unlike the seed; 0 where nobody asked
    bool stopped = false;     ///< by a limit: there is more of it
};

struct GrowLimits {
    std::uint64_t mostVoxels = ~std::uint64_t{0}; ///< growing stops beyond
    std::optional<LikeSeed> like;
};

/// @param seed  a voxel that the rule takes
/// @param soFar  gets the number of voxels now and then; may be empty
/// Throws InputError naming the budget's option where its bits do not fit, Cancelled and Interrupted, and
/// what reading throws.
GrownLumen growLumen(BrickCache& cache, const VolumeInfo& info, const LumenRule& rule, const glm::ivec3& seed,
                     MemoryBudget& ram, const GrowLimits& limits = {},
                     const std::function<void(std::uint64_t)>& soFar = {});

} // namespace tessera
