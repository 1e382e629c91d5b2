// render/backends/gpu/features/skipping.cpp: leaps over proven empty space, by the distance map.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule skipping() {
    return {.define = "FEATURE_SKIPPING", .meaning = "empty-space skipping"};
}

} // namespace tessera::features
