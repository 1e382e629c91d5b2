// render/plan/layer.h: everything that pictures need of one volume, whichever engine draws it:
// statistics, resolved transfer function, a level for every brick, occupancy, and the chunk cache.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/transfer_function.h"
#include "core/scene/value_look.h"
#include "render/contract/level_map.h"
#include "render/contract/optics.h"
#include "render/empty_space/occupancy.h"
#include "render/empty_space/value_bounds.h"

#include <memory>
#include <string>

namespace tessera {

struct Layer {
    const StoreReader* store = nullptr; // outlives this
    Statistics statistics;
    TransferFunction function;
    TransferTable table;
    Optics optics;
    Selection selection;
    int pageEdge = kBrickExtent; // samples along a page of bricks, ghost layers included
    LevelMap levels;             // of a selection of mixed levels; else empty
    MapScale mapScale = MapScale::bricks;
    Occupancy occupancy; // and the distance map; none where rays keep one value
    ValueLook look;      // of single values, where they do
    ValueBounds bounds;  // then: what rays leap over, where they look for the greatest or the least
    /// What isosurfaces alone show: a map of its own, where there are surfaces, the function shows something
    /// too, and memory is ample.
    bool mapsSurfaces = false;
    Occupancy surfaceOccupancy;
    TransferTable surfaceTable; // then
    Charge selectionCharge;
    Charge functionCharge;             // the transfer function's table, twice
    Charge lightCharge;                // what computing the light of voxels takes
    std::unique_ptr<BrickCache> cache; // last member: it goes first, its threads read the store

    const VolumeInfo& info() const { return store->info(); }
    bool mixed() const { return !levels.corners.empty(); }
    /// Rays keep one value, not what the function makes of all.
    bool reduces() const { return optics.reduction != Reduction::composite; }
    /// Proves anew what the selection's levels change; all of it the first time.
    void mapEmptySpace(const Quality& quality, MemoryBudget& ram);
    /// The table is another: proves anew what that changes.
    void functionChanged(const Quality& quality, MemoryBudget& ram, int threads);
};

/// What presets may know of a volume.
ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info, const std::string& unit = "");

/// The edge of a cube of a voxel's volume.
double typicalVoxelMm(const VolumeInfo& info);

} // namespace tessera
