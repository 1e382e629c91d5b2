// render/light/light_memory.cpp: see light_memory.h.
#include "render/light/light_memory.h"

#include "render/light/voxel_light.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr std::size_t kPartsForMaps = 8; // maps take at most this part of the free budget
constexpr int kLeastMap = 32;            // rays along a side

std::size_t mapBytesOf(const Lighting& lighting, ShadowQuality quality, bool lightMaps) {
    quality = qualityOf(quality, lighting);
    if (!lightMaps)
        quality.lightMap.reset();
    std::size_t bytes = 0;
    for (const Light& light : castingLights(lighting.lights))
        bytes += ShadowMaps::bytes(light, quality);
    return bytes;
}

/// One light map is made at a time.
std::size_t sweepBytesOf(const Lighting& lighting, ShadowQuality quality) {
    quality = qualityOf(quality, lighting);
    std::size_t bytes = 0;
    for (const Light& light : castingLights(lighting.lights))
        bytes = std::max(bytes, ShadowMaps::sweepBytes(light, quality));
    return bytes;
}

} // namespace

ShadowQuality shadowQualityFor(const Lighting& lighting, std::size_t freeRamBytes) {
    constexpr int kMostLightMapPart = 4; // light maps lose resolution first, and not all of it
    ShadowQuality quality;
    while (quality.mapSize > kLeastMap &&
           mapBytesOf(lighting, quality, true) > freeRamBytes / kPartsForMaps) {
        if (scattersByMaps(lighting) && quality.lightMapPart < kMostLightMapPart)
            quality.lightMapPart *= 2;
        else
            quality.mapSize /= 2;
    }
    return quality;
}

std::size_t lightRamBytes(const Lighting& lighting, const VolumeInfo& info, const ShadowQuality& quality,
                          int threads, bool meshes, bool amongOthers) {
    return lightChannels(lighting) == 0
               ? 0
               : mapBytesOf(lighting, quality, true) + sweepBytesOf(lighting, quality) +
                     (meshes ? mapBytesOf(lighting, quality, false) : 0) +
                     VoxelLight::bytes(info, lighting, threads, amongOthers, meshes);
}

std::size_t lightOfMeshesBytes(const Lighting& lighting, const VolumeInfo& info,
                               std::span<const SceneMesh> meshes) {
    const auto& occlusion = lighting.occlusion;
    if (meshes.empty() || !occlusion || occlusion->method == OcclusionMethod::histogram)
        return 0;
    return MeshBits::bytesAtMost(meshes, meshLattice(info, *occlusion, meshes).grid, false);
}

} // namespace tessera
