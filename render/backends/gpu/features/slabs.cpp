// render/backends/gpu/features/slabs.cpp: rays are clipped to the space between planes: slices, and cuts that
// are convex. `March` sets it by its rays.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule slabs() {
    return {.define = "FEATURE_SLABS",
            .meaning = "rays clipped to slabs",
            .excludes = kFeatureVisibility}; // visibility is counted of the whole volume
}

} // namespace tessera::features
