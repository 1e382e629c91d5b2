// viewer/cli/render/run_render.cpp: see run_render.h.
#include "viewer/cli/render/run_render.h"

#include "bricking/store/store_reader.h"
#include "core/animation/flight.h"
#include "core/animation/path.h"
#include "core/base/address.h"
#include "core/base/budget_error.h"
#include "core/base/error.h"
#include "render/geometry/mesh_caster.h" // meshBytesPerPixel
#include "render/picture/render_scene.h"
#include "render/plan/frame_plan.h" // renderFloorBytes
#include "render/plan/label_optics.h"
#include "viewer/annotations/figure_file.h"
#include "viewer/cli/input/environment_input.h"
#include "viewer/cli/input/further_volumes.h"
#include "viewer/cli/input/label_input.h"
#include "viewer/cli/input/mesh_input.h"
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/input/phase_input.h"
#include "viewer/cli/input/remote_input.h"
#include "viewer/cli/input/volume_input.h"
#include "viewer/cli/render/along_path.h"
#include "viewer/cli/render/asked_options.h"
#include "viewer/cli/render/kept_state.h"
#include "viewer/cli/render/layers.h"
#include "viewer/cli/render/one_picture.h"
#include "viewer/cli/render/panel_figure.h"
#include "viewer/cli/render/picture_files.h"
#include "viewer/cli/render/picture_notes.h"
#include "viewer/cli/render/ranked_picture.h"
#include "viewer/cli/render/reformed_line.h"
#include "viewer/cli/render/scene_from_arguments.h"
#include "viewer/cli/render/tiled_picture.h"

#include <algorithm>
#include <functional>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Refuses a budget that is too small even for reading the store. The message names the minimum of the scene,
/// not only of the reader.
/// @param together  pixels that are drawn together
/// @param threads  that draw; 0: all processors
void requireFloor(const fs::path& path, const Scene& scene, const glm::ivec2& together, EngineKind engine,
                  int threads, const MemoryBudget& ram) {
    constexpr std::size_t kReaderBytes = std::size_t{4} << 20; // enough for the reader of any store
    if (ram.limitBytes() >= kReaderBytes)
        return;
    MemoryBudget trial(ram.name(), ram.option(), kReaderBytes);
    const VolumeInfo info = StoreReader(path, trial).info();
    const std::size_t floor = renderFloorBytes(
        info, together, pictureBytesPerPixel(engine, scene.quality.pixels) + meshBytesPerPixel(scene),
        threads);
    if (ram.limitBytes() < floor)
        throw OverBudget(ram.option() + ": this scene needs at least " + formatBytes(floor) +
                         ", but the budget is " + formatBytes(ram.limitBytes()));
}

/// Without requested samples, pixels get one ray if RAM is too small for sums of samples.
void fitSamples(const VolumeInfo& info, const glm::ivec2& together, EngineKind engine, int threads,
                const MemoryBudget& ram, Scene& scene, const CommonOptions& common) {
    const auto floor = [&] {
        return renderFloorBytes(info, together,
                                pictureBytesPerPixel(engine, scene.quality.pixels) + meshBytesPerPixel(scene),
                                threads, scene.quality.integrator);
    };
    PixelSampling& pixels = scene.quality.pixels;
    if (pixels.denoise || ram.limitBytes() >= floor()) // a filter needs samples
        return;
    const PixelSampling asked = pixels;
    const std::size_t wanted = floor();
    pixels.samples = 1;
    if (ram.limitBytes() < floor())
        pixels = asked; // samples are not the cause
    else
        common.note("--ram has no room for more than one ray per pixel: " + formatBytes(ram.limitBytes()) +
                    " of " + formatBytes(wanted));
}

/// Of tiles without requested samples, for which all pixels of a picture would share its rays. True if there
/// are other samples now.
bool takesSingleRays(const RenderArguments& arguments, bool samplesNamed, Scene& scene) {
    PixelSampling& pixels = scene.quality.pixels;
    if (arguments.tiles == 0 || samplesNamed || pixels.samples != PixelSampling::kAutomatic)
        return false;
    pixels.samples = 1;
    return true;
}

/// The default functions show bones and organs from outside. If no function was named, the lumen's wall is
/// shown.
void showWallWhereNothingIsNamed(const RenderArguments& arguments, const Path& path, Scene& scene,
                                 const CommonOptions& common) {
    const auto* function = std::get_if<std::string>(&scene.volumes.front().transferFunction);
    const bool named = !function || !function->empty() || !scene.surfaces.empty() ||
                       scene.mode != Mode::composite || arguments.keys.says("mode");
    if (!named && showsWallByDefault(path) && showLumenWall(*path.lumen, scene))
        common.note("the lumen's wall, at " + formatNumber(path.lumen->shownAt()) +
                    "; --preset, --isosurface and --mode show other things");
}

