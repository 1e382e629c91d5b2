// render/backends/gpu/features/lights.cpp: the scene's own lights in place of a head light. `March` sets it
// by its optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule lights() {
    return {.define = "FEATURE_LIGHTS",
            .meaning = "lights of the scene's own",
            .needs = kFeatureShading,
            .turns = 100}; // a light's power: 11 at most
}

} // namespace tessera::features
