// render/plan/prepare.cpp: see prepare.h.
#include "render/plan/prepare.h"

#include "core/error.h"
#include "core/threads.h"
#include "render/contract/lattice.h"
#include "render/plan/choose_integrator.h"
#include "render/plan/framing.h"
#include "render/plan/visibility_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tessera {

ValueSummary summarise(const Statistics& statistics, const VolumeInfo& info, const std::string& unit) {
    ValueSummary summary;
    const double a = info.rescaleSlope * static_cast<double>(statistics.lowest) + info.rescaleIntercept;
    const double b = info.rescaleSlope * static_cast<double>(statistics.highest) + info.rescaleIntercept;
    summary.lowest = std::min(a, b);
    summary.highest = std::max(a, b);
    summary.isHu = info.unit == "HU" || unit == "HU";
    const glm::dvec3 spacing = info.spacingMm();
    summary.spacingMm = std::cbrt(spacing.x * spacing.y * spacing.z);
    for (const std::uint64_t count : statistics.histogram)
        summary.histogram.push_back(static_cast<double>(count));
    if (info.rescaleSlope < 0)
        std::reverse(summary.histogram.begin(), summary.histogram.end());
    return summary;
}

namespace {

std::size_t pixelCount(const glm::ivec2& size) {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
}
std::size_t selectionBytes(const VolumeInfo& info) {
    return cellCount(brickGrid(info.extentVoxels)) * (sizeof(std::uint8_t) + sizeof(float));
}
/// What integrators need beside a table: bins and sums.
std::size_t sumsBytes(std::size_t entries) {
    return (3 * entries + 5) * sizeof(glm::vec4);
}
/// RAM of a transfer function's tables: its own as TransferTable and as Optics hold it, sums, and the tables
/// of colours with the one that an upload copies.
std::size_t tableBytes(std::size_t entries, Integrator integrator) {
    const bool sums = integrator == Integrator::preintegrated || integrator == Integrator::preintegrated2d;
    const std::size_t seen =
        integrator == Integrator::preintegrated2d ? 2 * SeenColours::bytes(kLevelCount) : 0;
    return entries * (2 * sizeof(glm::vec4) + sizeof(int)) + (sums ? sumsBytes(entries) : 0) + seen;
}
/// The edge of a cube of a voxel's volume.
double typicalVoxelMm(const VolumeInfo& info) {
    return std::cbrt(std::abs(glm::determinant(glm::dmat3(info.patientFromVoxel))));
}
/// Integrators that use a segment's ends take the field to be continuous.
void checkIntegrator(const Quality& quality) {
    if (quality.edgeFunction == EdgeFunction::nearest && quality.integrator != Integrator::automatic &&
        quality.integrator != Integrator::midpoint)
        throw InputError(
            "integrator: expected midpoint where bricks are not blended (edge function nearest), "
            "found " +
            integratorNames()[static_cast<std::size_t>(quality.integrator)]);
}
/// An integrator that is not asked for by name takes tables only where they are a small part of what is free.
constexpr std::size_t kShareForTables = 16;
/// What the eye cannot see in a segment's colour.
constexpr double kSeenColourMatters = 1.0 / 255;

} // namespace

std::size_t renderFloorBytes(const VolumeInfo& info, const glm::ivec2& imageSize, std::size_t bytesPerPixel,
                             int threads, Integrator integrator) {
    const int used = threads > 0 ? threads : defaultThreads();
    // The camera is fitted before there are levels, their maps and the cache.
    const std::size_t afterTheCamera = Occupancy::bytes(info.extentVoxels, MapScale::bricks) +
                                       LevelMap::bytes(brickGrid(info.extentVoxels)) +
                                       latticeCacheFloorBytes(info, used) + stagingBytes(info);
    const std::size_t own = bytesPerPixel * pixelCount(imageSize) + selectionBytes(info) +
                            tableBytes(TransferTable::kMaxEntries, integrator) +
                            std::max(afterTheCamera, framingBytes(info, used));
    // A reader takes up to a quarter of what is free (store_reader.h); the statistics' floor knows that.
    return statisticsFloorBytes(info, used) + own / 3 * 4 + 4;
}

