// render/plan/planner.cpp: see planner.h.
#include "render/plan/planner.h"

#include "bricking/analysis/body/kept_table.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/threads.h"
#include "render/contract/lattice.h"
#include "render/contract/ray_state.h"
#include "render/light/light_memory.h"
#include "render/plan/choose_integrator.h"
#include "render/plan/framing.h"
#include "render/plan/fusion.h"
#include "render/plan/label_optics.h"
#include "render/plan/layer_histograms.h"
#include "render/plan/layer_labels.h"
#include "render/plan/scene_rules.h"
#include "render/plan/visibility_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

namespace tessera {

namespace {

/// Why a kept light has no counterpart by single ways; empty: it has.
std::string whyNotByWays(const FramePlan& plan) {
    if (plan.fused)
        return "it is that of several volumes";
    if (!plan.layer().optics.surfaces.empty() || !plan.view.meshes.empty())
        return "isosurfaces or meshes are in its way";
    if (const auto& occlusion = plan.view.lighting.occlusion;
        occlusion && (occlusion->method != OcclusionMethod::local || occlusion->emission > 0 ||
                      occlusion->directions != OcclusionDirections::sphere))
        return "occlusion is not of method local and directions sphere, or emits";
    if (scatters(plan.view.lighting))
        return "tissue scatters it";
    return {};
}

/// Removes unneeded light: coloured ambient light without emissive tissue; light per voxel that occlusion of
/// surfaces replaces.
Scene withoutUnusedLight(Scene scene) {
    if (scene.lighting.transport) { // rays find places alone; light gets there along paths
        scene.shading.on = false;
        scene.lighting.occlusion.reset();
        scene.lighting.surfaceOcclusion.reset();
        for (Light& light : scene.lighting.lights) {
            light.shadow = false;
            light.scatter = 0;
        }
    }
    if (scene.lighting.surfaceOcclusion)
        scene.lighting.occlusion.reset();
    const auto* function = std::get_if<TransferFunction>(&scene.volumes.at(0).transferFunction);
    if (scene.lighting.occlusion && !(function && function->emits())) // presets emit none
        scene.lighting.occlusion->emission = 0;
    return scene;
}

/// An integrator that was not requested uses tables only if they are a small part of the free memory.
constexpr std::size_t kPartsForTables = 16;
/// Chunks in progress: as many as keep the loaders busy.
constexpr std::size_t kReadOnceBytes = std::size_t{32} << 20;

/// RAM that light of voxels takes.
std::size_t lightBytes(const Planner& p, const Lighting& lighting) {
    return lightRamBytes(lighting, p.info(), p.view.shadowQuality, p.threads, !p.view.meshes.empty(),
                         p.view.amongOthers);
}

} // namespace

void Planner::setFunction(const TransferFunction& f, const Scene& scene) {
    const Reduction reduction = reductionOf(scene);
    const bool sums = reduction == Reduction::sum;
    layer().function = f;
    layer().addsUp = sums;
    layer().body = {};
    layer().function.setShare(sums ? 1 : scene.volumes.at(0).opacity);
    revisions.function = revisions.tables = PlanRevisions::next();
    if (reduction != Reduction::composite && !sums) {
        setValues(scene, reduction);
        return;
    }
    if (sums)
        exposeSums(scene);
    if (scene.mode == Mode::isosurface) { // the material response stays the function's
        layer().function = TransferFunction::fromOpacity({}, f.colourPoints(), f.referenceLengthMm());
        layer().function.setMaterials(f.materials());
    }
    std::vector<SurfaceValue> surfaces;
    for (const Isosurface& surface : scene.surfaces)
        if (surface.drawnOpacity() > 0)
            surfaces.push_back({surface.value, glm::vec3(surface.drawnColour()), surface.drawnOpacity()});
    layer().table = makeTable(layer().function, std::move(surfaces));
    const Integrator integrator =
        scene.quality.integrator == Integrator::automatic ? automaticIntegrator() : scene.quality.integrator;
    chargeTables(integrator);
    Preintegration2d seen = std::move(layer().optics.seen); // may be kept
    layer().optics =
        makeOptics(layer().table, info(), scene.shading, scene.quality.terminationTransmittance, integrator);
    layer().optics.seen = std::move(seen);
    layer().optics.surfaces = surfaceLooks(scene.surfaces, info());
    if (reflects(scene) && !scene.lighting.surfaceOcclusion)
        for (SurfaceLook& look : layer().optics.surfaces)
            look.reports = look.reflection.has_value();
    if (sums) {
        for (glm::vec4& entry : layer().optics.table)
            entry.a *= Exposure::kThin;
        layer().function.setShare(Exposure::kThin); // the reference reads its points
    }
    if (layer().labels)
        layer().optics.labels = layer().labels->numbers();
    setLighting(layer().optics, scene.shading, view.lighting, f.materials(), view.camera, info());
    if (!layer().selection.levels.empty())
        prepareSegments();
}

bool Planner::takesLight(const Scene& scene) const {
    const auto bytes = [&](const Lighting& lighting) { return lightBytes(*this, lighting); };
    const Shading& shading = scene.shading;
    return !layer().reduces() && shading.on == layer().optics.shading &&
           shading.gradient == layer().optics.normals &&
           ambientChannels(scene.lighting) == ambientChannels(view.lighting) &&
           lightChannels(scene.lighting) == lightChannels(view.lighting) &&
           bytes(scene.lighting) <= bytes(view.lighting) && hasHistograms(scene, layer());
}

bool Planner::setLight(const Scene& scene) {
    if (!takesLight(scene))
        return false;
    const Shading& shading = scene.shading;
    checkLight(scene);
    revisions.function = revisions.tables = PlanRevisions::next();
    view.lighting = scene.lighting;
    view.shading = shading;
    view.lighting.surfaceOcclusion.reset();
    view.lighting.transport.reset();
    setShading(layer().optics, shading);
    setLighting(layer().optics, shading, view.lighting, layer().function.materials(), view.camera, info());
    return true;
}

void Planner::setValues(const Scene& scene, Reduction reduction) {
    layer().look = {scene.valueColour,
                    windowOf(scene.window, summarise(layer().statistics, info(), scene.volumes.at(0).unit))};
    layer().table = valueTable(layer().look, layer().function, reduction);
    chargeTables(Integrator::midpoint);
    Shading unlit;
    unlit.on = false;
    layer().optics = makeOptics(layer().table, info(), unlit, 0, Integrator::midpoint);
    layer().optics.reduction = reduction;
}

/// Rays show sums of the function's extinctions, or of a radiograph's.
void Planner::exposeSums(const Scene& scene) {
    view.exposure = exposureOf(scene.mode, scene.valueColour, scene.window);
    setExposure(view.exposure->window);
    if (scene.mode != Mode::radiograph)
        return;
    const SceneVolume& volume = scene.volumes.at(0);
    const ValueSummary values = summarise(layer().statistics, info(), volume.unit);
    if (!values.isHu && !looksLikeHu(values))
        throw badFile(layer().store->path().string() + ", mode radiograph",
                      "a volume in HU (--unit HU says that it is)",
                      "values from " + shownNumber(values.lowest) + " to " + shownNumber(values.highest));
    layer().function = radiographFunction(values.highest);
    layer().body = makeTable(bodyFunction());
}

void Planner::setExposure(const std::optional<GreyWindow>& window) {
    view.exposure->window = window;
    layer().look.window = window.value_or(GreyWindow());
}

RayFrame<double> Planner::frameOf(const glm::ivec2& size) const {
    RayFrame<double> frame = rayFrame(view.camera, rayVoxels(), size, view.quality.stepVoxels);
    (fused ? fused->part : view.part).clip(frame);
    return frame;
}

void Planner::aim() {
    view.frame = frameOf(view.imageSize);
    placeLights(layer().optics, view.lighting, view.camera, info());
}

void Planner::chargeTables(Integrator integrator) {
    layer().functionCharge = {};
    layer().functionCharge = ram->charge(tableRamBytes(layer().table.entries.size(), integrator),
                                         "the transfer function's tables");
}

void Planner::settleIntegrator(const FrameContext& context, std::size_t mostEntries) {
    mayTake = Integrator::midpoint;
    // A path's first place is sought in lanes by the midpoint rule, and costs little beside the path.
    if (view.quality.edgeFunction == EdgeFunction::nearest || view.lighting.transport)
        return;
    for (const Integrator larger : {Integrator::preintegrated, Integrator::preintegrated2d})
        if (MemoryPlan(context.ram.freeBytes(), context.gpu.freeBytes())
                .grant("tables of an integrator", tableRamBytes(mostEntries, larger),
                       integratorGpuBytes(mostEntries, larger), kPartsForTables, kPartsForTables))
            mayTake = larger;
    if (view.quality.integrator == Integrator::automatic)
        setIntegrator(automaticIntegrator());
}

void Planner::setStep(double stepVoxels) {
    view.quality.stepVoxels = stepVoxels;
    if (layer().mixed())
        layer().levels.mostStride = mostStride(layer().selection, view.quality);
    aim();
    prepareSegments();
}

void Planner::setIntegrator(Integrator integrator) {
    if (integrator == layer().optics.integrator)
        return;
    chargeTables(integrator);
    tessera::setIntegrator(layer().optics, integrator);
    revisions.tables = PlanRevisions::next();
    if (!layer().selection.levels.empty())
        prepareSegments();
}

void Planner::prepareSegments() {
    const Strides s = strides();
    const int longest = layer().mixed() ? layer().levels.mostStride
                                        : std::countr_zero(static_cast<unsigned>(s.uniformSegments));
    const int first = layer().mixed() ? 0 : longest;
    preparePreintegration2d(layer().optics, view.quality.stepVoxels * typicalVoxelMm(info()), first,
                            longest - first + 1);
    if (layer().optics.integrator == Integrator::preintegrated2d) // its tables depend on a length
        revisions.tables = PlanRevisions::next();
}

void Planner::setShadowLayers(int layers) {
    view.shadowQuality.layers = layers;
    for (const auto& volume : further)
        volume->plan.setShadowLayers(layers);
}

void Planner::setTermination(float transmittance) {
    layer().optics.termination = transmittance;
    revisions.tables = PlanRevisions::next();
}

void Planner::setSelection(Selection chosen) {
    layer().selection = std::move(chosen);
    mapLevels(false);
}

void Planner::mapLevels(bool always) {
    layer().levels = LevelMap();
    if (always || !layer().selection.uniform() || view.quality.edgeFunction == EdgeFunction::nearest)
        layer().levels = makeLevelMap(layer().selection, info().extentVoxels, view.quality, *ram);
    revisions.levels = PlanRevisions::next();
    prepareSegments();
    if (view.quality.skipping) {
        layer().mapEmptySpace(view.quality, *ram);
        revisions.emptySpace = PlanRevisions::next();
    }
    boundExtinction();
}

void Planner::mapFunction() {
    if (!view.quality.skipping)
        return;
    layer().functionChanged(view.quality, *ram, threads);
    revisions.emptySpace = PlanRevisions::next();
}

void Planner::chooseByVisibility(std::span<const SeenBrick> seen) {
    const std::vector<float> visible = visibilityFactors(seen, layer().selection);
    BestLevels better = bestLevels(*chosen.chooser, layer().statistics.brickMean, chosen.atlasPages, visible,
                                   unseenBy(view.lighting, view.shading, view.reflects));
    chosen.error = better.error;
    chosen.unseenBricks = better.unseenBricks;
    chosen.chooser.reset();
    setSelection(std::move(better.selection));
}

Camera plannedCamera(const Scene& scene, const ChunkSource& volume, const Statistics& statistics,
                     const TransferTable& table, const DrawnPart& part, MemoryBudget& ram, int threads,
                     LabelBricks* labels) {
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    if (!view)
        return std::get<Camera>(scene.camera);
    Camera camera = !view->named && scene.mode == Mode::slice
                        ? sliceCamera(scene.slice, volume.info(), scene.imageSize)
                        : fittedCamera(*view, volume, statistics, table, part, scene.imageSize, ram, threads,
                                       labels, drawnMeshes(scene));
    if (view->mmPerPixel > 0)
        camera.parallelScale = parallelScaleOf(view->mmPerPixel, scene.imageSize);
    return camera;
}

namespace {

/// Hides the table in the layer, where the scene asks for it, values are in HU and memory has room.
void hideTable(const Scene& scene, const ValueSummary& values, std::size_t floor, MemoryBudget& ram,
               int threads, Layer& layer) {
    if (scene.volumes.at(0).hideTable == HideTable::no || scene.mode == Mode::slice ||
        !(values.isHu || looksLikeHu(values)))
        return;
    const StoreReader& store = *layer.store;
    FoundTable found;
    std::unique_ptr<MaskedSource> masked;
    try {
        const Charge rest = ram.charge(floor - std::min(floor, ram.usedBytes()), "the scene");
        found = tableOf(store, ram, threads);
        if (const std::shared_ptr<const Mask> mask = found.mask) {
            masked = std::make_unique<MaskedSource>(
                store, std::move(found.mask), storedAir(layer.statistics, store.info(), true), ram, threads);
            hideMasked(layer.statistics, *masked, ram, threads);
            layer.hidden = hiddenNumber(*mask);
        }
    } catch (const InputError&) { // what cannot be read is told when it is drawn
        masked.reset();
        found.why = ram.option() + " has no room for looking, or voxels cannot be read";
    }
    layer.masked = std::move(masked);
    layer.patientTable = found;
}

} // namespace

Planner planChanging(const Scene& given, const StoreReader& store, MemoryBudget& ram, int threads,
                     std::size_t bytesPerPixel, KnownLayer* kept) {
    const Scene scene = asDrawn(given);
    checkScene(scene);
    Planner p;
    p.ram = &ram;
    p.threads = threads;
    p.view.quality = scene.quality;
    p.view.lighting = scene.lighting;
    p.view.lighting.transport.reset(); // of stills alone
    p.view.shading = scene.shading;
    p.view.surfaces = scene.surfaces;
    p.view.reflects = reflects(scene);
    p.view.background = scene.background.value_or(glm::vec3(0));
    p.view.meshes = drawnMeshes(scene);
    p.layer().store = &store;
    const VolumeInfo& info = store.info();
    p.view.imageSize = scene.imageSize;
    const std::size_t floor =
        renderFloorBytes(info, scene.imageSize, bytesPerPixel, threads, scene.quality.integrator);
    if (ram.limitBytes() < floor)
        throw InputError(ram.option() + ": this scene needs at least " + formatBytes(floor) +
                         ", but the budget is " + formatBytes(ram.limitBytes()));
    p.view.imageCharge = ram.charge(bytesPerPixel * rayCount(scene.imageSize), "the picture");
    p.layer().selectionCharge = ram.charge(selectionBytes(info), "the selection of bricks");
    p.layer().statistics = kept ? std::move(kept->statistics) : loadStatistics(store, ram, threads);
    const ValueSummary values = summarise(p.layer().statistics, info, scene.volumes.at(0).unit);
    for (const double value : {values.lowest, values.highest})
        checkValue(value, "physical values", store.path().string());
    hideTable(scene, values, floor, ram, threads, p.layer());
    hideLabels(scene, values, ram, threads, p.layer());
    takeLabels(scene, kept, ram, threads, p.layer());
    const TransferChoice& function = scene.volumes.at(0).transferFunction;
    const auto* const name = std::get_if<std::string>(&function);
    p.setFunction(ofLabels(name ? presetFunction(*name, values) : std::get<TransferFunction>(function),
                           scene.volumes.at(0).labels, values),
                  scene);
    p.view.part = drawnPart(scene, info);
    takeHistograms(scene, kept, ram, threads, p.layer());
    p.ramFloorBytes = floor + (p.layer().histograms ? p.layer().histograms->bytes() : 0);
    return p;
}

namespace {

/// Sets the scene's camera, which is that of lights too.
void takeCamera(const Scene& scene, Planner& p) {
    p.setCamera(plannedCamera(asDrawn(scene), p.layer().voxels(), p.layer().statistics,
                              p.layer().shownTable(), p.view.part, *p.ram, p.threads,
                              p.layer().labelBricks.get()));
}

} // namespace

Planner planVolume(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                   std::size_t bytesPerPixel, KnownLayer* known) {
    const Scene used = withoutUnusedLight(scene);
    Planner p = planChanging(used, store, ram, threads, bytesPerPixel, known);
    if (used.lighting.transport) {
        p.view.lighting.transport = used.lighting.transport;
        p.view.pathLighting = scene.lighting;
        setLighting(p.layer().optics, used.shading, p.view.lighting, p.layer().function.materials(),
                    p.view.camera, p.info());
    }
    checkPlan(scene, p);
    return p;
}

Planner planView(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                 std::size_t bytesPerPixel) {
    Planner p = planChanging(scene, store, ram, threads, bytesPerPixel);
    takeCamera(scene, p);
    p.view.lighting.surfaceOcclusion.reset();
    return p;
}

Planner planScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                  const FrameContext& context, LevelChoice choice, std::size_t bytesPerPixel,
                  KnownLayer* known) {
    Planner p = planVolume(scene, store, context.ram, context.threads, bytesPerPixel, known);
    takeCamera(scene, p);
    p.chooseAgain(scene, limits, context, choice);
    return p;
}

