// render/backends/gpu/features/rays.cpp: features of rays: where they go and end, how they are cut, and what
// they count.
#include "bricking/levels/visibility.h"
#include "render/backends/gpu/features.h"
#include "render/contract/ray_state.h"

namespace tessera::features {

// Leaps over proven empty space, by the distance map.
FeatureModule skipping() {
    return {.define = "FEATURE_SKIPPING", .meaning = "empty-space skipping"};
}

// Rays end below the scene's transmittance.
FeatureModule termination() {
    return {.define = "FEATURE_TERMINATION", .meaning = "early ray termination"};
}

// Rays are clipped to the space between planes: slices, and cuts that are convex. `March` sets it by its
// rays.
FeatureModule slabs() {
    return {.define = "FEATURE_SLABS",
            .meaning = "rays clipped to slabs",
            .excludes = kFeatureVisibility}; // visibility is counted of the whole volume
}

// Rays are cut into intervals, one drawn after another. `March` sets it by its rays.
FeatureModule intervals() {
    static_assert(kRayIntervalBytes == 2 * sizeof(float), "a vec2 in common_ray.glsl");
    return {.define = "FEATURE_INTERVALS",
            .meaning = "rays cut into intervals",
            .excludes = kFeatureVisibility, // visibility is counted of the whole volume
            .buffers = {{"INTERVALS", "the intervals of rays", [](const glm::ivec2& rays, const glm::ivec3&) {
                             return kRayIntervalBytes * rayCount(rays);
                         }}}};
}

// Rays through given places, not through the middle of every pixel. `March` sets it by its rays.
FeatureModule places() {
    static_assert(kRayPlaceBytes == 2 * sizeof(float), "a vec2 in common_ray.glsl");
    return {.define = "FEATURE_PLACES",
            .meaning = "rays through given places",
            .excludes = kFeatureVisibility, // it has a picture of its own
            .buffers = {{"PLACES", "the places of the rays", [](const glm::ivec2& rays, const glm::ivec3&) {
                             return kRayPlaceBytes * rayCount(rays);
                         }}}};
}

// The first hits of rays on isosurfaces.
FeatureModule hits() {
    static_assert(sizeof(SurfaceHit) == 2 * sizeof(glm::vec4), "two vec4 in march.comp");
    return {.define = "FEATURE_HITS",
            .meaning = "what rays hit first",
            .needs = kFeatureSurfaces,
            .buffers = {{"HITS", "what rays hit first", [](const glm::ivec2& image, const glm::ivec3&) {
                             return sizeof(SurfaceHit) * rayCount(image);
                         }}}};
}

// Some bricks are absent: rays wait for them and go on in another pass.
FeatureModule passes() {
    return {.define = "FEATURE_PASSES",
            .meaning = "several passes",
            .buffers = {{"WANTED", "the bricks that rays wait for",
                         [](const glm::ivec2&, const glm::ivec3& bricks) { return wantedBytes(bricks); },
                         UINT32_MAX}}};
}

// Rays go through several volumes.
FeatureModule fused() {
    return {.define = "FEATURE_FUSED",
            .meaning = "several volumes",
            .excludes = kFeatureVisibility | kFeatureValues | kFeatureSurfaces | kIntegratorFeatures};
}

// Volumes that are cut alone, beside others.
FeatureModule ownCuts() {
    return {.define = "FEATURE_OWN_CUTS",
            .meaning = "cuts of one of several volumes",
            .needs = kFeatureFused,
            .turns = kMostCutSlabs};
}

// Rays count the light that reaches each brick.
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

// Segments, samples and fetches are counted.
FeatureModule counting() {
    return {.define = "FEATURE_COUNTING", .meaning = "work counters"};
}

} // namespace tessera::features
