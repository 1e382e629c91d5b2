// bricking/analysis/lumen/grow_lumen.h: region growing: the voxels of level 0 that pass a threshold and are
// connected to a seed over faces. It proceeds chunk by chunk. Only chunks that the region enters are read,
// each once while the cache has room, and only bits of them are kept.
#pragma once

#include "bricking/analysis/lumen/lumen_values.h"
#include "bricking/analysis/lumen/seed_threshold.h"
#include "bricking/analysis/lumen/voxel_set.h"
#include "core/base/progress.h" // ShareDone

#include <cstdint>
#include <functional>
#include <optional>

namespace tessera {

/// Values like the seed's: a large share of unlike voxels in the region indicates a leak.
struct LikeSeed {
    LumenRule rule; ///< voxels that pass this are like the seed
    std::uint64_t mostUnlike =
        ~std::uint64_t{0}; ///< voxels; growing stops if there are more, and most of them are unlike
};

struct GrownLumen {
    VoxelSet voxels;
    std::uint64_t count = 0;  ///< voxels
    std::uint64_t unlike = 0; ///< of them unlike the seed; 0 if not requested
    bool stopped = false;     ///< stopped by a limit: the region is larger
};

struct GrowLimits {
    std::uint64_t mostVoxels = ~std::uint64_t{0}; ///< growing stops if there are more
    std::optional<LikeSeed> like;
};

/// @param seed  a voxel that passes the rule
/// @param soFar  called now and then with the number of voxels; may be empty
/// Throws InputError naming the budget's option if its bits do not fit, Cancelled, Interrupted, and as
/// reading chunks does.
GrownLumen growLumen(BrickCache& cache, const VolumeInfo& info, const LumenRule& rule, const glm::ivec3& seed,
                     MemoryBudget& ram, const GrowLimits& limits = {},
                     const std::function<void(std::uint64_t)>& soFar = {});

// A guard against leaks of growing airways. Airways end in a lung that is nearly as dark as they are. Where
// their walls are thinner than a voxel, growing leaks into it. The guard tightens the threshold until it does
// not.

struct GuardedLumen {
    GrownLumen grown;
    LumenRule rule;      ///< the rule of the region
    bool leaked = false; ///< the rule by the seed leaks: this one is stricter
};

/// Explosion-controlled region growing (Mori et al., IEEE Trans. Medical Imaging 19, 2000): the threshold
/// goes from the seed's value towards the wall's in steps of a twentieth, up to half way. If a step enlarges
/// the lumen by more than half, it has leaked, and the step is halved down to a 160th. The widest threshold
/// before the leak is taken, less the noise of the values.
/// @param seed  a voxel near the seed's value
/// @param always  false: one growing decides whether the rule leaks. It does not if most of the region is
/// like
///     the seed: within an eighth of the distance to the threshold, or three times the noise
GuardedLumen growWithoutLeaks(BrickCache& cache, const VolumeInfo& info, const SeedNeighbourhood& around,
                              const glm::ivec3& seed, bool always, MemoryBudget& ram,
                              const std::function<void(std::uint64_t)>& soFar = {});

} // namespace tessera
