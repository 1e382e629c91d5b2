// render/backends/gpu/features/surfaces.cpp: isosurfaces, where rays meet them. `March` sets it by its
// optics.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule surfaces() {
    return {.define = "FEATURE_SURFACES",
            .meaning = "isosurfaces",
            .excludes = kFeatureVisibility,
            .turns = 1600};
}

} // namespace tessera::features
