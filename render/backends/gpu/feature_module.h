// render/backends/gpu/feature_module.h: the description of a feature (shader permutation) of the GPU ray
// caster: its define, the features that it needs and excludes, and the storage buffers that it brings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// A storage buffer of a program. Shaders name its binding BINDING_<name>.
struct StorageBuffer {
    const char* name;
    const char* label; // its use, for messages when memory is short
    /// Its size, from pixels and bricks (render/contract/ray_state.h); null: its user knows.
    std::size_t (*bytes)(const glm::ivec2& imageSize, const glm::ivec3& bricks) = nullptr;
    std::uint32_t first = 0; // every word of it when rays begin
};

struct FeatureModule {
    const char* define;         // FEATURE_..., 0 or 1 in the shaders
    const char* meaning;        // for --explain
    std::uint32_t needs = 0;    // bits, all of which it goes with
    std::uint32_t excludes = 0; // bits, none of which it goes with; one of two says so
    std::vector<StorageBuffer> buffers = {};
    int turns = 0;         // of loops that one more sample may take for it (shaders/common_turns.glsl)
    std::uint32_t bit = 0; // of TESSERA_FEATURES: given by featureModules()
};

} // namespace tessera
