// render/prepare.h: from a scene and a store to everything an engine needs, whichever engine it is: values known,
// transfer function resolved, levels selected, empty space mapped, camera placed.
#pragma once

#include "bricking/brick_cache.h"
#include "bricking/selection.h"
#include "bricking/statistics.h"
#include "bricking/store/store_reader.h"
#include "core/budget.h"
#include "core/preset.h" // ValueSummary
#include "core/scene.h"
#include "render/atlas.h"
#include "render/occupancy.h"
#include "render/optics.h"
#include "render/ray.h"

#include <memory>

namespace tessera {

struct PreparedScene {
    const StoreReader* store = nullptr; // outlives this
    Statistics statistics;
    TransferFunction function;
    TransferTable table;
    Optics optics;
    Camera camera;
    Selection selection;
    Occupancy occupancy;
    RayFrame<double> frame;
    glm::ivec2 imageSize{0};
    Charge imageCharge;                // the picture in RAM, twice: as computed and on its background
    std::unique_ptr<BrickCache> cache; // last member: it goes first, its threads read the store

    const VolumeInfo& info() const { return store->info(); }
};

/// @param limits   of the device, or the defaults where none is used
/// @param culling  false: bricks that show nothing are kept too (equality tests)
/// Throws InputError for a budget below the scene's floor, naming the floor, and for a transfer function that
/// does not suit the volume.
PreparedScene prepareScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                           Ledger& ram, const Ledger& gpu, int threads, bool culling);

/// What presets may know of a volume.
ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info);

} // namespace tessera