namespace {
/// Cells where their map is a small part of the budget's RAM beyond the floor and fits what the bricks leave
/// of the GPU's memory; else the floor's map of bricks.
MapScale chooseMapScale(const glm::ivec3& extentVoxels, std::size_t spareRam, std::size_t spareGpu) {
    constexpr std::size_t kShareOfRam = 16;
    const bool fits = Occupancy::bytes(extentVoxels, MapScale::cells) <= spareRam / kShareOfRam &&
                      mapBytes(extentVoxels, MapScale::cells) <= spareGpu;
    return fits ? MapScale::cells : MapScale::bricks;
}
} // namespace

Strides PreparedScene::strides() const {
    Strides strides;
    strides.sampling = quality.sampling;
    strides.segmentVoxels = quality.stepVoxels;
    if (mixed())
        strides.map = &levels;
    else
        strides.uniformSegments = 1 << mostStride(selection, quality);
    return strides;
}

void PreparedScene::setFunction(const TransferFunction& f, const Scene& scene, Ledger& ram) {
    function = f;
    std::vector<SurfaceValue> surfaces;
    for (const Isosurface& surface : scene.surfaces)
        if (surface.opacity > 0)
            surfaces.push_back({surface.value, glm::vec3(surface.colour), surface.opacity});
    table = makeTable(function, std::move(surfaces));
    const Integrator integrator =
        scene.quality.integrator == Integrator::automatic ? automaticIntegrator() : scene.quality.integrator;
    chargeTables(integrator, ram);
    SeenColours seen = std::move(optics.seen); // may serve on
    optics = makeOptics(table, info(), scene.shading, scene.quality.terminationTransmittance, integrator);
    optics.seen = std::move(seen);
    optics.surfaces = surfaceLooks(scene.surfaces, info());
    if (!selection.levels.empty())
        prepareSegments();
}

void PreparedScene::chargeTables(Integrator integrator, Ledger& ram) {
    functionCharge = {};
    functionCharge =
        ram.charge(tableBytes(table.entries.size(), integrator), "the transfer function's tables");
}

Integrator PreparedScene::preintegration() const {
    const double change = quality.stepVoxels * typicalChangePerVoxel(statistics, table, info());
    const double length = quality.stepVoxels * typicalVoxelMm(info());
    return mayTake == Integrator::preintegrated2d &&
                   seenColourDifference(table, change, length) > kSeenColourMatters
               ? Integrator::preintegrated2d
               : Integrator::preintegrated;
}

Integrator PreparedScene::automaticIntegrator() const {
    return mayTake == Integrator::midpoint || !isSharp(statistics, table, info(), quality.stepVoxels)
               ? Integrator::midpoint
               : preintegration();
}

std::vector<Integrator> PreparedScene::integratorsToTry() const {
    if (quality.integrator != Integrator::automatic || mayTake == Integrator::midpoint ||
        isSmooth(statistics, table, info(), quality.stepVoxels))
        return {optics.integrator};
    return {Integrator::midpoint, preintegration()};
}

void PreparedScene::settleIntegrator(Ledger& ram, const Ledger& gpu, std::size_t mostEntries) {
    mayTake = Integrator::midpoint;
    if (quality.edgeFunction == EdgeFunction::nearest)
        return;
    for (const Integrator larger : {Integrator::preintegrated, Integrator::preintegrated2d}) {
        const std::size_t onGpu =
            sumsBytes(mostEntries) +
            (larger == Integrator::preintegrated2d ? SeenColours::bytes(kLevelCount) : 0);
        if (ram.freeBytes() / kShareForTables >= tableBytes(mostEntries, larger) &&
            gpu.freeBytes() / kShareForTables >= onGpu)
            mayTake = larger;
    }
    if (quality.integrator == Integrator::automatic)
        setIntegrator(automaticIntegrator(), ram);
}

std::size_t PreparedScene::gpuTableBytes(std::size_t entries) const {
    const bool named =
        quality.integrator == Integrator::preintegrated || quality.integrator == Integrator::preintegrated2d;
    const Integrator most = quality.integrator == Integrator::automatic ? mayTake : quality.integrator;
    return entries * sizeof(glm::vec4) + (named || most != Integrator::midpoint ? sumsBytes(entries) : 0) +
           (most == Integrator::preintegrated2d ? SeenColours::bytes(kLevelCount) : 0);
}

