// render/engines/gpu/features/seen_colours.cpp: colours of a segment with the attenuation inside it, from a
// table.
#include "render/engines/gpu/features.h"

namespace tessera::features {

FeatureModule seenColours() {
    return {.define = "FEATURE_SEENCOLOURS",
            .meaning = "pre-integrated colours with attenuation",
            .needs = kFeaturePreintegrated};
}

} // namespace tessera::features
