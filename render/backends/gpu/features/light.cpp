// render/backends/gpu/features/light.cpp: features of light on samples.
#include "render/backends/gpu/features.h"

namespace tessera::features {

// Light on the volume and its surfaces; needs gradients.
FeatureModule shading() {
    return {.define = "FEATURE_SHADING", .meaning = "Phong shading with a head light"};
}

// The scene's own lights in place of a head light. `March` sets it by its optics.
FeatureModule lights() {
    return {.define = "FEATURE_LIGHTS",
            .meaning = "lights of the scene's own",
            .needs = kFeatureShading,
            .turns = 100}; // a light's power: 11 at most
}

// Materials by value. `March` sets it by its optics.
FeatureModule materials() {
    return {.define = "FEATURE_MATERIALS",
            .meaning = "materials by values",
            .needs = kFeatureLights,
            .turns = 20};
}

// Shares of light that reach samples, from planes beside the values: occlusion and shadows. `March` sets it
// by its optics.
FeatureModule voxelLight() {
    return {.define = "FEATURE_VOXEL_LIGHT",
            .meaning = "occlusion and shadows, kept beside the values",
            .needs = kFeatureLights,
            .turns = 8};
}

// Tissue that sends light of its own, and its effect on the light from all sides: one of each colour. `March`
// sets it by its optics.
FeatureModule emission() {
    return {.define = "FEATURE_EMISSION",
            .meaning = "tissue that sends light",
            .needs = kFeatureLights,
            .turns = 10};
}

} // namespace tessera::features
