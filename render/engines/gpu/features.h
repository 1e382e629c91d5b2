// render/engines/gpu/features.h: what a scene can need of the march. Each bit becomes FEATURE_<NAME> 0 or 1
// in the shaders; what is 0 is not compiled. Structure is a feature, numbers are uniforms: moving a slider
// never recompiles.
#pragma once

#include "core/scene.h" // Gradient, Integrator

#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

enum Feature : std::uint32_t {
    kFeatureShading = 1u << 0,     // Phong with a head light; needs gradients
    kFeatureSkipping = 1u << 1,    // empty-space skipping by the distance map
    kFeatureHardware = 1u << 2,    // filtered fetches inside a brick; else texel fetches and float arithmetic
    kFeatureNormalised = 1u << 3,  // 16-bit texels; else 32-bit float
    kFeatureTermination = 1u << 4, // stop below the scene's transmittance
    kFeatureCounting = 1u << 5,    // work counters
    kFeatureMixed = 1u << 6,       // bricks of several levels: interblock interpolation, adaptive strides
    kFeaturePasses = 1u << 7,      // some bricks are absent: rays wait for them and go on in another pass
    kFeatureVisibility = 1u << 8,  // rays count the light that reaches each brick
    // Integrators; none: midpoint. March sets these itself, by its optics.
    kFeatureLinear = 1u << 9,         // constant extinction and linear colour between a segment's ends
    kFeaturePreintegrated = 1u << 10, // means over the values between a segment's ends
    kFeatureSeenColours = 1u << 11,   // with these, colours with attenuation inside the segment
    // How gradients are taken; at most one of these and kFeatureHalfCentralGradient, none: central.
    kFeatureForwardGradient = 1u << 12,
    kFeatureSobelGradient = 1u << 13,
    kFeatureAnalyticGradient = 1u << 14,
    kFeatureSurfaces = 1u << 15, // isosurfaces. March sets it itself, by its optics.
    kFeatureHits = 1u << 16,     // with these, where rays first meet one
    kFeatureHalfCentralGradient = 1u << 17,
};
constexpr std::uint32_t kAllFeatures = (1u << 18) - 1;
constexpr std::uint32_t kIntegratorFeatures = kFeatureLinear | kFeaturePreintegrated | kFeatureSeenColours;

/// Of an integrator that is not automatic.
std::uint32_t integratorFeatures(Integrator integrator);
constexpr std::uint32_t kGradientFeatures =
    kFeatureForwardGradient | kFeatureSobelGradient | kFeatureAnalyticGradient | kFeatureHalfCentralGradient;
/// The bit that has a program take gradients this way; 0 for central differences.
std::uint32_t gradientFeature(Gradient gradient);

struct FeatureName {
    Feature bit;
    const char* define;  // FEATURE_...
    const char* meaning; // for --explain
};
const std::vector<FeatureName>& featureNames();

/// "FEATURE_SHADING 1" and so on, a line each.
std::string featureDefines(std::uint32_t features);

} // namespace tessera
