// render/plan/planner.cpp: see planner.h.
#include "render/plan/planner.h"

#include "bricking/analysis/body/kept_table.h"
#include "bricking/cache/level_source.h"
#include "bricking/statistics/coarse_statistics.h"
#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "render/contract/ray_state.h"
#include "render/geometry/shape.h"
#include "render/plan/framing.h"
#include "render/plan/fusion.h"
#include "render/plan/label_optics.h"
#include "render/plan/layer_histograms.h"
#include "render/plan/layer_labels.h"
#include "render/plan/quick_level.h"
#include "render/plan/scene_rules.h"

#include <algorithm>
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
    if (replacesLightOfVoxels(scene))
        scene.lighting.occlusion.reset();
    const auto* function = std::get_if<TransferFunction>(&scene.volumes.at(0).transferFunction);
    if (scene.lighting.occlusion && !(function && function->emits())) // presets emit none
        scene.lighting.occlusion->emission = 0;
    return scene;
}

} // namespace

RayFrame<double> Planner::frameOf(const glm::ivec2& size) const {
    RayFrame<double> frame = rayFrame(view.camera, rayVoxels(), size, view.quality.stepVoxels);
    (fused ? fused->part : view.part).clip(frame);
    if (const Hulls hulls = view.hulls(); hulls.count > 0) {
        frame.hulls = rayHulls(view.camera, rayVoxels(), hulls.count, hulls.samples);
        if (hulls.samples == Hulls::kAutomatic) { // until they are chosen: one for each of the steps
            const double mm = (frame.hulls.farthest - frame.hulls.nearest) / hulls.count;
            frame.hulls.samples = static_cast<int>(
                std::clamp(std::ceil(mm / (view.quality.stepVoxels * typicalVoxelMm(rayVoxels()))), 1.0,
                           double{Hulls::kMostSamples}));
        }
    }
    return frame;
}

void Planner::aim() {
    view.frame = frameOf(view.imageSize);
    placeLights(layer().optics, view.lighting, view.camera, info());
}

void Planner::setShadowLayers(int layers) {
    view.shadowQuality.layers = layers;
    for (const auto& volume : further)
        volume->plan.setShadowLayers(layers);
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
/// @param detail  coarse: a table that the store does not keep stays
void hideTable(const Scene& scene, const ValueSummary& values, std::size_t floor, MemoryBudget& ram,
               int threads, PlanDetail detail, Layer& layer) {
    if (scene.volumes.at(0).hideTable == HideTable::no || scene.mode == Mode::slice ||
        !(values.isHu || looksLikeHu(values)))
        return;
    const StoreReader& store = *layer.store;
    FoundTable found;
    std::unique_ptr<MaskedSource> masked;
    try {
        const Charge rest = ram.charge(floor - std::min(floor, ram.usedBytes()), "the scene");
        found = detail == PlanDetail::coarse ? keptTableOf(store, ram).value_or(FoundTable())
                                             : tableOf(store, ram, threads);
        if (const std::shared_ptr<const Mask> mask = found.mask) {
            masked = std::make_unique<MaskedSource>(
                store, std::move(found.mask), storedAir(layer.statistics, store.info(), true), ram, threads);
            hideMasked(layer.statistics, *masked, ram, threads);
            layer.hidden = hiddenNumber(*mask);
        }
    } catch (const InputError&) { // what cannot be read is told when it is drawn
        masked.reset();
        found.why = ram.option() + " has no room for looking, or voxels cannot be read";
        found.isUnknown = true;
    }
    layer.masked = std::move(masked);
    layer.patientTable = found;
}

/// A picture of a coarse level needs no more than bounds of the volume's cells. Light by local histograms,
/// and labels, follow from what cells hold.
bool boundsSuffice(const Scene& scene, const VolumeInfo& info) {
    const auto& occlusion = scene.lighting.occlusion;
    return quickLevel(info.extentVoxels) > 0 && scene.volumes.at(0).labels.path.empty() &&
           !(occlusion && occlusion->method == OcclusionMethod::histogram);
}

} // namespace

