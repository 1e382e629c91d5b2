// tests/support/dummy_feature.h: a feature that marks pixels, as an example of how one is added. All of it is
// in this file, and one line in the list of modules adds it to a program.
#pragma once

#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::test {

constexpr std::uint32_t kFeatureDummy = 1u << features::kCount;
constexpr std::size_t kRayMarkBytes = sizeof(std::uint32_t);

inline FeatureModule dummyFeature() {
    return {.define = "FEATURE_DUMMY",
            .meaning = "marks of pixels",
            .needs = kFeatureCounting,
            .excludes = kFeaturePasses,
            .buffers = {{"MARKS", "the marks of pixels",
                         [](const glm::ivec2& image, const glm::ivec3&) {
                             return kRayMarkBytes * rayCount(image);
                         },
                         7}},
            .bit = kFeatureDummy};
}

inline std::vector<FeatureModule> modulesWithDummy() {
    std::vector<FeatureModule> modules = featureModules();
    modules.push_back(dummyFeature());
    return modules;
}

} // namespace tessera::test
