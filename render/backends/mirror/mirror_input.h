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
#include "render/labels/label_field.h"
#include "render/plan/frame_plan.h"

#include <vector>

namespace tessera {

class StoredLight;

/// All inputs of the mirror besides its rays. The pointed-to objects outlive it.
struct MirrorInput {
    BrickCache* cache = nullptr;
    const VolumeInfo* info = nullptr;
    const Selection* selection = nullptr;
    const LevelMap* levels = nullptr; // null: the selection has one level
    const Optics* optics = nullptr;
    const Occupancy* occupancy = nullptr; // null: no skipping
    const Occupancy* surfaceOccupancy =
        nullptr;                         // occupancy of the surfaces alone; null: the same as occupancy
    const ValueBounds* bounds = nullptr; // of rays that keep one value; null: no leaps
    const StoredLight* light = nullptr;  // light per voxel, if the scene has any
    LabelBricks* labels = nullptr;       // labels' factors, likewise
    Strides strides;
    const CutRays* cuts = nullptr; // of all rays of the array; null: no cuts
    std::size_t firstRay = 0;      // number in the array of the first ray drawn
    double segmentVoxels = 1;      // with cuts
    int hullSamples = 0;           // likewise: RayHulls::samples where there are hulls
    ShareDone progress = {};       // of a picture's rays
    /// Content of isosurfaces: distance along the ray, mm, in place of red.
    bool showsDistances = false;
    const FusedLattice* fused = nullptr;         // of rays through several volumes, this and the further ones
    std::vector<MirrorInput> further = {};       // then
    glm::dmat4 fromLattice{1};                   // then: the volume's voxels from places of the lattice
    double unitMm = 1;                           // then: of the volume's function
    std::span<const leaf::CutSlab> ownCuts = {}; // then: of the volume alone
};

/// The mirror's inputs from a prepared scene; valid until the scene moves.
MirrorInput mirrorInput(const FramePlan& scene, bool skipping);

} // namespace tessera
