// viewer/cli/render/scene_from_arguments.cpp: see scene_from_arguments.h.
#include "viewer/cli/render/scene_from_arguments.h"

#include "bricking/analysis/body/body_box.h"
#include "bricking/statistics/statistics.h"
#include "core/base/address.h"
#include "core/base/decimal.h"
#include "core/base/error.h"
#include "core/base/magnitude.h"
#include "core/base/names.h"
#include "core/scene/preset.h"
#include "core/scene/slice_view.h"
#include "render/plan/frame_plan.h" // summarise
#include "viewer/cli/input/named_scene.h"
#include "viewer/cli/options/camera_words.h"
#include "viewer/cli/options/scene_words.h"
#include "viewer/cli/render/picture_notes.h"
#include "viewer/session/file_kind.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tessera {
namespace {

/// "300", "300:ivory" or "300:#eeddcc:0.5".
Isosurface parseSurface(const std::string& text) {
    const auto refuse = [&] {
        return badFile("--isosurface", "VALUE, VALUE:COLOUR or VALUE:COLOUR:OPACITY (0 to 1)",
                       "\"" + text.substr(0, 40) + "\"");
    };
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, ':');)
        parts.push_back(part);
    const auto number = [&](const std::string& word) {
        const std::optional<double> value = decimalNumber(word);
        if (!value)
            throw refuse();
        return *value;
    };
    if (parts.empty() || parts.size() > 3 || text.back() == ':')
        throw refuse();
    Isosurface surface{number(parts[0])};
    checkValue(surface.value, "a value", "--isosurface");
    if (parts.size() > 1) {
        surface.colour = glm::dvec3(parseColour(parts[1], "--isosurface"));
    }
    if (parts.size() > 2)
        surface.opacity = number(parts[2]);
    if (!(surface.opacity >= 0 && surface.opacity <= 1))
        throw refuse();
    return surface;
}

/// The value of an option for the n-th mesh; null: it was not given.
const std::string* ofMesh(const std::vector<std::string>& values, std::size_t n) {
    return values.empty() ? nullptr : &values[std::min(n, values.size() - 1)];
}

/// Adds the files of --mesh.
void addMeshes(const RenderArguments& arguments, Scene& scene) {
    const std::size_t count = arguments.meshes.size();
    for (const auto& [values, option] : {std::pair{&arguments.meshColours, "--mesh-colour"},
                                         std::pair{&arguments.meshOpacities, "--mesh-opacity"}})
        if (values->size() > count)
            throw badFile(option, "at most one for each --mesh", std::to_string(values->size()));
    if (count == 0 && !arguments.meshSpace.empty())
        throw badFile("--mesh-space", "a mesh (--mesh)", "none");
    bool hasStructures = false;
    for (std::size_t n = 0; n < count; ++n) {
        std::error_code ignored;
        if (!isAddress(arguments.meshes[n]) &&
            !std::filesystem::is_regular_file(arguments.meshes[n], ignored))
            throw badFile("--mesh", "a file of triangles", "\"" + arguments.meshes[n].substr(0, 200) + "\"");
        SceneMesh mesh;
        mesh.path = absolutePlace({}, arguments.meshes[n]);
        if (const std::string* colour = ofMesh(arguments.meshColours, n))
            mesh.colour = glm::dvec3(parseColour(*colour, "--mesh-colour"));
        if (const std::string* opacity = ofMesh(arguments.meshOpacities, n)) {
            char* end = nullptr;
            mesh.opacity = std::strtod(opacity->c_str(), &end);
            if (opacity->empty() || *end != '\0' || !(mesh.opacity >= 0 && mesh.opacity <= 1))
                throw badFile("--mesh-opacity", "a number from 0 to 1", "\"" + opacity->substr(0, 40) + "\"");
        }
        if (!arguments.meshSpace.empty())
            mesh.space = parseName<MeshSpace>(arguments.meshSpace, "--mesh-space");
        if (!arguments.meshContours.empty() && (isAddress(mesh.path) || meansStructureSet(mesh.path))) {
            mesh.contours = parseName<ContourStyle>(arguments.meshContours, "--mesh-contours");
            hasStructures = true;
        }
        scene.meshes.push_back(std::move(mesh));
    }
    if (!arguments.meshContours.empty() && !hasStructures)
        throw badFile("--mesh-contours", "a DICOM structure set (--mesh)", "none");
    if (scene.meshes.size() > SceneMesh::kMost)
        throw badFile("--mesh", "at most " + std::to_string(SceneMesh::kMost) + " meshes",
                      std::to_string(scene.meshes.size()));
}

/// Applies a preset: its function and its settings of light, mode and cuts.
/// @param option  that names it
void applyNamedPreset(const std::string& text, const std::string& option, Scene& scene,
                      const CommonOptions& common) {
    std::vector<std::string> leftOut;
    setByWord(scene, "preset", text, option, &leftOut);
    for (const std::string& what : leftOut)
        common.note(text + ": left out: " + what);
}

