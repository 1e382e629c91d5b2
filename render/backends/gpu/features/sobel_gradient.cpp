// render/backends/gpu/features/sobel_gradient.cpp: a gradient from 27 values.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule sobelGradient() {
    return {.define = "FEATURE_SOBEL_GRADIENT",
            .meaning = "gradients by smoothed differences (Sobel)",
            .excludes = kGradientFeatures & ~kFeatureSobelGradient,
            .turns = 400};
}

} // namespace tessera::features
