// bricking/analysis/lumen/leak_guard.h: a guard against leaks of growing airways. Airways end in a lung that
// is nearly as dark as they are. Where their walls are thinner than a voxel, growing leaks into it. The guard
// tightens the threshold until it does not.
#pragma once

#include "bricking/analysis/lumen/grow_lumen.h"
#include "bricking/analysis/lumen/seed_threshold.h"

namespace tessera {

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
