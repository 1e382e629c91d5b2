// render/backends/gpu/features/counting.cpp: segments, samples and fetches are counted.
#include "render/backends/gpu/features.h"

namespace tessera::features {

FeatureModule counting() {
    return {.define = "FEATURE_COUNTING", .meaning = "work counters"};
}

} // namespace tessera::features
