// render/backends/gpu/features/analytic_gradient.cpp: a gradient from the samples of one value.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule analyticGradient() {
    return {.define = "FEATURE_ANALYTIC_GRADIENT",
            .meaning = "gradients of the interpolation itself",
            .excludes = kGradientFeatures & ~kFeatureAnalyticGradient};
}

} // namespace tessera::features
