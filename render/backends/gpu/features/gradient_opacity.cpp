// render/backends/gpu/features/gradient_opacity.cpp: a factor on extinctions, by the gradient's length.
// `March` sets it by its optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule gradientOpacity() {
    return {.define = "FEATURE_GRADIENT_OPACITY",
            .meaning = "opacity by gradient",
            .excludes = kFeatureValues,
            .turns = 20};
}

} // namespace tessera::features
