// render/backends/gpu/features/intervals.cpp: rays are cut into intervals, one drawn after another. `March`
// sets it by its rays.
#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::features {

FeatureModule intervals() {
    static_assert(kRayIntervalBytes == 2 * sizeof(float), "a vec2 in common_ray.glsl");
    return {.define = "FEATURE_INTERVALS",
            .meaning = "rays cut into intervals",
            .excludes = kFeatureVisibility, // visibility is counted of the whole volume
            .buffers = {{"INTERVALS", "the intervals of rays", [](const glm::ivec2& rays, const glm::ivec3&) {
                             return kRayIntervalBytes * rayCount(rays);
                         }}}};
}

} // namespace tessera::features
