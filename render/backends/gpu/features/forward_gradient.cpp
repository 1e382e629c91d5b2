// render/backends/gpu/features/forward_gradient.cpp: a gradient from four values.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule forwardGradient() {
    return {.define = "FEATURE_FORWARD_GRADIENT",
            .meaning = "gradients by forward differences",
            .excludes = kGradientFeatures & ~kFeatureForwardGradient};
}

} // namespace tessera::features
