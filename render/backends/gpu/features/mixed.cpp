// render/backends/gpu/features/mixed.cpp: bricks of several levels: interblock interpolation, strides by
// level.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule mixed() {
    return {.define = "FEATURE_MIXED", .meaning = "interblock interpolation"};
}

} // namespace tessera::features
