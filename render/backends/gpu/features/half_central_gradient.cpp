// render/backends/gpu/features/half_central_gradient.cpp: central differences over half a pitch to either
// side.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule halfCentralGradient() {
    return {.define = "FEATURE_HALF_CENTRAL_GRADIENT",
            .meaning = "gradients over one pitch",
            .excludes = kGradientFeatures & ~kFeatureHalfCentralGradient};
}

} // namespace tessera::features
