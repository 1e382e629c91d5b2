// render/plan/prepare.h: from a scene and a store to everything an engine needs, whichever engine it is:
// values known, transfer function resolved, levels selected, empty space mapped, camera placed.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "bricking/levels/visibility.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/budget.h"
#include "core/preset.h" // ValueSummary
#include "core/scene.h"
#include "render/contract/level_map.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/empty_space/occupancy.h"
#include "render/plan/choose_levels.h"
#include "render/residency/pages.h"

#include <memory>
#include <optional>

namespace tessera {

struct PreparedScene {
    const StoreReader* store = nullptr; // outlives this
    Statistics statistics;
    TransferFunction function;
    TransferTable table;
    Optics optics;
    Camera camera;
    Selection selection;
    ChosenLevels chosen;                  // how: its own selection has moved to the member above
    LevelMap levels;                      // of a selection of mixed levels; else empty
    MapScale mapScale = MapScale::bricks; // of the map of empty space
    Occupancy occupancy;
    /// What isosurfaces alone show, where there are some, the function shows something too, and memory is
    /// ample.
    bool mapsNearSurfaces = false;
    Occupancy nearSurfaces;
    TransferTable surfaceTable; // then
    RayFrame<double> frame;
    glm::ivec2 imageSize{0};
    std::size_t ramFloorBytes = 0; // of the scene
    Charge imageCharge;            // pictures and what an engine keeps of every ray, in RAM
    Charge selectionCharge;
    Charge functionCharge;             // the transfer function's table, twice
    std::unique_ptr<BrickCache> cache; // last member: it goes first, its threads read the store

    const VolumeInfo& info() const { return store->info(); }
    bool mixed() const { return !levels.corners.empty(); }
    /// Takes another transfer function; shading, termination and integrator are the scene's.
    void setFunction(const TransferFunction& function, const Scene& scene, Ledger& ram);
    /// GPU memory that a picture takes besides its bricks; chooses the scale of the map of empty space.
    std::size_t reserveGpu(const TextureLimits& limits, const Ledger& ram, const Ledger& gpu);
    /// RAM that the maps, the smallest cache and uploading take.
    std::size_t ramToKeep(int threads) const;
    /// Makes the cache, of all RAM that is left.
    void openCache(Ledger& ram, int threads);
    /// Takes another selection, and maps its levels and its empty space.
    void setSelection(Selection chosen, Ledger& ram);
    /// Another length of segments, in voxels, or another integrator, for the levels there are.
    void setStep(double stepVoxels);
    void setIntegrator(Integrator integrator, Ledger& ram);
    /// What the budgets have room for where the integrator is left open, and the one that the function asks
    /// for. Before selections.
    /// @param mostEntries  of the table of any function that may come
    void settleIntegrator(Ledger& ram, const Ledger& gpu, std::size_t mostEntries);
    /// Those worth trying on some pixels: one, where the function leaves no doubt or the scene names it.
    std::vector<Integrator> integratorsToTry() const;
    /// GPU memory of a function's tables, whichever integrator it may come to.
    std::size_t gpuTableBytes(std::size_t entries) const;
    /// The tables that segments of the lengths need which rays take through the selection.
    void prepareSegments();
    /// Maps the levels of the selection, where they are mixed or always, and its empty space.
    void mapLevels(Ledger& ram, bool always);
    /// Chooses levels again, by what a picture of the selection saw of each brick; needs chosen.chooser, and
    /// lets go of it.
    void chooseBySight(std::span<const SeenBrick> seen, Ledger& ram);
    /// Proves anew what the selection's levels change; all of it the first time.
    void mapEmptySpace(Ledger& ram);
    /// Valid as long as this is not moved.
    Strides strides() const;

    Quality quality;
    Integrator mayTake = Integrator::midpoint; // the largest that is taken without being named

  private:
    void chargeTables(Integrator integrator, Ledger& ram);
    Integrator automaticIntegrator() const;
    Integrator preintegration() const;
};

/// RAM a pixel takes while it is drawn and written: two float pictures (as computed, and converted or on its
/// background) and the encoded one.
constexpr std::size_t kPictureBytesPerPixel = 2 * sizeof(glm::vec4) + 4 * sizeof(std::uint16_t);

/// The scene's floor of RAM, its store reader included: no smaller budget is accepted, and this one suffices.
/// @param threads  0: all processors
std::size_t renderFloorBytes(const VolumeInfo& info, const glm::ivec2& imageSize, std::size_t bytesPerPixel,
                             int threads, Integrator integrator = Integrator::automatic);

/// @param limits   of the device, or the defaults where none is used
/// @param ram  the store's reader is charged to it, and little else
/// @param choice  perBrick, unless in tests and comparisons
/// @param bytesPerPixel  RAM that the engine and its caller take for a pixel
/// Throws InputError for a budget below the scene's floor, naming the floor, and for a transfer function that
/// does not suit the volume.
PreparedScene prepareScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                           Ledger& ram, const Ledger& gpu, int threads,
                           LevelChoice choice = LevelChoice::perBrick,
                           std::size_t bytesPerPixel = kPictureBytesPerPixel);

/// The same without levels, their maps and the cache: for a picture whose levels change.
PreparedScene prepareView(const Scene& scene, const StoreReader& store, Ledger& ram, int threads,
                          std::size_t bytesPerPixel = kPictureBytesPerPixel);

/// Takes the scene's quality and chooses levels anew, with their maps and a new cache. The engine must have
/// let go of the selection and of the cache.
void chooseAgain(PreparedScene& prepared, const Scene& scene, const TextureLimits& limits, Ledger& ram,
                 const Ledger& gpu, int threads, LevelChoice choice);

/// What presets may know of a volume.
ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info, const std::string& unit = "");

} // namespace tessera
