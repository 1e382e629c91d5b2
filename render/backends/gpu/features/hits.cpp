// render/backends/gpu/features/hits.cpp: the first hits of rays on isosurfaces.
#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::features {

FeatureModule hits() {
    static_assert(sizeof(SurfaceHit) == 2 * sizeof(glm::vec4), "two vec4 in march.comp");
    return {.define = "FEATURE_HITS",
            .meaning = "what rays hit first",
            .needs = kFeatureSurfaces,
            .buffers = {{"HITS", "what rays hit first", [](const glm::ivec2& image, const glm::ivec3&) {
                             return sizeof(SurfaceHit) * rayCount(image);
                         }}}};
}

} // namespace tessera::features