/// The function of a preset of labels: a name stays a name, so that it suits the volume's values.
TransferChoice functionOf(const std::string& preset, const CommonOptions& common) {
    Scene alone = sceneOf("volume");
    applyNamedPreset(preset, "--label-preset", alone, common);
    return alone.volumes.front().transferFunction;
}

/// "LABELS=PRESET", LABELS as for --show.
void addLabelPreset(const std::string& text, Labels& labels, const CommonOptions& common) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
        throw badFile("--label-preset", "LABELS=PRESET, such as liver=vessels", "\"" + text + "\"");
    if (labels.path.empty())
        throw badFile("--label-preset", "labels beside the volume (--labels)", "none");
    const TransferChoice function = functionOf(text.substr(equals + 1), common);
    std::istringstream names(text.substr(0, equals));
    for (std::string one; std::getline(names, one, ',');)
        if (!one.empty())
            labels.each.push_back({.of = one, .transferFunction = function});
    if (labels.each.size() > Labels::kMostPatterns)
        throw badFile("--label-preset", "at most " + std::to_string(Labels::kMostPatterns) + " labels",
                      "more");
}

/// A volume of --add.
/// @param preset  "": by its values
SceneVolume furtherVolume(const std::string& path, const std::string& preset, const CommonOptions& common) {
    Scene alone = sceneOf(path);
    if (isSceneFile(path))
        throw badFile("--add", "a volume", "a scene");
    if (!preset.empty())
        applyNamedPreset(preset, "--add-preset", alone, common);
    SceneVolume& volume = alone.volumes.front();
    if (!preset.empty()) {
        volume.valueColour = alone.valueColour;
        volume.window = alone.window;
    }
    return volume;
}

} // namespace

EngineKind engineOf(const RenderArguments& arguments) {
    const std::string name = arguments.engine == "march" ? "gpu" : arguments.engine; // its name before
    return engineNamed(name, "--engine");
}

Verify verifyOf(const RenderArguments& arguments) {
    const std::vector<std::string>& names = verifyNames();
    if (arguments.noCheck && !arguments.verify.empty() && arguments.verify != names.front())
        throw badFile("--no-check", "--verify or --no-check, which is --verify none", "both");
    if (arguments.noCheck)
        return Verify::none;
    if (arguments.verify.empty()) // for films the error of each frame is not reported
        return arguments.path.empty() && !arguments.isFilm() ? Verify::quick : Verify::none;
    const auto at = std::find(names.begin(), names.end(), arguments.verify);
    if (at == names.end())
        throw badFile("--verify", joinNames(names), "\"" + arguments.verify.substr(0, 40) + "\"");
    return static_cast<Verify>(at - names.begin());
}

namespace {

/// A slice is seen from a side that faces it. An option's side must; the scene's own does not count, and this
/// is told.
void faceSlice(const RenderArguments& arguments, Scene& scene, const CommonOptions& common) {
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    if (!view || !isSeenFromEdge(scene))
        return;
    const std::string side = view->angles ? "at angles" : std::string(nameOf(view->view));
    if (!arguments.view.empty() || arguments.keys.says("camera.view"))
        throw badFile(arguments.view.empty() ? "--set camera.view" : "--view", "a side that faces the slice",
                      side + ", which sees its edge");
    common.note("the scene's side, " + side +
                ", sees the edge of the slice, which is shown along its normal");
    scene.camera = FittedView{};
}

} // namespace

