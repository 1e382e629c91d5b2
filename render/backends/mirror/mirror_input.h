// render/backends/mirror/mirror_input.h: the inputs of the mirror.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "core/base/progress.h" // ShareDone
#include "render/contract/level_map.h"
#include "render/contract/optics.h"
#include "render/contract/ray_cuts.h"
#include "render/contract/strides.h"
#include "render/empty_space/occupancy.h"
#include "render/empty_space/value_bounds.h"
#include "render/plan/frame_plan.h"

namespace tessera {

class StoredLight;

/// All that a mirror needs besides its rays. The pointed-to objects outlive it.
struct MirrorInput {
    BrickCache* cache = nullptr;
    const VolumeInfo* info = nullptr;
    const Selection* selection = nullptr;
    const LevelMap* levels = nullptr; // null: the selection has one level
    const Optics* optics = nullptr;
    const Occupancy* occupancy = nullptr;        // null: no skipping
    const Occupancy* surfaceOccupancy = nullptr; // what the surfaces alone show; null: the same as occupancy
    const ValueBounds* bounds = nullptr;         // of rays that keep one value; null: nothing is leapt over
    const StoredLight* light = nullptr;          // of voxels, where the scene has any
    Strides strides;
    const CutRays* cuts = nullptr; // of all rays of the array; null: rays are whole
    std::size_t firstRay = 0;      // number among them of the first that is drawn
    double segmentVoxels = 1;      // with cuts
    ShareDone progress = {};       // of a picture's rays
    /// What isosurfaces show: how far along its ray each is met, mm, in place of its red.
    bool showsDistances = false;
};

/// What a prepared scene gives the mirror; valid as long as the scene is not moved.
MirrorInput mirrorInput(const FramePlan& scene, bool skipping);

} // namespace tessera
