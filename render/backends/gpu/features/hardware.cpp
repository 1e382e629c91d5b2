// render/backends/gpu/features/hardware.cpp: filtered fetches inside a brick; else texel fetches and float
// arithmetic.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule hardware() {
    return {.define = "FEATURE_HARDWARE", .meaning = "hardware-filtered fetches"};
}

} // namespace tessera::features