void applyArguments(const RenderArguments& arguments, Scene& scene, const CommonOptions& common) {
    if (!arguments.preset.empty())
        applyNamedPreset(arguments.preset, "--preset", scene, common);
    if (!arguments.light.empty()) // wins over the preset's
        setByWord(scene, "light", arguments.light, "--light");
    if (arguments.addPresets.size() > arguments.add.size())
        throw badFile("--add-preset", "at most one for each --add",
                      std::to_string(arguments.addPresets.size()));
    for (std::size_t n = 0; n < arguments.add.size(); ++n)
        scene.volumes.push_back(furtherVolume(
            arguments.add[n], n < arguments.addPresets.size() ? arguments.addPresets[n] : "", common));
    if (scene.volumes.size() > Scene::kMaxVolumes)
        throw badFile("--add", "at most " + std::to_string(Scene::kMaxVolumes) + " volumes in a picture",
                      std::to_string(scene.volumes.size()));
    arguments.keys.apply(scene);
    if (!arguments.keys.textOf("--hide-table").empty())
        for (SceneVolume& volume : scene.volumes)
            volume.hideTable = scene.volumes.front().hideTable;
    for (const std::string& text : arguments.labelPresets)
        addLabelPreset(text, scene.volumes.front().labels, common);
    if (!arguments.view.empty()) {
        FittedView view;
        if (const auto* before = std::get_if<FittedView>(&scene.camera))
            view = *before;
        parseSide(arguments.view, view, "--view");
        view.named = true;
        scene.camera = view;
    }
    if (arguments.reforms()) { // values of places, as slices show them
        if (arguments.keys.says("mode") && scene.mode != Mode::slice)
            throw badFile("--mode", "slice, or none, with " + arguments.pathPicture(), nameOf(scene.mode));
        scene.mode = Mode::slice;
    }
    applyModeOptions(arguments.mode, arguments.keys, scene);
    if (const auto refusal = refusalByMode(arguments.mode, arguments.keys, scene);
        refusal && (!arguments.path.empty() || !facesThinVolume(scene, arguments.isSideNamed())))
        throw *refusal; // else once the volume is known
    if (!arguments.mode.slice.empty() && isSeenFromEdge(scene)) {
        if (!arguments.view.empty())
            throw badFile("--view", "a side that faces the slice", arguments.view + ", which sees its edge");
        scene.camera = FittedView{}; // the file's is of another picture
    }
    if (!arguments.fit.empty())
        setFit(scene, arguments.fit, "--fit");
    if (!arguments.projection.empty())
        setProjection(scene, arguments.projection, "--projection");
    if (arguments.mmPerPixel > 0 && !arguments.reforms())
        setScale(scene, arguments.mmPerPixel, arguments.projection.empty(), "--mm-per-pixel");
    if (!arguments.keys.textOf("--step").empty() && !arguments.keys.textOf("--max-error").empty() &&
        scene.quality.maxError > 0)
        throw badFile("--step", "--step or --max-error, which chooses a step", "both");
    for (const std::string& text : arguments.surfaces)
        scene.surfaces.push_back(parseSurface(text));
    if (scene.surfaces.size() > Scene::kMaxSurfaces)
        throw badFile("--isosurface", "at most " + std::to_string(Scene::kMaxSurfaces) + " isosurfaces",
                      std::to_string(scene.surfaces.size()));
    addMeshes(arguments, scene);
    if (arguments.keys.takesAnyFrame()) // of the meshes, too
        takeAnyFrame(scene);
    arguments.keys.applySets(scene);
    faceSlice(arguments, scene, common);
    arguments.keys.checkFrames(scene);
    PixelSampling& pixels = scene.quality.pixels;
    if (!pixels.named) {
        const EngineKind engine = engineOf(arguments);
        if (pixels.noise > 0)
            pixels.samples = PixelSampling::kMostForNoise;
        else if (scene.lighting.transport)
            pixels.samples = Transport::kSamples;
        else if (engine == EngineKind::automatic || !traitsOf(engine).singleRays)
            pixels.samples = PixelSampling::kAutomatic;
    }
    pixels.named = true; // so that the manifest's scene is the picture's
}

bool inHu(const StoreReader& store, const std::string& unit, MemoryBudget& ram) {
    if (store.info().unit == "HU" || unit == "HU")
        return true;
    return looksLikeHu(summarise(loadStatistics(store, ram, 0), store.info(), unit));
}

namespace {

std::string along(const char* axis, double low, double high) {
    return std::string(axis) + " " + formatNumber(low) + " to " + formatNumber(high);
}

} // namespace

void cropToBody(const RenderArguments& arguments, Stores stores, Scene& scene, MemoryBudget& ram,
                const CommonOptions& common) {
    std::optional<BodyBox> all;
    std::string bodies;
    std::exception_ptr none;
    for (std::size_t n = 0; n < stores.size(); ++n) {
        const SceneVolume& volume = scene.volumes[n];
        const int cut = arguments.mode.cutVolume;
        const bool counts =
            cut >= 0 ? n == static_cast<std::size_t>(cut) : stores.size() == 1 || volume.opacity > 0;
        if (!counts || !inHu(*stores[n], volume.unit, ram))
            continue;
        BodyBox found;
        try {
            found = findBody(*stores[n], ram);
        } catch (const InputError&) { // another volume may have one
            none = none ? none : std::current_exception();
            continue;
        }
        bodies += (all ? "; " : "") + ("a body of " + formatNumber(found.litres, 3)) + " l; " +
                  formatNumber(found.litresLeftOut, 3) + " l of table and the like left out";
        if (!all)
            all = found;
        all->low = glm::min(all->low, found.low), all->high = glm::max(all->high, found.high);
    }
    if (!all && none)
        std::rethrow_exception(none);
    if (!all)
        throw badFile("--crop body", "values in HU, by which a body is found",
                      "values without a unit that do not look like HU; --unit HU takes them for HU");
    const BodyBox& body = *all;
    const Keep keep = arguments.mode.keep == "outside" ? Keep::outside : Keep::inside;
    std::vector<CropBox>& boxes = cutsOf(arguments.mode, scene).boxes;
    boxes.push_back({body.low, body.high, CropBox::Space::patient, keep});
    if (boxes.size() > Cuts::kMostOfAKind)
        throw badFile("--crop", "at most " + std::to_string(Cuts::kMostOfAKind) + " of a kind", "more");
    if (auto* fitted = std::get_if<FittedView>(&scene.camera); fitted && arguments.fit.empty())
        fitted->fit = fitted->fit == Fit::shown ? Fit::kept : fitted->fit;
    common.note("--crop body: " + along("x", body.low.x, body.high.x) + ", " +
                along("y", body.low.y, body.high.y) + ", " + along("z", body.low.z, body.high.z) +
                " mm: " + bodies);
}

} // namespace tessera
