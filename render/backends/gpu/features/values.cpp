// render/backends/gpu/features/values.cpp: rays keep one of the values along them, or their mean. `March`
// sets it by its optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule values() {
    return {.define = "FEATURE_VALUES",
            .meaning = "single values of rays",
            .excludes = kFeatureVisibility | kIntegratorFeatures | kFeatureShading | kFeatureSurfaces |
                        kFeatureTermination | kGradientFeatures};
}

} // namespace tessera::features
