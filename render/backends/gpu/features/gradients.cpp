// render/backends/gpu/features/gradients.cpp: features of gradients: the operators but for central
// differences over a whole pitch, which need none.
#include "render/backends/gpu/features.h"

namespace tessera::features {

// A gradient from four values.
FeatureModule forwardGradient() {
    return {.define = "FEATURE_FORWARD_GRADIENT",
            .meaning = "gradients by forward differences",
            .excludes = kGradientFeatures & ~kFeatureForwardGradient};
}

// Central differences over half a pitch to either side.
FeatureModule halfCentralGradient() {
    return {.define = "FEATURE_HALF_CENTRAL_GRADIENT",
            .meaning = "gradients over one pitch",
            .excludes = kGradientFeatures & ~kFeatureHalfCentralGradient};
}

// A gradient from 27 values.
FeatureModule sobelGradient() {
    return {.define = "FEATURE_SOBEL_GRADIENT",
            .meaning = "gradients by smoothed differences (Sobel)",
            .excludes = kGradientFeatures & ~kFeatureSobelGradient,
            .turns = 400};
}

// A gradient from the samples of one value.
FeatureModule analyticGradient() {
    return {.define = "FEATURE_ANALYTIC_GRADIENT",
            .meaning = "gradients of the interpolation itself",
            .excludes = kGradientFeatures & ~kFeatureAnalyticGradient};
}

// A gradient from 64 values.
FeatureModule cubicGradient() {
    return {.define = "FEATURE_CUBIC_GRADIENT",
            .meaning = "gradients of the cubic B-spline",
            .excludes = kGradientFeatures & ~kFeatureCubicGradient,
            .turns = 800};
}

} // namespace tessera::features
