// render/backends/gpu/features/preintegrated.cpp: means over the values between a segment's ends, from tables
// of sums.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule preintegrated() {
    return {.define = "FEATURE_PREINTEGRATED", .meaning = "pre-integrated segments"};
}

} // namespace tessera::features
