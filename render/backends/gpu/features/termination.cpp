// render/backends/gpu/features/termination.cpp: rays end below the scene's transmittance.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule termination() {
    return {.define = "FEATURE_TERMINATION", .meaning = "early ray termination"};
}

} // namespace tessera::features
