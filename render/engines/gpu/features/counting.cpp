// render/engines/gpu/features/counting.cpp: segments, samples and fetches are counted.
#include "render/engines/gpu/features.h"

namespace tessera::features {

FeatureModule counting() {
    return {.define = "FEATURE_COUNTING", .meaning = "work counters"};
}

} // namespace tessera::features
