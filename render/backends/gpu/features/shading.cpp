// render/backends/gpu/features/shading.cpp: light on the volume and its surfaces; needs gradients.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule shading() {
    return {.define = "FEATURE_SHADING", .meaning = "Phong shading with a head light"};
}

} // namespace tessera::features
