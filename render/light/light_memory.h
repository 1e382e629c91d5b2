// render/light/light_memory.h: the RAM that computing a scene's voxel light takes, and the resolution of
// shadow maps that it allows.
#pragma once

#include "core/scene/lighting.h"
#include "render/light/shadow_maps.h"

#include <cstddef>

namespace tessera {

/// As fine as a share of what is free allows: maps' sides are halved until they fit.
ShadowQuality shadowQualityFor(const Lighting& lighting, std::size_t freeRamBytes);

/// Shadow maps, and all that computing light takes besides. 0: no light of voxels is needed.
std::size_t lightRamBytes(const Lighting& lighting, const VolumeInfo& info, const ShadowQuality& quality,
                          int threads);

} // namespace tessera
