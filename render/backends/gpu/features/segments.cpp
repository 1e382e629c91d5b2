// render/backends/gpu/features/segments.cpp: features of segments: their integrators but for the midpoint
// rule, and what rays take from them.
#include "render/backends/gpu/features.h"

namespace tessera::features {

// Segments of constant extinction, and linear colour between their ends.
FeatureModule linear() {
    return {.define = "FEATURE_LINEAR",
            .meaning = "segments of linear colour",
            .excludes = kFeaturePreintegrated};
}

// Means over the values between a segment's ends, from tables of sums.
FeatureModule preintegrated() {
    return {.define = "FEATURE_PREINTEGRATED", .meaning = "pre-integrated segments"};
}

// Colours of a segment with the attenuation inside it, from a table.
FeatureModule preintegration2d() {
    return {.define = "FEATURE_PREINTEGRATION_2D",
            .meaning = "pre-integrated colours with attenuation",
            .needs = kFeaturePreintegrated};
}

// A factor on extinctions, by the gradient's length. `March` sets it by its optics.
FeatureModule gradientOpacity() {
    return {.define = "FEATURE_GRADIENT_OPACITY",
            .meaning = "opacity by gradient",
            .excludes = kFeatureValues,
            .turns = 20};
}

// Shares of the function and a medium of labels, from planes beside the values.
FeatureModule labels() {
    return {.define = "FEATURE_LABELS",
            .meaning = "labels, kept beside the values",
            .excludes = kFeatureValues | kFeatureSurfaces | kIntegratorFeatures,
            .turns = 64};
}

// Isosurfaces, where rays meet them. `March` sets it by its optics.
FeatureModule surfaces() {
    return {.define = "FEATURE_SURFACES",
            .meaning = "isosurfaces",
            .excludes = kFeatureVisibility,
            .turns = 1600};
}

// Rays keep one of the values along them, or their mean. `March` sets it by its optics.
FeatureModule values() {
    return {.define = "FEATURE_VALUES",
            .meaning = "single values of rays",
            .excludes = kFeatureVisibility | kIntegratorFeatures | kFeatureShading | kFeatureSurfaces |
                        kFeatureTermination | kGradientFeatures};
}

} // namespace tessera::features
