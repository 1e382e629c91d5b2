// render/backends/gpu/features/voxel_light.cpp: shares of light that reach samples, from planes beside the
// values: occlusion and shadows. `March` sets it by its optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule voxelLight() {
    return {.define = "FEATURE_VOXEL_LIGHT",
            .meaning = "occlusion and shadows, kept beside the values",
            .needs = kFeatureLights,
            .turns = 8};
}

} // namespace tessera::features
