// tests/support/light_maps.h: lights behind what is seen, and maps of lights through prepared pictures.
#pragma once

#include "core/base/progress.h" // secondsSince
#include "render/light/scene_light.h"
#include "tests/support/scene_fixture.h"

#include <chrono>
#include <optional>

namespace tessera::test {

/// 150 degrees from the viewer.
inline Light backLight() {
    Light light;
    light.kind = LightKind::directional;
    light.direction = {-0.354, 0.354, -0.866};
    light.shadow = true;
    return light;
}

/// A prepared picture's maps of one light of the scene, and its path.
struct MadeMaps {
    MadeMaps(Prepared& prepared, const PlacedLight& light, std::optional<LightMapping> mapping,
             int mapSize = 512, int threads = 0)
        : path(lightPathOf(prepared.p, nullptr)), maps(light, path, [&] {
              ShadowQuality quality;
              quality.mapSize = mapSize;
              quality.lightMap = mapping;
              return quality;
          }()) {
        const auto start = std::chrono::steady_clock::now();
        maps.build(path, threads);
        seconds = secondsSince(start);
    }
    LightPath path;
    ShadowMaps maps;
    double seconds = 0;
};

} // namespace tessera::test
