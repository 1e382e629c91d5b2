// render/mirror_input.h: what the mirror reads, and what it tells of isosurfaces besides a picture.
#pragma once

#include "bricking/brick_cache.h"
#include "core/progress.h" // ShareDone
#include "render/level_map.h"
#include "render/occupancy.h"
#include "render/optics.h"
#include "render/strides.h"

#include <glm/vec3.hpp>

namespace tessera {

/// All that a mirror needs besides its rays. The pointed-to objects outlive it.
struct MirrorInput {
    BrickCache* cache = nullptr;
    const VolumeInfo* info = nullptr;
    const Selection* selection = nullptr;
    const LevelMap* levels = nullptr; // null: the selection has one level
    const Optics* optics = nullptr;
    const Occupancy* occupancy = nullptr;    // null: no skipping
    const Occupancy* nearSurfaces = nullptr; // what the surfaces alone show; null: the same as occupancy
    Strides strides;
    ShareDone progress = {}; // of a picture's rays
};

/// Where a ray first meets an isosurface that is not wholly transparent.
struct SurfaceHit {
    glm::vec3 position{0}; // voxels
    float depthMm = 0;     // along the ray from its entry into the volume, or from the eye inside
    glm::vec3 normal{0};   // unit, patient space, towards the viewer; 0 where the field has no gradient
    int surface = 0;       // 1 + its number among Optics::surfaces; 0: none was met
    bool operator==(const SurfaceHit&) const = default;
};

} // namespace tessera
