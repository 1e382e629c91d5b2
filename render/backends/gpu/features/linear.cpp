// render/backends/gpu/features/linear.cpp: segments of constant extinction, and linear colour between their
// ends.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule linear() {
    return {.define = "FEATURE_LINEAR",
            .meaning = "segments of linear colour",
            .excludes = kFeaturePreintegrated};
}

} // namespace tessera::features
