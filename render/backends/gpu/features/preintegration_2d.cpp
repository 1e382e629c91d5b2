// render/backends/gpu/features/preintegration_2d.cpp: colours of a segment with the attenuation inside it,
// from a table.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule preintegration2d() {
    return {.define = "FEATURE_PREINTEGRATION_2D",
            .meaning = "pre-integrated colours with attenuation",
            .needs = kFeaturePreintegrated};
}

} // namespace tessera::features