void PreparedScene::setStep(double stepVoxels) {
    quality.stepVoxels = stepVoxels;
    if (mixed())
        levels.mostStride = mostStride(selection, quality);
    frame = rayFrame(camera, info(), imageSize, stepVoxels);
    prepareSegments();
}

void PreparedScene::setIntegrator(Integrator integrator, Ledger& ram) {
    if (integrator == optics.integrator)
        return;
    chargeTables(integrator, ram);
    tessera::setIntegrator(optics, integrator);
    if (!selection.levels.empty())
        prepareSegments();
}

void PreparedScene::prepareSegments() {
    const Strides s = strides();
    const int longest =
        mixed() ? levels.mostStride : std::countr_zero(static_cast<unsigned>(s.uniformSegments));
    const int first = mixed() ? 0 : longest;
    prepareSeenColours(optics, quality.stepVoxels * typicalVoxelMm(info()), first, longest - first + 1);
}

void PreparedScene::setSelection(Selection chosen, Ledger& ram) {
    selection = std::move(chosen);
    mapLevels(ram, false);
}

void PreparedScene::mapLevels(Ledger& ram, bool always) {
    levels = LevelMap();
    if (always || !selection.uniform() || quality.edgeFunction == EdgeFunction::nearest)
        levels = makeLevelMap(selection, info().extentVoxels, quality, ram);
    prepareSegments();
    if (quality.skipping)
        mapEmptySpace(ram);
}

void PreparedScene::chooseBySight(std::span<const SeenBrick> seen, Ledger& ram) {
    const std::vector<float> visible = visibilityFactors(seen, selection);
    BestLevels better = bestLevels(*chosen.chooser, statistics.brickMean, chosen.atlasPages, visible);
    chosen.error = better.error;
    chosen.chooser.reset();
    setSelection(std::move(better.selection), ram);
}

void PreparedScene::mapEmptySpace(Ledger& ram) {
    const OccupancyInput input{statistics, table, info(), selection, quality.edgeFunction};
    if (occupancy.exists())
        occupancy.levelsChanged(input);
    else
        occupancy = Occupancy(input, mapScale, ram);
    if (!mapsNearSurfaces)
        return;
    const OccupancyInput ofSurfaces{statistics, surfaceTable, info(), selection, quality.edgeFunction};
    if (nearSurfaces.exists())
        nearSurfaces.levelsChanged(ofSurfaces);
    else
        nearSurfaces = Occupancy(ofSurfaces, mapScale, ram);
}

PreparedScene prepareView(const Scene& scene, const StoreReader& store, Ledger& ram, int threads,
                          std::size_t bytesPerPixel) {
    checkIntegrator(scene.quality);
    PreparedScene p;
    p.quality = scene.quality;
    p.store = &store;
    const VolumeInfo& info = store.info();
    p.imageSize = scene.imageSize;
    const std::size_t floor =
        renderFloorBytes(info, scene.imageSize, bytesPerPixel, threads, scene.quality.integrator);
    if (ram.limitBytes() < floor)
        throw InputError(ram.option() + ": this scene needs at least " + formatBytes(floor) +
                         ", but the budget is " + formatBytes(ram.limitBytes()));
    p.imageCharge = ram.charge(bytesPerPixel * pixelCount(scene.imageSize), "the picture");
    p.selectionCharge = ram.charge(selectionBytes(info), "the selection of bricks");
    p.statistics = loadStatistics(store, ram, threads);
    const TransferChoice& function = scene.volumes.at(0).transferFunction;
    if (const auto* name = std::get_if<std::string>(&function))
        p.setFunction(presetFunction(*name, summarise(p.statistics, info, scene.volumes.at(0).unit)), scene,
                      ram);
    else
        p.setFunction(std::get<TransferFunction>(function), scene, ram);
    if (const auto* view = std::get_if<FittedView>(&scene.camera))
        p.camera = fittedCamera(*view, store, p.statistics, p.table, scene.imageSize, ram, threads);
    else
        p.camera = std::get<Camera>(scene.camera);

    p.ramFloorBytes = floor;
    return p;
}

