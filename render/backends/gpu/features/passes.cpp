// render/backends/gpu/features/passes.cpp: some bricks are absent: rays wait for them and go on in another
// pass.
#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::features {

FeatureModule passes() {
    return {.define = "FEATURE_PASSES",
            .meaning = "several passes",
            .buffers = {{"WANTED", "the bricks that rays wait for",
                         [](const glm::ivec2&, const glm::ivec3& bricks) { return wantedBytes(bricks); },
                         UINT32_MAX}}};
}

} // namespace tessera::features
