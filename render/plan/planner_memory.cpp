// render/plan/planner_memory.cpp: what a plan needs of both budgets, and the cache that takes the rest: see
// planner.h.
#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/ray_state.h"
#include "render/plan/fusion.h"
#include "render/plan/planner.h"
#include "render/plan/planner_light.h"
#include "render/plan/visibility_rays.h"

#include <algorithm>

namespace tessera {
namespace {

/// Chunks in progress: as many as keep the loaders busy.
constexpr std::size_t kReadOnceBytes = std::size_t{32} << 20;
constexpr char kCellMap[] = "the occupancy map, by cells";
constexpr char kBrickMap[] = "the occupancy map, by bricks";
constexpr char kSurfaceMap[] = "the occupancy map of isosurfaces";

} // namespace

void Planner::planMemory(const TextureLimits& limits, const FrameContext& context, bool changing) {
    const MemoryBudget &free = context.ram, &gpu = context.gpu;
    const VolumeInfo& volumeInfo = info();
    const glm::ivec3 extent = volumeInfo.extentVoxels, bricks = brickGrid(extent);
    // Visibility is counted before the picture, in its memory; with an error bound, or
    // where others have the rest of the volume, rays wait for bricks.
    const int channels = channelsBeside();
    layer().lightCharge = {};
    const int layers = view.shadowQuality.layers; // the requested one
    view.shadowQuality = shadowQualityFor(view.lighting, free.freeBytes());
    view.shadowQuality.layers = layers;
    const glm::ivec2 together = view.drawnSize();
    const std::size_t picture = placedRaysBytes(together); // pixels are drawn again
    const bool waits = view.quality.maxError || context.group;
    const std::size_t rays =
        waits ? picture + wantedBytes(bricks) : std::max(picture, visibilityBytes(view.imageSize, bricks));
    MemoryPlan floors;
    floors.need("rays", 0, rays);
    for (const auto& volume : this->further) // one list of all
        floors.need("further volumes' bricks that rays wait for", 0,
                    wantedBytes(brickGrid(volume->plan.info().extentVoxels)));
    if (view.lighting.surfaceOcclusion || view.reflects)
        floors.need("first hits of rays", 0, hitsBytes(together));
    if (view.part.cuts) // half an interval more than hulls make, and their starts
        floors.need(
            "intervals of rays", 0,
            (kRayIntervalBytes * static_cast<std::size_t>(2 * std::max(view.hulls().count, 1) + 1) / 2 +
             sizeof(std::size_t)) *
                rayCount(together));
    floors.need("the index of bricks", 0,
                indexBytes(bricks, limits.indexEntryBytes) * static_cast<std::size_t>(1 + channels));
    floors.need("light per voxel while it is computed", lightBytes(*this, view.lighting), 0);
    floors.need("the level map", 0, LevelMap::bytes(bricks));
    floors.need("the transfer function's tables", 0, gpuTableBytes(layer().optics.table.size()));
    floors.need("levels mapped, the smallest cache and the staging of uploads",
                ramAfterCamera(volumeInfo, threads, MapScale::bricks, false), 0);
    // Optional memory is a share of the remainder that bricks leave.
    const std::size_t promised =
        floors.gpuBytes() + atlasBytes(neighbourhoodPages(true, true), volumeInfo.type, limits);
    memory = std::move(floors);
    memory.setSpare(free.limitBytes() - ramFloorBytes, gpu.freeBytes() - std::min(gpu.freeBytes(), promised));
    if (view.lighting.transport)
        memory.need("bounds of extinction", ExtinctionBounds::bytes(extent, layer().table.entries.size()), 0);
    if (!view.quality.skipping)
        return;
    memory.need(kBrickMap, Occupancy::bytes(extent, MapScale::bricks), mapBytes(extent, MapScale::bricks));
    // Cells if their map is a small part of both budgets.
    const std::size_t cellMap = Occupancy::bytes(extent, MapScale::cells);
    const std::size_t cellTexels = mapBytes(extent, MapScale::cells);
    const bool cells = memory.grant(kCellMap, cellMap, cellTexels, 16, 4, kBrickMap);
    layer().mapScale = cells ? MapScale::cells : MapScale::bricks;
    // Without a separate map, rays search surfaces in all occupied space.
    layer().mapsSurfaces = cells && !changing && !layer().optics.surfaces.empty() &&
                           layer().optics.volumeShows &&
                           memory.grant(kSurfaceMap, cellMap, cellTexels, 31, 8);
    if (layer().mapsSurfaces)
        layer().surfaceTable = layer().table.ofSurfaces();
}

void Planner::openCache(bool readsOnce) {
    if (const std::size_t light = lightBytes(*this, view.lighting))
        layer().lightCharge = ram->charge(light, "light per voxel while it is computed");
    // Of parts of cells, which the cache gives the samples for.
    Charge reserve;
    if (view.lighting.transport && ExtinctionBounds::hasParts(info().extentVoxels))
        reserve = ram->charge(ExtinctionBounds::bytesOfParts(cellCount(cellGrid(info().extentVoxels))),
                              "the bounds of extinction in parts of cells");
    // It takes the rest, less staging for uploads and, if memory is ample, a reserve.
    const int used = threads > 0 ? threads : defaultThreads();
    const std::size_t free = ram->freeBytes(), staging = stagingBytes(info());
    const std::size_t left = free > staging ? free - staging : 0;
    const std::size_t floor = std::min(left, latticeCacheFloorBytes(info(), used));
    // First use of memory costs more than its content.
    const std::size_t most = readsOnce ? kReadOnceBytes : left - left / 8;
    const std::size_t bytes = std::max(floor, std::min(most, left - left / 8));
    layer().cache = std::make_unique<BrickCache>(layer().voxels(), *ram, bytes, used);
    reserve = {};
    if (view.lighting.transport)
        layer().extinction.refine(occupancyInput(), layer().optics, *layer().cache, *ram, threads);
}

void Planner::chooseGhostLayers(TextureLimits& limits, std::size_t bricks, const FrameContext& context) {
    const std::size_t fixed = memory.gpuBytes(), free = context.gpu.freeBytes();
    if (pagesThatFit(free - std::min(free, fixed), info().type, limits) < bricks)
        limits.pageEdge = kBrickExtent;
    layer().pageEdge = limits.pageEdge;
}

} // namespace tessera
