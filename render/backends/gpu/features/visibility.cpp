// render/backends/gpu/features/visibility.cpp: rays count the light that reaches each brick.
#include "bricking/levels/visibility.h"
#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::features {

FeatureModule visibility() {
    static_assert(sizeof(SeenBrick) == kSeenBytes, "two words in march.comp");
    const char* const label = "what is seen of bricks";
    return {
        .define = "FEATURE_VISIBILITY",
        .meaning = "counting of what is seen",
        .excludes = kIntegratorFeatures, // it is counted by the midpoint rule
        .buffers = {
            {"SEEN", label, [](const glm::ivec2&, const glm::ivec3& bricks) { return seenBytes(bricks); }},
            {"LAST_BRICK", label,
             [](const glm::ivec2& image, const glm::ivec3&) { return kRayLastBrickBytes * rayCount(image); },
             UINT32_MAX}}};
}

} // namespace tessera::features
