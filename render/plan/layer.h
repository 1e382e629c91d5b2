// render/plan/layer.h: the data of one volume for pictures by any engine: statistics, resolved transfer
// function, a level for every brick, occupancy, and the chunk cache.
#pragma once

#include "bricking/cache/brick_cache.h"
#include "bricking/levels/selection.h"
#include "bricking/statistics/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/base/budget.h"
#include "core/scene/mode.h"
#include "core/scene/preset.h" // ValueSummary
#include "core/scene/transfer_function.h"
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
    Occupancy occupancy; // and the distance map; none if rays keep one value
    ValueLook look;      // of single values, if they do
    ValueBounds bounds;  // then: bounds for leaps of rays that keep the maximum or minimum
    /// Occupancy of isosurfaces alone: a separate map, if there are surfaces, the function is visible too,
    /// and memory suffices.
    bool mapsSurfaces = false;
    Occupancy surfaceOccupancy;
    TransferTable surfaceTable; // then
    Charge selectionCharge;
    Charge functionCharge;             // the transfer function's table, twice
    Charge lightCharge;                // memory for computing light per voxel
    std::unique_ptr<BrickCache> cache; // last member: destroyed first, because its threads read the store

    const VolumeInfo& info() const { return store->info(); }
    bool mixed() const { return !levels.corners.empty(); }
    /// True if rays keep one value instead of compositing.
    bool reduces() const { return optics.reduction != Reduction::composite; }
    /// Updates occupancy for the selection's levels; computes all of it the first time.
    void mapEmptySpace(const Quality& quality, MemoryBudget& ram);
    /// Updates occupancy for a new table.
    void functionChanged(const Quality& quality, MemoryBudget& ram, int threads);
};

/// Statistics of a volume for presets.
ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info, const std::string& unit = "");

/// The edge of a cube with a voxel's volume.
double typicalVoxelMm(const VolumeInfo& info);

} // namespace tessera