namespace {
constexpr char kCellMap[] = "the occupancy map, by cells";
constexpr char kBrickMap[] = "the occupancy map, by bricks";
constexpr char kSurfaceMap[] = "the occupancy map of isosurfaces";
} // namespace

void Planner::planMemory(const TextureLimits& limits, const FrameContext& context, bool changing) {
    const MemoryBudget &free = context.ram, &gpu = context.gpu;
    const VolumeInfo& volumeInfo = info();
    const glm::ivec3 extent = volumeInfo.extentVoxels, bricks = brickGrid(extent);
    // Visibility is counted before the picture, in its memory; with an error bound, rays wait for bricks.
    const int channels = channelsBeside();
    layer().lightCharge = {};
    const int layers = view.shadowQuality.layers; // the requested one
    view.shadowQuality = shadowQualityFor(view.lighting, free.freeBytes());
    view.shadowQuality.layers = layers;
    const std::size_t picture = placedRaysBytes(view.imageSize); // pixels are drawn again
    const std::size_t rays = view.quality.maxError
                                 ? picture + wantedBytes(bricks)
                                 : std::max(picture, visibilityBytes(view.imageSize, bricks));
    MemoryPlan floors;
    floors.need("rays", 0, rays);
    for (const auto& volume : this->further) // one list of all
        floors.need("further volumes' bricks that rays wait for", 0,
                    wantedBytes(brickGrid(volume->plan.info().extentVoxels)));
    if (view.lighting.surfaceOcclusion || view.reflects)
        floors.need("first hits of rays", 0, hitsBytes(view.imageSize));
    if (view.part.cuts) // one and a half intervals each, and their starts
        floors.need("intervals of rays", 0,
                    (kRayIntervalBytes * 3 / 2 + sizeof(std::size_t)) * rayCount(view.imageSize));
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

void Planner::boundExtinction() {
    if (!view.lighting.transport)
        return;
    layer().extinction = {};
    layer().extinction =
        ExtinctionBounds(occupancyInput(), layer().optics, mostExtinctionPerMm(info()), *ram, threads);
    if (layer().cache) // levels are chosen again: else openCache() goes on
        layer().extinction.refine(occupancyInput(), layer().optics, *layer().cache, *ram, threads);
}

std::string Planner::boundLight(const Scene& scene) {
    if (std::string why = whyNotByWays(*this); !why.empty())
        return why;
    try {
        layer().extinction =
            ExtinctionBounds(occupancyInput(), layer().optics, mostExtinctionPerMm(info()), *ram, threads);
    } catch (const InputError& e) { // of the budget
        return e.what();
    }
    view.pathLighting = scene.lighting;
    view.pathLighting.transport = Transport{TransportResponse::contract};
    return {};
}

void Planner::unboundLight() {
    layer().extinction = {};
}

OccupancyInput Planner::occupancyInput() const {
    const Layer& volume = layers.front();
    return {volume.statistics, volume.table, info(), volume.selection, view.quality.edgeFunction};
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

namespace {

/// Chooses for one of several volumes; a refusal for want of memory says that it is about a share.
/// @param number  from 1
template <typename Choose>
void chooseInShare(std::size_t number, std::size_t volumes, const FrameContext& context,
                   const Choose& choose) {
    try {
        choose();
    } catch (const InputError& e) {
        const std::string why = e.what();
        for (const MemoryBudget* budget : {&context.ram, &context.gpu})
            if (volumes > 1 && why.starts_with(budget->option()))
                throw InputError(why + " in the share of volume " + std::to_string(number) + " of " +
                                 std::to_string(volumes) + ", out of " + formatBytes(budget->limitBytes()));
        throw;
    }
}

/// For the first volume, or the only one.
void chooseOwn(Planner& p, const Scene& given, const TextureLimits& engineLimits, const FrameContext& context,
               LevelChoice choice) {
    const Scene scene = asDrawn(given);
    p.layer().cache.reset(); // it has all remaining memory
    p.view.quality = scene.quality;
    TextureLimits most = engineLimits;
    most.channelsBeside = p.channelsBeside();
    p.settleIntegrator(context, p.layer().table.entries.size());
    p.planMemory(most, context);
    TextureLimits limits = most;
    if (choice == LevelChoice::finest) { // rays wait for bricks: none is filled from neighbours
        p.layer().pageEdge = limits.pageEdge = kBrickExtent;
    } else if (limits.pageEdge > kBrickExtent) {
        Selection all =
            cullBricks(p.layer().statistics, p.layer().table, p.info(), 0, cullingFor(scene.shading));
        leaveOutUndrawn(all, p.view.part, p.info(),
                        pitchesOfGradients(p.layer().optics.takesGradients() || p.view.lighting.transport,
                                           scene.shading));
        p.chooseGhostLayers(limits, all.shownBricks(), context);
    }
    p.chosen = chooseLevels(scene, p.view.camera, p.view.part, p.layer(), limits, choice, p.memory.gpuBytes(),
                            p.memory.ramBytes(), context);
    p.setSelection(std::move(p.chosen.selection));
    p.aim();
    p.openCache(limits.readsOnce && !scene.quality.maxError); // passes read chunks again
}

} // namespace

void Planner::chooseAgain(const Scene& given, const TextureLimits& engineLimits, const FrameContext& context,
                          LevelChoice choice) {
    const std::size_t volumes = further.size() + 1;
    for (std::size_t n = 0; n < further.size(); ++n) {
        FurtherVolume& volume = further[n];
        chooseInShare(n + 2, volumes, context, [&] {
            volume.plan.chooseAgain(sceneInFusion(given, n + 1), engineLimits,
                                    {volume.ram, volume.gpu, context.threads, &context.progress}, choice);
        });
    }
    chooseInShare(1, volumes, context, [&] { chooseOwn(*this, given, engineLimits, context, choice); });
}

} // namespace tessera
