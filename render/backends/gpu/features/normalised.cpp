// render/backends/gpu/features/normalised.cpp: texels of 16 bits; else 32-bit floats.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule normalised() {
    return {.define = "FEATURE_NORMALISED", .meaning = "16-bit voxels"};
}

} // namespace tessera::features
