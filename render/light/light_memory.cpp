// render/light/light_memory.cpp: see light_memory.h.
#include "render/light/light_memory.h"

#include "render/light/light_sweep.h"
#include "render/light/voxel_light.h"

#include <algorithm>

namespace tessera {
namespace {

constexpr std::size_t kPartsForMaps = 8; // maps take at most this part of the free budget
constexpr int kLeastMap = 32;            // rays along a side

/// @param lightMaps  those count, too, and the room in which one is made
std::size_t mapBytesOf(const Lighting& lighting, ShadowQuality quality, bool lightMaps) {
    quality = qualityOf(quality, lighting);
    if (!lightMaps)
        quality.lightMap.reset();
    std::size_t bytes = 0;
    if (quality.lightMap) // one is made at a time
        bytes += MapSweep::bytes(
            std::max(LightMapping::kLeastSize / 2, quality.lightMap->size / quality.lightMapPart));
    for (const Light& light : castingLights(lighting.lights))
        bytes += ShadowMaps::bytes(light, quality);
    return bytes;
}

} // namespace

ShadowQuality shadowQualityFor(const Lighting& lighting, std::size_t freeRamBytes) {
    ShadowQuality quality;
    while (quality.mapSize > kLeastMap &&
           mapBytesOf(lighting, quality, true) > freeRamBytes / kPartsForMaps) {
        quality.mapSize /= 2;
        quality.lightMapPart *= 2;
    }
    return quality;
}

std::size_t lightRamBytes(const Lighting& lighting, const VolumeInfo& info, const ShadowQuality& quality,
                          int threads, bool meshes, bool amongOthers) {
    return lightChannels(lighting) == 0
               ? 0
               : mapBytesOf(lighting, quality, true) + (meshes ? mapBytesOf(lighting, quality, false) : 0) +
                     VoxelLight::bytes(info, lighting, threads, amongOthers);
}

} // namespace tessera
