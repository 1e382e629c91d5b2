// tests/render/light/light_map_picture_test.cpp: pictures with light maps.
#include "tests/support/paths_and_kept.h"
#include "tests/support/reference_light.h"

#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <vector>

namespace tessera::test {
namespace {

Light backLight() { // 150 degrees from the viewer
    Light light;
    light.kind = LightKind::directional;
    light.direction = {-0.354, 0.354, -0.866};
    light.shadow = true;
    return light;
}

TEST(LightMapPicture, IsNearerToPaths) {
    const char* const other = std::getenv("TESSERA_SCATTER_STORE");
    const bool tells = std::getenv("TESSERA_TELL") != nullptr;
    const char* const only = std::getenv("TESSERA_SCATTER_PRESET");
    for (const std::string preset : {"soft-tissue", "bone-1"})
        for (const double g : {0.8, 0.95}) {
            if (only && preset != only)
                continue;
            PathsAndKept pictures(other ? other : storePath("torso").string(), preset, backLight(),
                                  tells ? 128 : 32, 8, g);
            const double f = pictures.ofPhase();
            const double without = pictures.rms(0, false, f), all = pictures.rms(0, true, f);
            tell("%s, g %g: phase %.3f, rms of further scatterings %.4f, of all %.4f\n", preset.c_str(), g, f,
                 without, all);
            const auto measure = [&](const char* what, const std::function<void(Lighting&)>& change) {
                pictures.scatter(change);
                const double best = pictures.bestFactor(false, f), bestOfAll = pictures.bestFactor(true, f);
                const double with = pictures.rms(1, false, f), allWith = pictures.rms(1, true, f);
                tell("    %s: %.4f (%.2f), best %.2f (%.2f); of all %.4f (%.2f), best %.2f (%.2f)\n", what, with,
                     with / without, best, pictures.rms(best, false, f) / without, allWith, allWith / all,
                     bestOfAll, pictures.rms(bestOfAll, true, f) / all);
                std::fflush(stdout);
            };
            const auto map = [&](int size, double mapG) {
                return [=](Lighting& lighting) {
                    lighting.scatterBy = ScatterSource::map;
                    lighting.lightMap = {size, mapG};
                };
            };
            measure("rays, 2 mm", [](Lighting&) {});
            measure("map 96, its g", map(96, g));
            if (!tells)
                continue;
            measure("rays, 8 mm", [](Lighting& lighting) { lighting.scatterRadiusMm = 8; });
            measure("map 96, g 0.8", map(96, 0.8));
            measure("map 96, g 0.9", map(96, 0.9));
            measure("map 96, g 0.5", map(96, 0.5));
            measure("map 48, its g", map(48, g));
            measure("map 128, its g", map(128, g));
            measure("map 192, its g", map(192, g));
        }
}

} // namespace
} // namespace tessera::test
