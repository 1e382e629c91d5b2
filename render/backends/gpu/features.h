// render/backends/gpu/features.h: the features of the GPU ray caster, which are its shader permutations. Each
// becomes FEATURE_<NAME> 0 or 1 in the shaders; code of features at 0 is not compiled. Structure is a
// feature, numbers are uniforms: moving a slider never recompiles.
#pragma once

#include "core/scene/scene.h" // Gradient, Integrator

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

// The description of a feature (shader permutation) of the GPU ray caster: its define, the features that it
// needs and excludes, and the storage buffers that it brings.

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

/// One line a feature. kFeature<Name> is its bit, by its place here. The function of the second name
/// describes it, in features/ (a file a kind). Integrators, none of the three: midpoint.
/// Gradients, none of the four: central. `March` sets integrators, surfaces, lights, materials, values and
/// gradient opacity itself, by its optics. Of several volumes a feature is there where one of them needs it.
#define TESSERA_FEATURES(FEATURE)                                                                            \
    FEATURE(Shading, shading)                                                                                \
    FEATURE(Skipping, skipping)                                                                              \
    FEATURE(Hardware, hardware)                                                                              \
    FEATURE(Normalised, normalised)                                                                          \
    FEATURE(Termination, termination)                                                                        \
    FEATURE(Counting, counting)                                                                              \
    FEATURE(Mixed, mixed)                                                                                    \
    FEATURE(Passes, passes)                                                                                  \
    FEATURE(Visibility, visibility)                                                                          \
    FEATURE(Linear, linear)                                                                                  \
    FEATURE(Preintegrated, preintegrated)                                                                    \
    FEATURE(Preintegration2d, preintegration2d)                                                              \
    FEATURE(ForwardGradient, forwardGradient)                                                                \
    FEATURE(SobelGradient, sobelGradient)                                                                    \
    FEATURE(AnalyticGradient, analyticGradient)                                                              \
    FEATURE(Surfaces, surfaces)                                                                              \
    FEATURE(Hits, hits)                                                                                      \
    FEATURE(HalfCentralGradient, halfCentralGradient)                                                        \
    FEATURE(Places, places)                                                                                  \
    FEATURE(Lights, lights)                                                                                  \
    FEATURE(Materials, materials)                                                                            \
    FEATURE(VoxelLight, voxelLight)                                                                          \
    FEATURE(Emission, emission)                                                                              \
    FEATURE(Values, values)                                                                                  \
    FEATURE(Slabs, slabs)                                                                                    \
    FEATURE(Intervals, intervals)                                                                            \
    FEATURE(GradientOpacity, gradientOpacity)                                                                \
    FEATURE(CubicGradient, cubicGradient)                                                                    \
    FEATURE(Labels, labels)                                                                                  \
    FEATURE(Fused, fused)                                                                                    \
    FEATURE(OwnCuts, ownCuts)

namespace tessera {

/// Of FEATURE_OWN_CUTS: slabs of all volumes.
constexpr int kMostCutSlabs = 48;

namespace features {
#define TESSERA_FEATURE(Name, name) FeatureModule name();
TESSERA_FEATURES(TESSERA_FEATURE)
#undef TESSERA_FEATURE
enum Place : unsigned {
#define TESSERA_FEATURE(Name, name) kPlaceOf##Name,
    TESSERA_FEATURES(TESSERA_FEATURE)
#undef TESSERA_FEATURE
        kCount
};
static_assert(kCount <= 32, "a bit each");
} // namespace features

enum Feature : std::uint32_t {
#define TESSERA_FEATURE(Name, name) kFeature##Name = 1u << features::kPlaceOf##Name,
    TESSERA_FEATURES(TESSERA_FEATURE)
#undef TESSERA_FEATURE
};
constexpr std::uint32_t kAllFeatures = (1u << features::kCount) - 1;
constexpr std::uint32_t kIntegratorFeatures =
    kFeatureLinear | kFeaturePreintegrated | kFeaturePreintegration2d;

/// Of an integrator that is not automatic.
std::uint32_t integratorFeatures(Integrator integrator);
constexpr std::uint32_t kGradientFeatures = kFeatureForwardGradient | kFeatureSobelGradient |
                                            kFeatureAnalyticGradient | kFeatureHalfCentralGradient |
                                            kFeatureCubicGradient;
/// The bit that has a program take gradients this way; 0 for central differences.
std::uint32_t gradientFeature(Gradient gradient);

/// Of every feature, in the order of their bits.
const std::vector<FeatureModule>& featureModules();

struct FeatureName {
    Feature bit;
    const char* define;  // FEATURE_...
    const char* meaning; // for --explain
};
const std::vector<FeatureName>& featureNames();

/// "FEATURE_SHADING 1" and so on, a line each.
std::string featureDefines(std::uint32_t features,
                           const std::vector<FeatureModule>& modules = featureModules());

} // namespace tessera
