// render/backends/gpu/features/shading.cpp: light on what the volume and its surfaces show; needs gradients.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule shading() {
    return {.define = "FEATURE_SHADING", .meaning = "Phong shading with a head light"};
}

} // namespace tessera::features
