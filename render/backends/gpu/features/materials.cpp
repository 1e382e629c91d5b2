// render/backends/gpu/features/materials.cpp: materials by value. `March` sets it by its optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule materials() {
    return {.define = "FEATURE_MATERIALS",
            .meaning = "materials by values",
            .needs = kFeatureLights,
            .turns = 20};
}

} // namespace tessera::features
