// render/backends/gpu/features/places.cpp: rays through given places, not through the middle of every pixel.
// `March` sets it by its rays.
#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::features {

FeatureModule places() {
    static_assert(kRayPlaceBytes == 2 * sizeof(float), "a vec2 in common_ray.glsl");
    return {.define = "FEATURE_PLACES",
            .meaning = "rays through given places",
            .excludes = kFeatureVisibility, // it has a picture of its own
            .buffers = {{"PLACES", "the places of the rays", [](const glm::ivec2& rays, const glm::ivec3&) {
                             return kRayPlaceBytes * rayCount(rays);
                         }}}};
}

} // namespace tessera::features
