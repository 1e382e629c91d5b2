// render/plan/fusion.cpp: see fusion.h.
#include "render/plan/fusion.h"

#include "core/base/error.h"
#include "render/contract/ray_state.h" // placedRaysBytes
#include "render/plan/framing.h"
#include "render/plan/label_optics.h"
#include "render/plan/layer_histograms.h"
#include "render/plan/shown_rays.h"
#include "render/plan/turn_fit.h"
#include "render/plan/visibility_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <string>
#include <utility>

namespace tessera {

FurtherVolume::FurtherVolume(const FrameContext& context, std::size_t ramBytes, std::size_t gpuBytes)
    : ram(context.ram.name(), context.ram.option(), ramBytes),
      gpu(context.gpu.name(), context.gpu.option(), gpuBytes),
      heldRam(context.ram.charge(ramBytes, "a further volume")),
      heldGpu(context.gpu.charge(gpuBytes, "a further volume")) {}

VolumeInfo fusedLattice(std::span<const VolumeInfo* const> volumes) {
    constexpr double kMostVoxels = 1 << 24; // float counts them
    const VolumeInfo* finest = volumes.front();
    for (const VolumeInfo* info : volumes)
        if (typicalVoxelMm(*info) < typicalVoxelMm(*finest) * (1 - 1e-9))
            finest = info;
    glm::dvec3 low(0), high(finest->extentVoxels);
    const glm::dmat4 toFinest = glm::inverse(finest->patientFromVoxel);
    for (const VolumeInfo* info : volumes) {
        const glm::dmat4 matrix = toFinest * info->patientFromVoxel;
        for (int corner = 0; corner < 8 && info != finest; ++corner) {
            const glm::dvec3 at =
                glm::dvec3(corner & 1, (corner >> 1) & 1, corner >> 2) * glm::dvec3(info->extentVoxels);
            const glm::dvec3 there(matrix * glm::dvec4(at, 1));
            low = glm::min(low, there), high = glm::max(high, there);
        }
    }
    constexpr double kRounding = 1e-6; // of equal grids
    low = glm::floor(low + kRounding), high = glm::ceil(high - kRounding);
    const glm::dvec3 extent = high - low;
    if (!glm::all(glm::lessThan(extent, glm::dvec3(kMostVoxels))))
        throw InputError("volumes: expected volumes near to each other, found a distance of " +
                         std::to_string(std::max({extent.x, extent.y, extent.z})) +
                         " voxels of the finest between their outer borders");
    VolumeInfo lattice = *finest;
    lattice.extentVoxels = glm::ivec3(extent);
    lattice.patientFromVoxel[3] = finest->patientFromVoxel * glm::dvec4(low, 1);
    return lattice;
}

Scene sceneInFusion(const Scene& scene, std::size_t number) {
    Scene alone = sceneOfVolume(scene, number);
    const auto refuse = [](const std::string& what, const std::string& found) {
        return InputError(what + " in a scene of several volumes, found " + found);
    };
    if (reductionOf(scene) == Reduction::composite) {
        if (!scene.surfaces.empty() || scene.mode == Mode::isosurface)
            throw refuse("isosurfaces: expected none", std::to_string(scene.surfaces.size()));
        Integrator& integrator = alone.quality.integrator;
        if (integrator != Integrator::automatic && integrator != Integrator::midpoint)
            throw refuse("integrator: expected auto or midpoint", nameOf(integrator));
        integrator = Integrator::midpoint;
        if (scene.lighting.surfaceOcclusion)
            throw refuse("lighting.surfaceOcclusion: expected none", "it");
        if (scene.lighting.transport)
            throw refuse("lighting.transport: expected none", "it");
        checkHistograms(scene);
        if (scatters(scene.lighting))
            throw refuse("lighting.lights: expected none with \"scatter\"", "one");
    }
    for (const CropBox& box : scene.cuts.boxes)
        if (box.space == CropBox::Space::voxels)
            throw refuse("cuts: expected boxes in patient space, or in volumes[].cuts", "one in voxels");
    return alone;
}

int fusedSegments(const FramePlan& plan) {
    const auto pitchMm = [](const FramePlan& volume) {
        return typicalVoxelMm(volume.info()) * (1 << volume.layer().selection.finest());
    };
    double pitch = pitchMm(plan);
    for (const auto& volume : plan.further)
        pitch = std::min(pitch, pitchMm(volume->plan));
    const double lattice = typicalVoxelMm(plan.rayVoxels());
    int segments = 1;
    while (2 * segments * lattice <= pitch * (1 + 1e-9) &&
           2 * segments * plan.view.quality.stepVoxels <= kBrickExtent / 2)
        segments *= 2;
    return segments;
}

PredictedError predictedOf(const FramePlan& plan) {
    PredictedError sum = plan.chosen.error;
    for (const auto& volume : plan.further) {
        sum.mean += volume->plan.chosen.error.mean;
        sum.p99 += volume->plan.chosen.error.p99;
    }
    return sum;
}

namespace {

/// The shares of volumes in what a budget has: their least needs, and of the rest a quarter evenly, the
/// remainder by their size.
std::vector<std::size_t> sharesOf(std::size_t free, const std::vector<std::size_t>& least, Stores stores) {
    std::size_t all = 0;
    for (const std::size_t bytes : least)
        all += bytes;
    const double rest = static_cast<double>(free - std::min(free, all));
    const auto sizeOf = [](const StoreReader* store) {
        return static_cast<double>(store->info().voxelCount() * bytesPerValue(store->info().type));
    };
    double sizes = 0;
    for (const StoreReader* store : stores)
        sizes += sizeOf(store);
    std::vector<std::size_t> shares;
    for (std::size_t n = 0; n < stores.size(); ++n)
        shares.push_back(least[n] +
                         static_cast<std::size_t>(rest * (0.25 / static_cast<double>(stores.size()) +
                                                          0.75 * sizeOf(stores[n]) / sizes)));
    return shares;
}

/// The plans of all volumes without cameras; all but the first hold their shares.
/// @param changing  their functions and levels change: planChanging()
/// @param pixels  of the first's plan
/// @param furtherPerPixel  of the others
Planner planVolumes(const Scene& scene, Stores stores, const FrameContext& context, bool changing,
                    const PixelMemory& pixels, std::size_t furtherPerPixel = 0) {
    TESSERA_CHECK(stores.size() == scene.volumes.size());
    const auto planOne = [&](const Scene& alone, const StoreReader& store, MemoryBudget& ram, int threads,
                             const PixelMemory& of) {
        return (changing ? planChanging : planVolume)(alone, store, ram, threads, of, nullptr,
                                                      PlanDetail::whole);
    };
    // Of functions that change: the tables of rays and of visibility, whichever they may come to.
    constexpr std::size_t kTables = 2 * TransferTable::kMaxEntries * sizeof(glm::vec4);
    const glm::ivec2 together = pixels.of(scene.imageSize);
    const PixelMemory ofFurther(furtherPerPixel, pixels.most);
    std::vector<std::size_t> ramFloors, gpuFloors;
    for (std::size_t n = 0; n < stores.size(); ++n) {
        ramFloors.push_back(renderFloorBytes(stores[n]->info(), together,
                                             (n == 0 ? pixels : ofFurther).bytesPerPixel, context.threads,
                                             scene.quality.integrator));
        gpuFloors.push_back(placedRaysBytes(together));
        if (changing)
            gpuFloors.back() +=
                kTables + visibilityBytes(scene.imageSize, brickGrid(stores[n]->info().extentVoxels));
    }
    const std::vector<std::size_t> ram = sharesOf(context.ram.freeBytes(), ramFloors, stores),
                                   gpu = sharesOf(context.gpu.freeBytes(), gpuFloors, stores);
    FurtherVolumes further;
    for (std::size_t n = 1; n < stores.size(); ++n) {
        auto volume = std::make_unique<FurtherVolume>(context, ram[n], gpu[n]);
        volume->plan = planOne(sceneInFusion(scene, n), *stores[n], volume->ram, context.threads, ofFurther);
        volume->plan.view.meshesShade = false; // the first volume's maps hold them
        volume->plan.view.amongOthers = true;
        further.add(std::move(volume));
    }
    Planner p = planOne(sceneInFusion(scene, 0), *stores[0], context.ram, context.threads, pixels);
    p.further = std::move(further);
    p.view.amongOthers = true;
    return p;
}

} // namespace

namespace {

/// Those of volumes that a camera is fitted to: not of wholly transparent ones, if there are others.
std::vector<const Planner*> visiblePlans(const Scene& scene, const Planner& p) {
    const auto planOf = [&](std::size_t n) { return n == 0 ? &p : &p.further[n - 1].plan; };
    std::vector<const Planner*> visible, all;
    for (std::size_t n = 0; n < scene.volumes.size(); ++n) {
        all.push_back(planOf(n));
        if (scene.volumes[n].opacity > 0)
            visible.push_back(planOf(n));
    }
    return visible.empty() ? all : visible;
}

} // namespace

Camera plannedCamera(const Scene& scene, const Planner& p) {
    if (p.further.size() == 0)
        return plannedCamera(scene, p.layer().voxels(), p.layer().statistics, p.layer().shownTable(),
                             p.view.part, *p.ram, p.threads, p.layer().labelBricks.get());
    const std::vector<const Planner*> plans = visiblePlans(scene, p);
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    Camera camera;
    if (!view) {
        camera = std::get<Camera>(scene.camera);
    } else if (!view->named && scene.mode == Mode::slice) {
        camera = sliceCamera(scene.slice, p.info(), scene.imageSize);
    } else {
        ViewFit fit(axesOf(*view), view->projection, scene.imageSize), boxes = fit;
        for (const Planner* plan : plans) {
            const Layer& layer = plan->layer();
            if (view->fit != Fit::volume)
                fit.add(shownFit(*view, layer.voxels(), layer.statistics, layer.shownTable(), plan->view.part,
                                 scene.imageSize, *plan->ram, plan->threads, layer.labelBricks.get(),
                                 plan->view.meshes));
            const ViewSpace space(plan->info(), fit.axes());
            const glm::dvec3 extent(plan->info().extentVoxels);
            boxes.add(space.at(0.5 * extent), space.halfOf(extent));
        }
        camera = (fit.empty() ? boxes : fit).camera();
    }
    if (view && view->mmPerPixel > 0)
        camera.parallelScale = parallelScaleOf(view->mmPerPixel, scene.imageSize);
    return camera;
}

namespace {

/// For plans that nothing is drawn of.
MemoryBudget unusedGpu() {
    return {"GPU memory", "--gpu-memory", std::size_t{1} << 40};
}

/// Sets the camera of all plans.
void takeCameras(const Scene& scene, Planner& p) {
    const Camera camera = plannedCamera(scene, p);
    p.setCamera(camera);
    for (const auto& volume : p.further)
        volume->plan.setCamera(camera);
}

/// Puts all volumes under the same rays.
void fuse(const Scene& scene, Stores stores, Planner& p) {
    std::vector<const VolumeInfo*> infos;
    for (const StoreReader* store : stores)
        infos.push_back(&store->info());
    FusedLattice& fused = p.fused.emplace();
    fused.rule = scene.fusion;
    fused.voxels = fusedLattice(infos);
    fused.part = drawnPart(scene, fused.voxels);
    const auto from = [&](const VolumeInfo& info) {
        return glm::inverse(info.patientFromVoxel) * fused.voxels.patientFromVoxel;
    };
    fused.fromLattice = from(p.info());
    fused.cuts = ownCuts(scene.volumes.front().cuts, p.info());
    for (std::size_t n = 0; n < p.further.size(); ++n) {
        FurtherVolume& volume = p.further[n];
        volume.fromLattice = from(volume.plan.info());
        volume.cuts = ownCuts(scene.volumes[n + 1].cuts, volume.plan.info());
    }
}

} // namespace

Planner planScene(const Scene& scene, Stores stores, const TextureLimits& limits, const FrameContext& context,
                  LevelChoice choice, const PixelMemory& pixels) {
    if (stores.size() == 1)
        return planScene(scene, *stores.front(), limits, context, choice, pixels);
    Planner p = planVolumes(scene, stores, context, false, pixels);
    fuse(scene, stores, p);
    takeCameras(scene, p);
    p.chooseAgain(scene, limits, context, choice);
    return p;
}

Planner planViews(const Scene& scene, Stores stores, const FrameContext& context, std::size_t bytesPerPixel,
                  PlanDetail detail) {
    if (stores.size() == 1)
        return planView(scene, *stores.front(), context.ram, context.threads, bytesPerPixel, detail);
    const bool together = reductionOf(scene) == Reduction::composite;
    Planner p = planVolumes(scene, stores, context, true, bytesPerPixel, together ? 0 : bytesPerPixel);
    if (together)
        fuse(scene, stores, p);
    takeCameras(scene, p);
    return p;
}

void TurnFit::add(const TurnFit& other) {
    if (fits.empty())
        fits = other.fits;
    else
        for (std::size_t n = 0; n < fits.size(); ++n)
            if (fits[n].empty())
                fits[n] = other.fits[n];
            else if (!other.fits[n].empty())
                fits[n].add(other.fits[n]);
    boxes.insert(boxes.end(), other.boxes.begin(), other.boxes.end());
}

TurnFit turnFit(const Scene& scene, Stores stores, MemoryBudget& ram, int threads) {
    MemoryBudget gpu = unusedGpu();
    const FrameContext context(ram, gpu, threads);
    const DrawnVolumes volumes = withLabelOptics(asDrawn(scene), stores);
    const std::vector<SceneMesh> meshes = drawnMeshes(scene);
    const FittedView& view = std::get<FittedView>(scene.camera);
    const Planner p = volumes.stores.size() == 1
                          ? planView(scene, *stores.front(), ram, threads)
                          : planVolumes(volumes.scene, volumes.stores, context, false, kPictureBytesPerPixel);
    TurnFit together;
    for (const Planner* plan : visiblePlans(volumes.scene, p)) {
        const Layer& layer = plan->layer();
        together.add({turningFits(view, layer.voxels(), layer.statistics, layer.shownTable(), plan->view.part,
                                  scene.imageSize, *plan->ram, threads, layer.labelBricks.get(), meshes),
                      {plan->info()}});
    }
    return together;
}

Camera turningCamera(const Scene& scene, TurnFit fit) {
    const FittedView& view = std::get<FittedView>(scene.camera);
    std::vector<const VolumeInfo*> boxes;
    for (const VolumeInfo& box : fit.boxes)
        boxes.push_back(&box);
    Camera camera = turningCamera(view, std::move(fit.fits), boxes, scene.imageSize);
    if (view.mmPerPixel > 0)
        camera.parallelScale = parallelScaleOf(view.mmPerPixel, scene.imageSize);
    return camera;
}

Camera turningCamera(const Scene& scene, Stores stores, MemoryBudget& ram, int threads) {
    return turningCamera(scene, turnFit(scene, stores, ram, threads));
}

Scene resolved(const Scene& scene, Stores stores, MemoryBudget& ram, int threads, std::size_t bytesPerPixel) {
    MemoryBudget gpu = unusedGpu();
    const DrawnVolumes volumes = withLabelOptics(asDrawn(scene), stores);
    const bool isOne = volumes.stores.size() == 1;
    Planner p = isOne ? planView(scene, *stores.front(), ram, threads, bytesPerPixel)
                      : planVolumes(volumes.scene, volumes.stores, {ram, gpu, threads}, false, bytesPerPixel);
    if (!isOne)
        takeCameras(volumes.scene, p);
    Scene found = scene;
    found.camera = p.view.camera;
    for (std::size_t n = 0; n < found.volumes.size() && scene.mode != Mode::radiograph; ++n)
        found.volumes[n].transferFunction = (n == 0 ? p : p.further[n - 1].plan).layer().function;
    return found;
}

} // namespace tessera
