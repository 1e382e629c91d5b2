// render/backends/gpu/features/field.cpp: features of the field: how values are stored, fetched and blended.
#include "render/backends/gpu/features.h"

namespace tessera::features {

// Filtered fetches inside a brick; else texel fetches and float arithmetic.
FeatureModule hardware() {
    return {.define = "FEATURE_HARDWARE", .meaning = "hardware-filtered fetches"};
}

// Texels of 16 bits; else 32-bit floats.
FeatureModule normalised() {
    return {.define = "FEATURE_NORMALISED", .meaning = "16-bit voxels"};
}

// Bricks of several levels: interblock interpolation, strides by level.
FeatureModule mixed() {
    return {.define = "FEATURE_MIXED", .meaning = "interblock interpolation"};
}

} // namespace tessera::features
