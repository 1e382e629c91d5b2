// render/plan/fusion.h: several volumes in one picture (docs/sampling.md, "Several volumes"): the lattice of
// their rays, and the further volumes, each with a plan of its own in its share of the memory.
#pragma once

#include "core/base/budget.h"
#include "core/base/volume.h"
#include "core/scene/scene.h"
#include "render/plan/frame_context.h"
#include "render/plan/planner.h"
#include "render/residency/pages.h"

#include <cstddef>
#include <glm/mat4x4.hpp>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

/// A volume besides a picture's first one.
struct FurtherVolume {
    MemoryBudget ram, gpu;     // its shares
    Charge heldRam, heldGpu;   // of the picture's budgets, for these
    Planner plan;              // of the volume alone; its rays are not drawn
    glm::dmat4 fromLattice{1}; // its voxels from places of the lattice
    OwnCuts cuts;              // of it alone

    /// Throws InputError if the budgets cannot hold the shares.
    FurtherVolume(const FrameContext& context, std::size_t ramBytes, std::size_t gpuBytes);
};

/// The voxels that rays count in: those of the volume with the smallest ones, of equally small ones the
/// first; whole voxels more, so that all volumes lie in its box.
/// Throws InputError where that box has more than 2^24 voxels along an axis.
VolumeInfo fusedLattice(std::span<const VolumeInfo* const> volumes);

/// Volume `number` of a scene alone, as its plan takes it.
/// Throws InputError for what scenes of several volumes do not have: isosurfaces, integrators of segments by
/// their ends, occlusion of surfaces, boxes of cuts in voxels.
Scene sceneInFusion(const Scene& scene, std::size_t number);

/// As planScene(), of all volumes of a scene; of one the same.
/// @param stores  of its volumes, in order
Planner planScene(const Scene& scene, Stores stores, const TextureLimits& limits, const FrameContext& context,
                  LevelChoice choice, const PixelMemory& pixels);

/// As planView(), of all volumes of a scene; of one the same. In modes of single values every volume has rays
/// of its own.
/// @param scene   as asDrawn() has it
/// @param bytesPerPixel  RAM that the engine and its caller take for a pixel of the plan's rays
/// Throws InputError as sceneInFusion() does, and for budgets that cannot hold all shares.
Planner planViews(const Scene& scene, Stores stores, const FrameContext& context, std::size_t bytesPerPixel,
                  PlanDetail detail = PlanDetail::whole);

/// The scene's camera, a fitted one to what is visible of all of a plan's volumes.
/// @param scene  as asDrawn() has it
/// Throws InputError where a volume's RAM cannot hold framingBytes() (framing.h).
Camera plannedCamera(const Scene& scene, const Planner& p);

/// The camera of a turntable, fitted to what is visible of all volumes (framing.h).
/// @param scene  with a camera by side
Camera turningCamera(const Scene& scene, Stores stores, MemoryBudget& ram, int threads);

/// The scene with a camera in place of a side, fitted to what is visible of all volumes, and their functions
/// in place of names.
Scene resolved(const Scene& scene, Stores stores, MemoryBudget& ram, int threads, std::size_t bytesPerPixel);

/// Segments of a stride of several volumes: as long as a sample of the finest level that any of them has.
int fusedSegments(const FramePlan& plan);

/// Of all volumes: the sum of what each one's levels may change.
PredictedError predictedOf(const FramePlan& plan);

} // namespace tessera
