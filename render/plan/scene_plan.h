// render/plan/scene_plan.h: ScenePlan: everything that any engine needs of a scene and a store. It holds the
// state of the volume, the state of the view, and their share of both budgets.
#pragma once

#include "bricking/levels/visibility.h" // SeenBrick
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/contract/strides.h"
#include "render/plan/choose_levels.h"
#include "render/plan/frame_context.h"
#include "render/plan/memory_plan.h"
#include "render/plan/view_state.h"
#include "render/plan/volume_state.h"
#include "render/residency/pages.h"

#include <span>
#include <vector>

namespace tessera {

struct ScenePlan {
    ViewState view;
    MemoryPlan memory;
    ChosenLevels chosen; // how levels were chosen; the selection itself has moved to the volume
    VolumeState volume;  // last: its cache goes first

    const VolumeInfo& info() const { return volume.info(); }
    /// Takes another transfer function; shading, termination and integrator are the scene's, and mode, window
    /// and colours of single values.
    void setFunction(const TransferFunction& function, const Scene& scene);
    /// Takes the scene's lights and shading. False, and nothing is changed, where planes of light, memory or
    /// culled bricks would be others.
    bool setLight(const Scene& scene);
    /// The rays and the lights of the view as it is.
    void aim();
    /// What the scene takes besides its bricks, and what luxuries there is room for; chooses the scale of the
    /// distance map.
    /// @param changing  levels change from picture to picture: surfaces get no map of their own
    void planMemory(const TextureLimits& limits, const FrameContext& context, bool changing = false);
    /// Bricks have ghost layers where all of them, at level 0, have room for theirs; else limits has no room
    /// for any.
    void chooseGhostLayers(TextureLimits& limits, std::size_t bricks, const FrameContext& context);
    /// Makes the cache, of all RAM that is left or of so much as serves to read every chunk once.
    void openCache(bool readsOnce = false);
    /// Takes another selection, and maps its levels and its empty space.
    void setSelection(Selection chosen);
    /// Another length of segments, in voxels, or another integrator, for the levels there are.
    void setStep(double stepVoxels);
    void setIntegrator(Integrator integrator);
    /// What the budgets have room for where the integrator is left open, and the one that the function asks
    /// for. Before selections.
    /// @param mostEntries  of the table of any function that may come
    void settleIntegrator(const FrameContext& context, std::size_t mostEntries);
    /// Those worth trying on some pixels: one, where the function leaves no doubt or the scene names it.
    std::vector<Integrator> integratorsToTry() const;
    /// GPU memory of a function's tables, whichever integrator it may come to.
    std::size_t gpuTableBytes(std::size_t entries) const;
    /// The tables that segments of the lengths need which rays take through the selection.
    void prepareSegments();
    /// Maps the levels of the selection, where they are mixed or always, and its empty space.
    void mapLevels(bool always);
    /// Chooses levels again, by what a picture of the selection saw of each brick; needs chosen.chooser, and
    /// lets go of it.
    void chooseByVisibility(std::span<const SeenBrick> seen);
    /// Valid as long as this is not moved.
    Strides strides() const;

    MemoryBudget* ram = nullptr;               // everything that the plan keeps is charged to it
    int threads = 0;                           // that compute what it changes, and load bricks
    std::size_t ramFloorBytes = 0;             // of the scene
    Integrator mayTake = Integrator::midpoint; // the largest that is taken without being named

  private:
    void chargeTables(Integrator integrator);
    void setValues(const Scene& scene, Reduction reduction);
    Integrator automaticIntegrator() const;
    Integrator preintegration() const;
};

/// @param limits   of the device, without the scene's light, or the defaults where none is used
/// @param ram  the store's reader is charged to it, and little else
/// @param choice  perBrick, unless in tests and comparisons
/// @param bytesPerPixel  RAM that the engine and its caller take for a pixel
/// Throws InputError for a budget below the scene's floor, naming the floor, and for a transfer function that
/// does not suit the volume.
ScenePlan planScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                    const FrameContext& context, LevelChoice choice = LevelChoice::perBrick,
                    std::size_t bytesPerPixel = kPictureBytesPerPixel);

/// The same without levels, their maps and the cache: for a picture whose levels change, which has no
/// occlusion of surfaces.
ScenePlan planView(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                   std::size_t bytesPerPixel = kPictureBytesPerPixel);

/// The scene's camera; one by side fitted to what is shown, or to the slice, at its scale if it names one.
/// @param scene  as asDrawn() has it
/// @param part   what its cuts keep: drawnPart()
/// Throws InputError where ram cannot hold framingBytes() (framing.h).
Camera plannedCamera(const Scene& scene, const StoreReader& store, const Statistics& statistics,
                     const TransferTable& table, const DrawnPart& part, MemoryBudget& ram, int threads);

/// Takes the scene's quality and chooses levels anew, with their maps and a new cache. The engine must have
/// let go of the selection and of the cache.
void chooseAgain(ScenePlan& plan, const Scene& scene, const TextureLimits& limits,
                 const FrameContext& context, LevelChoice choice);

} // namespace tessera