/// Refuses to unfold a leaking lumen: its wall takes long to draw and shows nothing useful.
void refuseLeaks(const RenderArguments& arguments, const Path& path) {
    if (arguments.unfold && path.lumen && path.lumen->leaks && !arguments.mayLeak)
        throw badFile(arguments.path, "a path whose lumen does not leak, or --may-leak with --unfold",
                      "one whose lumen leaks (\"lumen\", \"leaks\"): " + doubtText(*path.lumen));
}

/// False: no volume there is a single slice, by the headers of source files. Stores are opened soon.
bool mayBeOneSlice(const fs::path& path, const SourceChoice& choice) {
    return isAddress(path) || looksLikeStore(path) ||
           std::ranges::any_of(listInput(path, choice).volumes,
                               [](const ListedVolume& volume) { return isOneSlice(volume.info); });
}

/// @param group  of --ranks; else null
/// @param draw  in place of the arguments' picture or film; empty: that
/// @param take  of one picture; none: its file is written
void renderBy(ProcessGroup* group, const RenderArguments& arguments, const CommonOptions& common,
              const std::function<void(const RenderTask&)>& draw = {}, const TakePicture& take = {}) {
    // Everything that can be refused is refused before the long work.
    checkFilmOptions(arguments);
    std::optional<Path> path;
    if (!arguments.path.empty()) {
        path = readPathOf(arguments);
        refuseLeaks(arguments, *path);
        if (const std::string doubt = path->lumen ? doubtText(*path->lumen) : ""; !doubt.empty())
            common.note(arguments.path + ": " + doubt);
    }
    if (arguments.isFilm())
        checkFilmOutput(arguments.out);
    else if (arguments.unfold || arguments.tiles > 0)
        checkPictureOutput(arguments.out);
    else if (!take)
        checkFigureOutput(arguments.out);
    if (group)
        checkRanks(arguments);
    const EngineKind engine = group ? engineOfRanks(engineOf(arguments)) : engineOf(arguments);
    const auto budget = [&](const std::string& text, const char* option) { // processes plan alike
        const std::size_t bytes = budgetBytes(text, option, common);
        return group ? group->least(bytes) : bytes;
    };
    MemoryBudget ram("RAM", "--ram", budget(arguments.ram, "--ram"));
    MemoryBudget gpu("GPU memory", "--gpu-memory", budget(arguments.gpuMemory, "--gpu-memory"));
    Scene scene = arguments.scene ? *arguments.scene : sceneOf(arguments.in);
    const bool samplesNamed = scene.quality.pixels.named || arguments.keys.says("quality.samples");
    applyArguments(arguments, scene, common);
    const LayerChoice layers = layersOf(arguments, scene);
    const std::string request = requestOf(scene);
    std::vector<SourceChoice> sources;
    for (const SceneVolume& named : scene.volumes)
        sources.push_back(named.source);
    checkKeptState(arguments, scene);
    const bool singleRays = takesSingleRays(arguments, samplesNamed, scene);
    checkTiles(arguments, scene);
    checkAnnotations(scene);
    if (arguments.unfold && scene.annotations.any())
        throw badFile("--unfold", "a picture without annotations", firstAnnotation(scene.annotations));
    if (const Annotations& shown = scene.annotations;
        arguments.reforms() && (shown.directions == Directions::cube || shown.directions == Directions::all ||
                                shown.measurements || !shown.arrows.empty()))
        throw badFile(arguments.pathPicture(),
                      "directions as letters, and no measurements and arrows, for it has no camera",
                      "the cube of directions, measurements or arrows");
    if (singleRays)
        common.note("--tiles: one ray per pixel; --samples takes more");
    const glm::ivec2 together = pixelsTogether(arguments, scene);
    if (path)
        showWallWhereNothingIsNamed(arguments, *path, scene, common);

    std::vector<std::string> notes;
    const Charge environment = readEnvironmentOf(scene, ram, notes);
    for (const std::string& words : notes)
        common.note(words);
    SceneVolume& volume = scene.volumes.front();
    if (scene.volumes.size() > 1 && !arguments.pathPicture().empty())
        throw badFile(arguments.pathPicture(), "a scene of one volume", std::to_string(scene.volumes.size()));
    if (arguments.unfold && hasLabelOptics(scene))
        throw badFile("--unfold", "labels without functions or materials of their own", "some with");
    const bool isStoreNamed = looksLikeStore(volume.path); // an import says so itself
    if (const SourceChoice& chosen = arguments.input; chosen != SourceChoice{})
        sources.front() = chosen;
    if (!arguments.input.allPhases)
        namePhase(scene.annotations, volume.path, sources.front());
    if (const auto refusal = refusalByMode(arguments.mode, arguments.keys, scene);
        refusal && !mayBeOneSlice(volume.path, sources.front()))
        throw *refusal;
    PhaseStores phases;
    if (arguments.input.allPhases) {
        if (scene.volumes.size() > 1 || !volume.labels.path.empty())
            throw badFile("--phase all", "a scene of one volume without labels", "more");
        phases = storesOfPhases(volume, arguments.input, ram, common);
        volume.path = phases.stores.front();
    } else {
        volume.path = storeFor(volume, arguments.input, ram, common);
    }
    volume.source = {};
    requireFloor(volume.path, scene, together, engine, arguments.threads, ram);
    // Kept samples would outlive the damage.
    const Damage damage =
        arguments.allowDamaged && arguments.keepState.empty() ? Damage::isDrawnCoarser : Damage::isRefused;
    const std::unique_ptr<StoreReader> opened = openForPictures(volume.path, ram, volume.transform, damage);
    const StoreReader& store = *opened;
    if (store.info().filePart)
        sources.front().fileLevel = store.info().filePart->level;
    const std::vector<std::unique_ptr<StoreReader>> further = openFurtherVolumes(scene, ram, common, damage);
    const std::vector<const StoreReader*> stores = storesOf(store, further);
    if (const std::string words = apartText(stores); !words.empty())
        common.note(words);
    if (const std::string words = otherFramesText(scene, stores); !words.empty())
        common.note(words);
    if (!samplesNamed && !layers.error && arguments.keepState.empty())
        fitSamples(store.info(), together, engine, arguments.threads, ram, scene, common);
    if (arguments.path.empty()) {
        if (const std::string words = faceThinVolume(scene, store.info(), arguments.isSideNamed());
            !words.empty())
            common.note(words);
        if (const auto refusal = refusalByMode(arguments.mode, arguments.keys, scene))
            throw *refusal;
        requireFacingView(scene, store.info(), arguments.in);
    }
    if (!arguments.reforms())
        requireSliceInVolume(scene, store.info(),
                             arguments.mode.slice.empty() ? arguments.in + ": $.slice" : "--slice");
    nameFunction(scene, 0, store.info());
    importLabelsFor(store.info(), volume.labels, ram, common);
    for (const std::string& words : readMeshes(scene, framesOfPicture(scene, stores), ram))
        common.note(words);
    if (const std::string words = sayLabels(store.info()); !words.empty() && isStoreNamed)
        common.note(words);
    if (arguments.mode.cropsToBody())
        cropToBody(arguments, stores, scene, ram, common);

    RenderOptions options;
    options.engine = engine;
    options.device.text = arguments.device;
    options.threads = arguments.threads;
    options.searching = true;
    options.verify = group ? Verify::none : verifyOf(arguments);
    options.group = group;
    options.checking = options.verify != Verify::none;
    options.layers = {layers.ofPaths(), layers.error};
    const auto open = [&, moved = volume.transform](const fs::path& path) {
        return openForPictures(path, ram, moved, damage);
    };
    RenderTask task{arguments, common,  std::move(scene), store,   stores,  ram,
                    gpu,       options, layers,           request, sources, take};
    task.phases = arguments.input.allPhases ? &phases : nullptr;
    task.open = open;
    if (draw)
        draw(task);
    else if (arguments.unfold)
        renderWall(task);
    else if (arguments.reforms())
        renderReformedLine(task);
    else if (arguments.isFilm())
        renderFilm(task);
    else if (arguments.tiles > 0)
        renderTiledPicture(task);
    else
        renderOnePicture(task);
    sayDamage(task.scene, stores, common);
    if (const std::string words = sayFetched(stores); !words.empty())
        common.detail(words);
}

} // namespace

void withRenderTask(const RenderArguments& arguments, const CommonOptions& common,
                    const std::function<void(const RenderTask&)>& draw) {
    renderBy(nullptr, arguments, common, draw);
}

void runRender(const RenderArguments& arguments, const CommonOptions& common) {
    if (!arguments.panels.empty())
        return renderPanels(arguments, common, withRenderTask);
    if (!arguments.ranks)
        return renderBy(nullptr, arguments, common);
    renderInGroup(common,
                  [&](const CommonOptions& mine, ProcessGroup& group) { renderBy(&group, arguments, mine); });
}

void runRender(const RenderArguments& arguments, const CommonOptions& common, const Scene* scene,
               const TakePicture& take) {
    RenderArguments of = arguments;
    if (scene)
        of.scene = *scene;
    renderBy(nullptr, of, common, {}, take);
}

} // namespace tessera
