// bricking/analysis/lumen/leak_guard.h: a guard against leaks of growing airways. Airways end in a lung that
// is nearly as dark as they are. Where their walls are thinner than a voxel, growing explodes into it. The
// guard tightens the threshold until it does not.
#pragma once

#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/seed_threshold.h"

namespace tessera {

struct GuardedLumen {
    GrownLumen grown;
    LumenRule rule;      ///< that it was grown with
    bool leaked = false; ///< the rule around the seed leaks: this one is stricter
};

/// Explosion-controlled region growing (Mori et al., IEEE Trans. Medical Imaging 19, 2000): the threshold
/// goes from the seed's value towards the wall's in steps of a twentieth of the way to half. Where a step
/// makes the lumen grow by more than half, it has leaked, and the step is halved until it is a 160th. The
/// widest threshold before the leak is taken, less the noise of the values.
/// @param seed  a voxel near the seed's value
/// @param always  else a rule that does not leak is told by one growing. Most of what grows there is then
///     like the seed: nearer to it than an eighth of the way to the threshold, or than three times the noise
GuardedLumen growWithoutLeaks(BrickCache& cache, const VolumeInfo& info, const SeedNeighbourhood& around,
                              const glm::ivec3& seed, bool always, MemoryBudget& ram,
                              const std::function<void(std::uint64_t)>& soFar = {});

} // namespace tessera
