// render/backends/gpu/features/cubic_gradient.cpp: a gradient from 64 values.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule cubicGradient() {
    return {.define = "FEATURE_CUBIC_GRADIENT",
            .meaning = "gradients of the cubic B-spline",
            .excludes = kGradientFeatures & ~kFeatureCubicGradient,
            .turns = 800};
}

} // namespace tessera::features
