// render/plan/planner.h: Planner: makes the plan of a frame from a scene, its volumes, budgets, and what has
// been learnt since. It chooses levels from visibility, and step and integrator from pixels that were tried.
// A call that needs another one first says so.
#pragma once

#include "bricking/levels/visibility.h" // SeenBrick
#include "core/base/budget.h"
#include "core/scene/scene.h"
#include "render/plan/frame_context.h"
#include "render/plan/frame_plan.h"
#include "render/plan/layer_labels.h"
#include "render/residency/pages.h"

#include <span>
#include <utility>
#include <vector>

namespace tessera {

class Planner : public FramePlan {
  public:
    using FramePlan::layer;
    /// For who keeps levels, cache or charges of a layer up to date; tables and maps are set by calls below.
    Layer& layer() { return layers.front(); }

    /// Takes the scene's quality and chooses levels anew, with their maps and a new cache. The engine must
    /// have let go of the selection and of the cache.
    void chooseAgain(const Scene& scene, const TextureLimits& limits, const FrameContext& context,
                     LevelChoice choice);
    /// Chooses levels again, by each brick's visibility in a picture of the selection; needs chosen.chooser,
    /// and lets go of it.
    void chooseByVisibility(std::span<const SeenBrick> seen);
    /// Takes another selection, and maps its levels and its empty space.
    void setSelection(Selection chosen);
    /// Maps the levels of the selection, where they are mixed or always, and its empty space.
    void mapLevels(bool always);
    /// Makes the cache, of all RAM that is left or of so much as serves to read every chunk once.
    void openCache(bool readsOnce = false);

    /// Takes another transfer function; shading, termination and integrator are the scene's, and mode, window
    /// and colours of single values.
    void setFunction(const TransferFunction& function, const Scene& scene);
    /// Where rays show sums: takes the window that they show through.
    void setExposure(const std::optional<GreyWindow>& window);
    /// Makes the distance map of the current function.
    void mapFunction();
    /// Takes the scene's lights and shading. False, and nothing is changed, where planes of light, memory or
    /// culled bricks would be others: takesLight().
    bool setLight(const Scene& scene);
    bool takesLight(const Scene& scene) const;
    /// The rays and the lights of the view as it is.
    void aim();
    /// Those rays on a picture of another size.
    RayFrame<double> frameOf(const glm::ivec2& size) const;
    void look(const Camera& camera) {
        setCamera(camera);
        aim();
    }
    /// aim() takes what these set.
    void setCamera(const Camera& camera) { view.camera = camera; }
    void setPart(DrawnPart part) { view.part = std::move(part); }
    /// The picture is drawn part by part, of the largest of which so many pixels: RAM of more goes back.
    void drawInParts(const PixelMemory& pixels);
    /// Of the rays that aim() makes.
    void setImageSize(const glm::ivec2& size) { view.imageSize = size; }
    /// Another length of segments, in voxels, or another integrator, for the levels there are.
    void setStep(double stepVoxels);
    /// Samples of a ray in each hull; 0: rays take segments of one length from here on.
    void setHullSamples(int samples);
    void setIntegrator(Integrator integrator);
    /// Sets the end of rays: the light that is left, of 1.
    void setTermination(float transmittance);
    /// Sets the fetch mode of samples. Backends that filter nothing ignore it.
    void setFetch(Fetch fetch) { view.quality.fetch = fetch; }
    /// Of shadow maps, which are made when an engine opens the plan.
    void setShadowLayers(int layers);

    /// Plans the memory of the scene besides its bricks, and the optional memory that there is room for;
    /// chooses the scale of the distance map.
    /// @param changing  levels change from picture to picture: surfaces get no map of their own
    void planMemory(const TextureLimits& limits, const FrameContext& context, bool changing = false);
    /// Bricks have ghost layers where all of them, at level 0, have room for theirs; else limits has no room
    /// for any.
    void chooseGhostLayers(TextureLimits& limits, std::size_t bricks, const FrameContext& context);
    /// Settles the integrators that the budgets have room for if the integrator is left open, and the one
    /// that the function asks for. Before selections.
    /// @param mostEntries  of the table of any function that may come
    void settleIntegrator(const FrameContext& context, std::size_t mostEntries);

    MemoryBudget* ram = nullptr; // everything that the plan keeps is charged to it
    int threads = 0;             // that compute what it changes, and load bricks
    /// From here on rays may follow paths that have the mean of the scene's light: what kept light errs by is
    /// told with them. Returns why there are none; empty: there are.
    std::string boundLight(const Scene& scene);
    void unboundLight();

    std::size_t ramFloorBytes = 0; // of the scene
    bool isCoarse = false;         // by PlanDetail::coarse: its statistics are bounds

  private:
    OccupancyInput occupancyInput() const;
    void boundExtinction();
    void chargeTables(Integrator integrator);
    void exposeSums(const Scene& scene);
    void setValues(const Scene& scene, Reduction reduction);
    /// The tables that segments of the lengths need which rays take through the selection.
    void prepareSegments();
};

/// What plans read of a volume. coarse: statistics of few bytes (coarse_statistics.h), and a camera fitted to
/// a coarse level, for a first picture of LevelChoice::quick; nothing is looked for that the store does not
/// keep. Where there is nothing to gain by it, or the scene needs more than bounds, it is whole.
enum class PlanDetail { whole, coarse };

/// The plan of a picture, of PlanDetail::coarse with LevelChoice::quick.
/// @param limits   of the device, without the scene's light, or the defaults where none is used
/// @param context  its RAM is charged for all that the plan keeps
/// @param choice  perBrick, unless in tests and comparisons
/// @param pixels  their RAM
/// @param known  what was read before, or null; moved from
/// Throws InputError for a budget below the scene's minimum, naming that. Throws it too for a transfer
/// function that does not suit the volume.
Planner planScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                  const FrameContext& context, LevelChoice choice = LevelChoice::perBrick,
                  const PixelMemory& pixels = {}, KnownLayer* known = nullptr);

/// The first part of that: the plan of a volume without a camera and levels.
Planner planVolume(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                   const PixelMemory& pixels, KnownLayer* known = nullptr,
                   PlanDetail detail = PlanDetail::whole);

/// The same for pictures whose function and lights change: light that this function has no use for stays.
Planner planChanging(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                     const PixelMemory& pixels, KnownLayer* known = nullptr,
                     PlanDetail detail = PlanDetail::whole);

/// planScene() without levels, their maps and the cache: for a picture whose levels change, which has no
/// occlusion of surfaces.
Planner planView(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                 const PixelMemory& pixels = {}, PlanDetail detail = PlanDetail::whole);

/// The scene's camera; one by side fitted to the visible part, or to the slice, at its scale if it names one.
/// @param scene  as asDrawn() has it
/// @param part   the part that its cuts keep: drawnPart() Throws InputError where ram cannot hold
///     framingBytes() (framing.h).
Camera plannedCamera(const Scene& scene, const ChunkSource& volume, const Statistics& statistics,
                     const TransferTable& table, const DrawnPart& part, MemoryBudget& ram, int threads,
                     LabelBricks* labels = nullptr);

} // namespace tessera
