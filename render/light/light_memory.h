// render/light/light_memory.h: the RAM for computing a scene's light per voxel, and the resolution of shadow
// maps.
#pragma once

#include "core/scene/lighting.h"
#include "core/scene/mesh.h"
#include "render/light/shadow_maps.h"

#include <cstddef>
#include <span>

namespace tessera {

/// As fine as a share of the free budget allows: the sides of maps are halved until they fit, those of light
/// maps too.
ShadowQuality shadowQualityFor(const Lighting& lighting, std::size_t freeRamBytes);

/// Shadow maps, and all other memory for computing light. 0: no light per voxel is needed.
/// @param meshes  have maps of their own, of the volume without them
/// @param amongOthers  of a picture with several volumes
std::size_t lightRamBytes(const Lighting& lighting, const VolumeInfo& info, const ShadowQuality& quality,
                          int threads, bool meshes = false, bool amongOthers = false);

/// The meshes' voxels that take a volume's ambient light, at most; 0: it has none, or no meshes.
std::size_t lightOfMeshesBytes(const Lighting& lighting, const VolumeInfo& info,
                               std::span<const SceneMesh> meshes);

} // namespace tessera
