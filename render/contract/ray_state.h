// render/contract/ray_state.h: the state of a ray between two calls that draw it, and the outputs of rays
// besides their colours (docs/sampling.md, "Ray"). Engines allocate by these sizes, and plans count with
// them.
#pragma once

#include "core/base/brick.h"
#include "core/base/progress.h" // ShareDone

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace tessera {

// The division of rays into dispatches, which a device takes one at a time.

/// The cutting of rays into dispatches. It never changes the picture; tests vary it to prove that.
struct Slicing {
    /// Adaptive: the target time of a dispatch. Its true time is not bounded: it gets the iterations that fit
    /// at the cost of those before, and takes longer where its own cost more.
    double targetMs = 80;
    int fixedTile = 0;       // pixels; 0: adaptive
    int fixedIterations = 0; // per ray and dispatch; 0: adaptive
    ShareDone progress = {}; // of the picture, after every dispatch
};

/// The first place where a ray meets an isosurface that is not wholly transparent.
struct SurfaceHit {
    glm::vec3 position{0}; // voxels
    float weight = 0;      // light that what lies before it leaves, [0,1]
    glm::vec3 normal{0};   // unit, patient space, towards the viewer; 0 where the field has no gradient
    int surface = 0;       // 1 + its number among Optics::surfaces; 0: none was met
    bool operator==(const SurfaceHit&) const = default;
};

inline std::size_t rayCount(const glm::ivec2& imageSize) {
    return static_cast<std::size_t>(imageSize.x) * static_cast<std::size_t>(imageSize.y);
}

/// Bytes of every ray: premultiplied colour and alpha; the next segment, or -1 at its end.
constexpr std::size_t kRayColourBytes = sizeof(glm::vec4), kRayNextBytes = sizeof(std::int32_t);
/// Of every ray whose place on the picture is given.
constexpr std::size_t kRayPlaceBytes = sizeof(glm::vec2);
/// Of every ray that is cut: the interval at hand.
constexpr std::size_t kRayIntervalBytes = sizeof(glm::vec2);
/// Of every ray that counts visibility: the brick that it counted last.
constexpr std::size_t kRayLastBrickBytes = sizeof(std::int32_t);
/// Of every brick: the first ray that waits for it.
constexpr std::size_t kWantedBytes = sizeof(std::uint32_t);

/// Of arrays of places, even of the smallest picture.
constexpr std::size_t kLeastPlacedRays = 16;

/// Counters that a call which draws returns.
constexpr std::size_t kDrawnCounterBytes = 7 * sizeof(std::uint32_t);

/// The memory of a picture's rays.
inline std::size_t rayStateBytes(const glm::ivec2& imageSize) {
    return (kRayColourBytes + kRayNextBytes) * rayCount(imageSize) + kDrawnCounterBytes;
}
/// The memory of arrays of rays through given places: as many rays as the picture has pixels, a few at least.
inline std::size_t placedRaysBytes(const glm::ivec2& imageSize) {
    return (kRayColourBytes + kRayNextBytes + kRayPlaceBytes) *
               std::max<std::size_t>(rayCount(imageSize), kLeastPlacedRays) +
           kDrawnCounterBytes;
}
/// The further memory of rays that report their first hits.
inline std::size_t hitsBytes(const glm::ivec2& imageSize) {
    return sizeof(SurfaceHit) * std::max<std::size_t>(rayCount(imageSize), kLeastPlacedRays);
}
/// Of every brick: its visibility to rays that count (SeenBrick).
constexpr std::size_t kSeenBytes = 2 * sizeof(std::uint32_t);
inline std::size_t seenBytes(const glm::ivec3& bricks) {
    return kSeenBytes * cellCount(bricks);
}
/// The further memory of rays that wait for bricks.
inline std::size_t wantedBytes(const glm::ivec3& bricks) {
    return kWantedBytes * cellCount(bricks);
}

} // namespace tessera
