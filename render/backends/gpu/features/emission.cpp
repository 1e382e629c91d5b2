// render/backends/gpu/features/emission.cpp: tissue that sends light of its own, and its effect on the light
// from all sides: one of each colour. `March` sets it by its optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule emission() {
    return {.define = "FEATURE_EMISSION",
            .meaning = "tissue that sends light",
            .needs = kFeatureLights,
            .turns = 10};
}

} // namespace tessera::features
