// viewer/session/open_volume.cpp: see open_volume.h.
#include "viewer/session/open_volume.h"

#include "core/base/address.h"
#include "core/base/error.h"
#include "core/scene/preset.h"
#include "render/contract/ray_state.h" // rayCount
#include "render/plan/frame_plan.h"
#include "viewer/cli/input/environment_input.h"
#include "viewer/cli/input/further_volumes.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/mesh_input.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/options/scene_options.h"
#include "viewer/session/view_geometry.h" // heldBy
#include "viewer/session/volume_values.h"

#include <algorithm>
#include <cstdint>
#include <glm/matrix.hpp>
#include <variant>

namespace tessera {
namespace {

constexpr int kHistogramBinsSeen = 256;
constexpr std::size_t kSliceParts = 8; // of the RAM; the three planes get one of them
/// Parts of the RAM where interactive pictures would not fit beside stills. Planes and lines get one each,
/// and stills are left out.
constexpr std::size_t kTightParts = 16;
/// Pictures that are kept at once: the one that is shown, the next, and the one that a window still reads;
/// with rounds of paths another that is being made.
constexpr std::size_t kKeptPictures = 3, kKeptRounds = 1;

std::size_t ramForPictures(const ViewSessionOptions& options, bool withStills) {
    return withStills ? options.ramBytes / 2 - options.ramBytes / kSliceParts
                      : options.ramBytes - 2 * (options.ramBytes / kTightParts);
}

std::size_t shownBytes(const Scene& scene) {
    return (kKeptPictures + (scene.lighting.transport ? kKeptRounds : 0)) *
           (sizeof(glm::vec4) + sizeof(std::uint32_t)) * rayCount(scene.imageSize);
}

/// What it takes to save one of them, or a figure of it and those of other viewings.
std::size_t savingBytes(const Scene& scene, std::size_t panels) {
    constexpr std::size_t kWords = 4; // strips of words, and what lies between panels: a part of the figure
    const std::size_t figure = panels * rayCount(scene.imageSize);
    return kPictureBytesPerPixel * (panels > 1 ? figure + figure / kWords : figure);
}

/// The minimum memory for successive pictures of a scene.
std::size_t ramFloor(const VolumeInfo& info, const Scene& scene, std::size_t panels) {
    return shownBytes(scene) + savingBytes(scene, panels) +
           renderFloorBytes(info, scene.imageSize, kPictureBytesPerPixel, 0, scene.quality.integrator);
}

/// Statistics are far away, or so many that they take a good part of a second.
bool isSlowToOpen(const StoreReader& store) {
    constexpr std::uint64_t kVoxels = std::uint64_t{1} << 30;
    return isAddress(store.path()) || store.info().voxelCount() >= kVoxels;
}

} // namespace

OpenVolume::OpenVolume(const ViewSessionOptions& sessionOptions, const std::filesystem::path& named,
                       bool withStills)
    : options(sessionOptions), path(named), stills(withStills),
      ram("RAM", "--ram", ramForPictures(options, withStills)),
      gpu("GPU memory", "--gpu-memory", options.gpuBytes / (withStills ? 2 : 1)),
      sliceRam("RAM", "--ram", options.ramBytes / (withStills ? kSliceParts : kTightParts)),
      stillRam("RAM", "--ram", options.ramBytes / (withStills ? 2 : kTightParts)),
      stillGpu("GPU memory", "--gpu-memory", withStills ? options.gpuBytes / 2 : 0) {}

std::unique_ptr<OpenVolume> OpenVolume::open(const ViewSessionOptions& options,
                                             const std::filesystem::path& path, const InputOptions& input,
                                             const glm::ivec2& pictureSize,
                                             const std::shared_ptr<Progress>& progress,
                                             const std::optional<int>& level) {
    std::unique_ptr<OpenVolume> next(new OpenVolume(options, path, true));
    Scene scene = sceneOf(path);
    applySets(options.sets, scene);
    if (options.setOwn && path == options.own)
        options.setOwn(scene);
    if (const auto* const view = std::get_if<FittedView>(&scene.camera))
        next->fitted = *view;
    else
        scene.camera = heldBy(std::get<Camera>(scene.camera), scene.imageSize, pictureSize);
    scene.imageSize = pictureSize;
    if (!scene.quality.pixels.named)
        scene.quality.pixels.samples = PixelSampling::kAutomatic, scene.quality.pixels.named = true;
    CommonOptions common = options.common;
    common.progress = progress;
    // The scene keeps the source, and what of it: saved, it opens again when the cache is gone.
    SceneVolume& volume = scene.volumes.front();
    if (input != SourceChoice{} && !looksLikeStore(volume.path)) // a store may be dropped later
        volume.source = input;
    InputOptions chosen(volume.source);
    if (level)
        chosen.fileLevel = level;
    const std::filesystem::path store = storeFor(volume, chosen, next->ram, common);
    volume.path = keptPlace(volume.path);
    progress->stage("opening " + shownName(path));
    next->store = std::make_unique<StoreReader>(store, next->ram, volume.transform);
    const std::size_t least = ramFloor(next->store->info(), scene, options.savedPanels);
    if (next->ram.limitBytes() < least && ramForPictures(options, false) >= least) {
        const std::optional<FittedView> fitted = next->fitted;
        next.reset(new OpenVolume(options, path, false));
        next->fitted = fitted;
        next->store = std::make_unique<StoreReader>(store, next->ram, volume.transform);
    }
    next->further = openFurtherVolumes(scene, next->ram, common, Damage::isRefused);
    faceThinVolume(scene, next->store->info(), false);
    nameFunction(scene, 0, next->store->info());
    next->labels = next->openLabels(volume.labels, common);
    next->scene = std::move(scene);
    return next;
}

void OpenVolume::takeLook(const OpenVolume& other, const std::shared_ptr<Progress>& progress) {
    CommonOptions common = options.common;
    common.progress = progress;
    const glm::dmat4 toThis =
        glm::inverse(store->info().patientFromVoxel) * other.store->info().patientFromVoxel;
    const SourceChoice source = scene.volumes.front().source;
    scene = other.scene;
    scene.volumes.front().source = source;
    phases = other.phases;
    for (Cuts* const cuts : {&scene.cuts, &scene.volumes.front().cuts})
        for (CropBox& box : cuts->boxes)
            if (box.space == CropBox::Space::voxels) {
                box.low = glm::dvec3(toThis * glm::dvec4(box.low, 1));
                box.high = glm::dvec3(toThis * glm::dvec4(box.high, 1));
            }
    labels = openLabels(scene.volumes.front().labels, common);
    fitted.reset(); // the camera stays
}

/// Imports and lists them; null: none are named.
std::unique_ptr<VolumeLabels> OpenVolume::openLabels(Labels& named, const CommonOptions& common) {
    if (named.path.empty())
        return nullptr;
    for (std::filesystem::path* const file : {&named.path, &named.names}) // a saved scene opens from anywhere
        if (!file->empty() && *file != Labels::kTotalSegmentator)
            *file = keptPlace(*file);
    importLabelsFor(store->info(), named, ram, common);
    return std::make_unique<VolumeLabels>(named, ram);
}

OpenVolume::Labelled OpenVolume::labelled(const std::filesystem::path& file,
                                          const std::shared_ptr<Progress>& progress) {
    CommonOptions common = options.common;
    common.progress = progress;
    Labelled with{scene, nullptr};
    Labels& named = with.scene.volumes.front().labels;
    named = {};
    named.path = file;
    named.sameFrame = options.anyFrame;
    with.labels = openLabels(named, common);
    return with;
}

void OpenVolume::makeRenderer(const Scene& wanted, PlanDetail detail) {
    renderer.reset();
    engine.reset();
    pictures = {};
    meshes = {};
    environment = {};
    Scene drawn = wanted;
    for (SceneMesh& mesh : drawn.meshes)
        mesh.sameFrame = mesh.sameFrame || (options.anyFrame && !mesh.path.empty());
    adoptShapes(scene.meshes, drawn);
    meshes = readMeshesApart(drawn, framesOfPicture(drawn, storesOf(*store, further)), ram);
    if (auto& sky = drawn.lighting.environment;
        sky && scene.lighting.environment && sky->file == scene.lighting.environment->file)
        sky->file.map = scene.lighting.environment->file.map;
    std::vector<std::string> notes;
    environment = readEnvironmentOf(drawn, ram, notes);
    const std::size_t saving = savingBytes(wanted, options.savedPanels);
    pictures = ram.charge(shownBytes(wanted) + saving, "the pictures that a window shows");
    savingRam = std::make_shared<MemoryBudget>("RAM", "--ram", saving);
    RenderOptions render;
    render.engine = options.engine;
    render.device = options.device;
    render.threads = options.threads;
    InteractiveOptions interactive;
    interactive.threads = options.threads;
    interactive.coarse = detail == PlanDetail::coarse && isSlowToOpen(*store);
    const std::vector<const StoreReader*> stores = storesOf(*store, further);
    firstAlone.clear();
    try {
        engine = makeEngine(withoutPaths(drawn), stores, render, ram, gpu);
        renderer = std::make_unique<InteractiveRenderer>(drawn, stores, *engine, ram, gpu, interactive);
    } catch (const InputError& e) {
        if (stores.size() == 1 && !hasLabelOptics(drawn))
            throw;
        firstAlone = e.what();
        engine.reset(); // it may hold a plan that is gone
        engine = makeEngine(render, ram, gpu);
        interactive.firstAlone = true;
        renderer = std::make_unique<InteractiveRenderer>(drawn, stores, *engine, ram, gpu, interactive);
    }
    scene = std::move(drawn);
    scene.camera = renderer->camera();
}

std::shared_ptr<VolumeSeen> OpenVolume::describe() {
    const VolumeInfo& info = store->info();
    auto seen = std::make_shared<VolumeSeen>();
    seen->path = isAddress(path) ? keptPlace(path) : path;
    seen->info = info;
    if (const std::string& unit = scene.volumes.front().unit; !unit.empty())
        seen->info.unit = unit;
    seen->values = renderer->valuesOf(0);
    seen->fitted = fitted;
    if (labels)
        seen->labels = std::make_shared<const LabelList>(labels->list());
    seen->eitherFile = eitherFile;
    seen->phases = phases.labels;
    seen->phase = phases.phase;
    for (std::size_t n = 0; n < renderer->sceneVolumes(); ++n) {
        TransferChoice& function = scene.volumes[n].transferFunction;
        function = renderer->functionOf(function, n);
        const std::string& unit = scene.volumes[n].unit;
        seen->volumes.push_back(
            {renderer->valuesOf(n), unit.empty() ? renderer->volume(n).info().unit : unit});
    }
    seen->scene = scene;
    try {
        seen->histogram =
            volumeHistogram(renderer->volume(), seen->lowest(), seen->highest(), kHistogramBinsSeen);
    } catch (const Error&) { // damaged: told when it is drawn
        seen->histogram = withoutFills(seen->values).histogram;
    }
    return seen;
}

std::vector<std::uint32_t> OpenVolume::labelsAt(const glm::dvec3& voxel) {
    if (!labels)
        return {};
    if (const DrawnLabels* const drawn = renderer->volume().labels.get())
        return labels->at(drawn->volume().voxels(), voxel);
    return labels->at(StoreReader(scene.volumes.front().labels.store, ram), voxel); // not drawn in this mode
}

ViewingState OpenVolume::usage() const {
    ViewingState s;
    s.ramUsed = ram.usedBytes() + sliceRam.usedBytes() + stillRam.usedBytes(), s.ramLimit = options.ramBytes;
    s.gpuUsed = gpu.usedBytes() + stillGpu.usedBytes(), s.gpuLimit = options.gpuBytes;
    s.finestLevel = kLevelCount - 1;
    for (std::size_t n = 0; n < renderer->drawnVolumes(); ++n) {
        const InteractiveVolume& volume = renderer->drawn(n);
        const Selection& has = volume.resident();
        s.bricks += has.levels.size();
        s.bricksShown += has.shownBricks();
        if (const auto& wanted = volume.wanted())
            for (std::size_t b = 0; b < has.levels.size(); ++b)
                s.bricksAsWanted += has.levels[b] != Selection::kEmpty && has.levels[b] <= wanted->levels[b];
        for (int level = kLevelCount - 1; level >= 0; --level)
            if (has.counts[static_cast<std::size_t>(level)] > 0)
                s.finestLevel = std::min(s.finestLevel, level),
                s.coarsestLevel = std::max(s.coarsestLevel, level);
        const BrickCache::Counters counters = volume.plan().layer().cache->counters();
        s.chunksThere += counters.hits;
        s.chunksMissed += counters.joins + counters.misses;
    }
    s.drawingStill = still != nullptr;
    s.firstAlone = firstAlone;
    s.noStills = options.stills && !stills;
    return s;
}

} // namespace tessera
