// render/light/light_memory.h: what the light of a scene's voxels takes of RAM while it is computed, and how
// fine maps of shadows may be for it.
#pragma once

#include "core/lighting.h"
#include "render/light/shadow_maps.h"

#include <cstddef>

namespace tessera {

/// As fine as a share of what is free allows: maps' sides are halved until they fit.
ShadowQuality shadowQualityFor(const Lighting& lighting, std::size_t freeRamBytes);

/// Maps of shadows, and all that computing light takes besides. 0: no light of voxels is needed.
std::size_t lightRamBytes(const Lighting& lighting, const VolumeInfo& info, const ShadowQuality& quality,
                          int threads);

} // namespace tessera