PreparedScene prepareScene(const Scene& scene, const StoreReader& store, const TextureLimits& limits,
                           Ledger& ram, const Ledger& gpu, int threads, LevelChoice choice,
                           std::size_t bytesPerPixel) {
    PreparedScene p = prepareView(scene, store, ram, threads, bytesPerPixel);
    chooseAgain(p, scene, limits, ram, gpu, threads, choice);
    return p;
}

std::size_t PreparedScene::reserveGpu(const TextureLimits& limits, const Ledger& ram, const Ledger& gpu) {
    const glm::ivec3 bricks = brickGrid(info().extentVoxels);
    // Rays and tables; with quality to reach, also what rays wait with. What is seen is counted before the
    // picture, in its room.
    const std::size_t picture = rayStateBytes(imageSize);
    const std::size_t rays = quality.maxError ? picture + wantedBytes(bricks)
                                              : std::max(picture, visibilityBytes(imageSize, bricks));
    const std::size_t fixed =
        rays + indexBytes(bricks) + LevelMap::bytes(bricks) + gpuTableBytes(optics.table.size());
    if (!quality.skipping)
        return fixed;
    // The map of empty space: at bricks' scale in the floor, beyond what that promises to bricks; of cells
    // where it is a small part.
    const std::size_t promised = fixed + atlasBytes(neighbourhoodPages(true, true), info().type, limits);
    const std::size_t spareGpu = gpu.freeBytes() - std::min(gpu.freeBytes(), promised);
    mapScale = chooseMapScale(info().extentVoxels, ram.limitBytes() - ramFloorBytes, spareGpu / 4);
    const std::size_t map = mapBytes(info().extentVoxels, mapScale);
    // Another of isosurfaces is a luxury: without it rays solve for them wherever anything shows.
    mapsNearSurfaces = !optics.surfaces.empty() && optics.volumeShows && mapScale == MapScale::cells &&
                       map <= spareGpu / 8 && 32 * map <= ram.limitBytes() - ramFloorBytes;
    if (!mapsNearSurfaces)
        return fixed + map;
    surfaceTable = table.ofSurfaces();
    return fixed + 2 * map;
}

std::size_t PreparedScene::ramToKeep(int threads) const {
    return latticeCacheFloorBytes(info(), threads > 0 ? threads : defaultThreads()) + stagingBytes(info()) +
           LevelMap::bytes(brickGrid(info().extentVoxels)) +
           (quality.skipping ? (mapsNearSurfaces ? 2 : 1) * Occupancy::bytes(info().extentVoxels, mapScale)
                             : 0);
}

void PreparedScene::openCache(Ledger& ram, int threads) {
    // It takes what is left, less upload staging and, where there is plenty, some air.
    const int used = threads > 0 ? threads : defaultThreads();
    const std::size_t free = ram.freeBytes(), staging = stagingBytes(info());
    const std::size_t left = free > staging ? free - staging : 0;
    const std::size_t bytes = std::max(std::min(left, latticeCacheFloorBytes(info(), used)), left - left / 8);
    cache = std::make_unique<BrickCache>(*store, ram, bytes, used);
}

void chooseAgain(PreparedScene& p, const Scene& scene, const TextureLimits& limits, Ledger& ram,
                 const Ledger& gpu, int threads, LevelChoice choice) {
    p.cache.reset(); // it holds all memory that was left
    p.quality = scene.quality;
    p.settleIntegrator(ram, gpu, p.table.entries.size());
    const std::size_t fixed = p.reserveGpu(limits, ram, gpu);
    p.chosen = chooseLevels(scene, p.camera, p.statistics, p.table, *p.store, limits, choice, gpu, fixed, ram,
                            p.ramToKeep(threads), threads);
    p.setSelection(std::move(p.chosen.selection), ram);
    p.frame = rayFrame(p.camera, p.info(), scene.imageSize, scene.quality.stepVoxels);
    p.openCache(ram, threads);
}

} // namespace tessera
