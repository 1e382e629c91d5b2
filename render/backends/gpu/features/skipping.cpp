// render/backends/gpu/features/skipping.cpp: leaps over what is proven to show nothing, by the map of empty
// space.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule skipping() {
    return {.define = "FEATURE_SKIPPING", .meaning = "empty-space skipping"};
}

} // namespace tessera::features