Planner planChanging(const Scene& given, const StoreReader& store, MemoryBudget& ram, int threads,
                     const PixelMemory& pixels, KnownLayer* kept, PlanDetail detail) {
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
    const glm::ivec2 together = pixels.of(scene.imageSize);
    if (pixels.most.x > 0)
        p.view.mostTogether = together;
    const std::size_t floor =
        renderFloorBytes(info, together, pixels.bytesPerPixel, threads, scene.quality.integrator);
    if (ram.limitBytes() < floor)
        throw OverBudget(ram.option() + ": this scene needs at least " + formatBytes(floor) +
                         ", but the budget is " + formatBytes(ram.limitBytes()) +
                         (pixels.bytesPerPixel * rayCount(together) > ram.limitBytes()
                              ? "; --tiles draws large pictures in parts"
                              : ""));
    p.view.imageCharge = ram.charge(pixels.bytesPerPixel * rayCount(together), "the picture");
    p.layer().selectionCharge = ram.charge(selectionBytes(info), "the selection of bricks");
    if (detail == PlanDetail::coarse && !kept && boundsSuffice(scene, info))
        if (auto coarse = loadCoarseStatistics(store, ram, threads)) {
            p.layer().statistics = *std::move(coarse);
            p.isCoarse = true;
        }
    if (!p.isCoarse)
        p.layer().statistics = kept ? std::move(kept->statistics) : loadStatistics(store, ram, threads);
    const ValueSummary values = summarise(p.layer().statistics, info, scene.volumes.at(0).unit);
    for (const double value : {values.lowest, values.highest})
        checkValue(value, "physical values", store.path().string());
    hideTable(scene, values, floor, ram, threads, p.isCoarse ? PlanDetail::coarse : PlanDetail::whole,
              p.layer());
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

void Planner::drawInParts(const PixelMemory& pixels) {
    view.mostTogether = pixels.of(view.imageSize);
    view.imageCharge = {};
    view.imageCharge = ram->charge(pixels.bytesPerPixel * rayCount(view.mostTogether), "the picture");
}

namespace {

/// The scene's camera by the level of a first picture: where it is fitted, hardly another than the picture's.
Camera coarseCamera(const Scene& scene, const Planner& p) {
    const int level = quickLevel(p.info().extentVoxels);
    const LevelSource volume(p.layer().voxels(), level);
    const Statistics bounds = boundsOfLevel(p.layer().statistics, p.info(), level, *p.ram, p.threads);
    return plannedCamera(scene, volume, bounds, p.layer().shownTable(), drawnPart(scene, volume.info()),
                         *p.ram, p.threads);
}

/// RAM of a still's voxels of meshes for surfaceOcclusion, at most.
std::size_t meshBitsBytes(const Scene& scene) {
    const auto& occlusion = scene.lighting.surfaceOcclusion;
    const std::vector<SceneMesh> meshes = drawnMeshes(scene);
    if (!occlusion || scene.lighting.transport || meshes.empty())
        return 0;
    return MeshBits::bytesAtMost(meshes, gridAround(meshes, occlusion->resolution), true);
}

/// They are as much a part of what a picture cannot do without as what planVolume() looks at.
void checkFloorWithBits(const Scene& scene, std::size_t bits, const VolumeInfo& info,
                        const FrameContext& context, const PixelMemory& pixels) {
    std::size_t floor = bits + renderFloorBytes(info, pixels.of(scene.imageSize), pixels.bytesPerPixel,
                                                context.threads, scene.quality.integrator);
    for (const SceneMesh& mesh : drawnMeshes(scene))
        floor += mesh.shape->bytes();
    if (context.ram.limitBytes() < floor)
        throw OverBudget(context.ram.option() + ": this scene needs at least " + formatBytes(floor) +
                         " (with meshes and their voxels), but the budget is " +
                         formatBytes(context.ram.limitBytes()));
}

/// Sets the scene's camera, which is that of lights too.
void takeCamera(const Scene& given, Planner& p) {
    const Scene scene = asDrawn(given);
    if (p.isCoarse && scene.mode != Mode::slice)
        return p.setCamera(coarseCamera(scene, p));
    p.setCamera(plannedCamera(scene, p.layer().voxels(), p.layer().statistics, p.layer().shownTable(),
                              p.view.part, *p.ram, p.threads, p.layer().labelBricks.get()));
}

} // namespace

Planner planVolume(const Scene& scene, const StoreReader& store, MemoryBudget& ram, int threads,
                   const PixelMemory& pixels, KnownLayer* known, PlanDetail detail) {
    const Scene used = withoutUnusedLight(scene);
    Planner p = planChanging(used, store, ram, threads, pixels, known, detail);
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
                 const PixelMemory& pixels, PlanDetail detail) {
    Planner p = planChanging(scene, store, ram, threads, pixels, nullptr, detail);
    takeCamera(scene, p);
    p.view.lighting.surfaceOcclusion.reset();
    return p;
}

Planner planScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                  const FrameContext& context, LevelChoice choice, const PixelMemory& pixels,
                  KnownLayer* known) {
    const std::size_t bits = meshBitsBytes(asDrawn(scene));
    if (bits > 0)
        checkFloorWithBits(scene, bits, store.info(), context, pixels);
    Planner p = planVolume(scene, store, context.ram, context.threads, pixels, known,
                           choice == LevelChoice::quick ? PlanDetail::coarse : PlanDetail::whole);
    p.ramFloorBytes += bits;
    takeCamera(scene, p);
    if (const auto& occlusion = p.view.lighting.surfaceOcclusion; occlusion && !p.view.meshes.empty()) {
        const VoxelGrid grid = gridAround(p.view.meshes, occlusion->resolution);
        if (grid.edgeMm >= occlusion->radiusMm) // rays would begin behind their end
            throw InputError(
                "lighting.surfaceOcclusion.resolution: expected voxels of the meshes' box smaller than the "
                "radius of " +
                std::to_string(occlusion->radiusMm) + " mm, found " + std::to_string(grid.edgeMm) +
                " mm: meshes lie far apart, or the resolution is low");
        p.view.meshBits = std::make_shared<const MeshBits>(p.view.meshes, grid, p.ram, p.threads, true);
    }
    p.chooseAgain(scene, limits, context, choice);
    return p;
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

namespace {

/// Chooses for one of several volumes; a refusal for want of memory says that it is about a share.
/// @param number  from 1
template <typename Choose>
void chooseInShare(std::size_t number, std::size_t volumes, const FrameContext& context,
                   const Choose& choose) {
    try {
        choose();
    } catch (const OverBudget& e) {
        const std::string why = e.what();
        for (const MemoryBudget* budget : {&context.ram, &context.gpu})
            if (volumes > 1 && why.starts_with(budget->option()))
                throw OverBudget(why + " in the share of volume " + std::to_string(number) + " of " +
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
    if (choice == LevelChoice::finest ||
        context.group) { // rays wait for bricks: none is filled from neighbours
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
    p.shared = p.chosen.shared;
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
