// viewer/cli/input/named_scene.cpp: see named_scene.h.
#include "viewer/cli/input/named_scene.h"

#include "core/base/error.h"
#include "core/base/json_reader.h"
#include "core/scene/preset.h"
#include "core/scene/scene_presets.h" // overShares

#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>

namespace tessera {
namespace {

/// The patient axis that a view looks along: 0 left-right, 1 front-back, 2 head-feet.
int axisOf(View view) {
    switch (view) {
    case View::left:
    case View::right:
        return 0;
    case View::anterior:
    case View::posterior:
        return 1;
    default:
        return 2;
    }
}

constexpr View kFacing[] = {View::left, View::anterior, View::superior}; // the slice of each axis

/// The patient axis along which a volume has a single slice; none where it has several slices along every
/// axis, or a single one along several.
std::optional<int> thinAxisOf(const VolumeInfo& info) {
    int thin = -1, thinAxes = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (info.extentVoxels[axis] == 1)
            thin = axis, ++thinAxes;
    return thinAxes == 1 ? std::optional(thin) : std::nullopt;
}

/// The plane of the slice, by name where it lies along the patient's axes.
SlicePlane planeOf(const VolumeInfo& info, int thin) {
    constexpr double kAlong = 1 - 1e-6; // cosine
    constexpr Orientation kNames[] = {Orientation::sagittal, Orientation::coronal, Orientation::axial};
    const auto step = [&](int axis) { return glm::dvec3(info.patientFromVoxel[axis]); };
    glm::dvec3 normal = glm::normalize(glm::cross(step((thin + 1) % 3), step((thin + 2) % 3)));
    SlicePlane plane;
    plane.orientation = kNames[thin];
    if (std::abs(normal[thin]) > kAlong)
        return plane;
    // Seen from the same side as the plane along the axes: from the feet, the front or the patient's left.
    if ((normal[thin] > 0) != (thin == 0))
        normal = -normal;
    plane.orientation = Orientation::oblique;
    plane.normal = normal;
    plane.point = glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1));
    return plane;
}

} // namespace

bool isOneSlice(const VolumeInfo& info) {
    return thinAxisOf(info).has_value();
}

bool facesThinVolume(const Scene& scene, bool sideNamed) {
    const auto* const fitted = std::get_if<FittedView>(&scene.camera);
    return fitted && !fitted->named && scene.mode == Mode::composite && !sideNamed;
}

std::string faceThinVolume(Scene& scene, const VolumeInfo& info, bool sideNamed) {
    auto* fitted = std::get_if<FittedView>(&scene.camera);
    const std::optional<int> thin = thinAxisOf(info);
    if (!fitted || fitted->named || !thin || scene.mode == Mode::slice)
        return "";
    if (scene.mode != Mode::composite || sideNamed) {
        fitted->view = kFacing[*thin];
        return "one slice: seen from the side that it faces, --view " +
               viewNames()[static_cast<std::size_t>(fitted->view)];
    }
    scene.mode = Mode::slice;
    const SlicePlane slab = scene.slice;
    scene.slice = planeOf(info, *thin);
    scene.slice.thicknessMm = slab.thicknessMm, scene.slice.reduction = slab.reduction;
    return "one slice: shown as --slice " +
           orientationNames()[static_cast<std::size_t>(scene.slice.orientation)] +
           "; --view draws it as a volume";
}

void requireFacingView(const Scene& scene, const VolumeInfo& info, const std::string& where) {
    const auto* fitted = std::get_if<FittedView>(&scene.camera);
    const std::optional<int> thin = thinAxisOf(info);
    if (!fitted || (scene.mode == Mode::slice && !fitted->named) || !thin)
        return;
    const bool bySide = !fitted->angles && !fitted->axes;
    if (bySide ? axisOf(fitted->view) == *thin : axesOf(*fitted).towards[*thin] != 0)
        return;
    throw badFile(where, "several slices to be drawn from the side",
                  "one slice, which is a line from there; --view " +
                      viewNames()[static_cast<std::size_t>(kFacing[*thin])] + " faces it");
}

Scene sceneOf(const std::filesystem::path& path) {
    if (isSceneFile(path))
        return loadScene(path);
    Scene scene;
    scene.quality.automaticStep = true;
    scene.volumes.push_back({path, std::string()});
    scene.volumes.back().hideTable = HideTable::automatic;
    return scene;
}

Scene styleOf(const std::filesystem::path& path) {
    Scene unnamed = sceneOf("volume");
    unnamed.volumes.front().path.clear();
    if (path.empty())
        return unnamed;
    if (!isSceneFile(path))
        return sceneOf(path);
    nlohmann::json document = parseStrictJson(readTextFile(path.string()), path.string());
    if (!document.is_object() || document.contains("volumes"))
        return sceneOf(path);
    document["volumes"] = {{{"path", "/volume"}}};
    Scene scene = parseScene(document.dump(), path.parent_path(), path.string());
    scene.volumes = unnamed.volumes;
    return scene;
}

void nameFunction(SceneVolume& volume, const VolumeInfo& info) {
    if (const auto* name = std::get_if<std::string>(&volume.transferFunction); name && name->empty())
        volume.transferFunction = std::string(info.unit == "HU" || volume.unit == "HU" ? "bone-1" : "auto");
}

void nameFunction(Scene& scene, std::size_t volume, const VolumeInfo& info) {
    SceneVolume& named = scene.volumes.at(volume);
    nameFunction(named, info);
    const auto* const name = std::get_if<std::string>(&named.transferFunction);
    if (name && *name != "auto" && !showsFunction(scene, volume) && info.unit != "HU" && named.unit != "HU" &&
        !overShares(builtInPreset(*name)))
        named.transferFunction = std::string("auto");
}

bool showsFunction(const Scene& scene, std::size_t volume) {
    const Reduction reduction = reductionOf(scene);
    if (reduction == Reduction::composite || reduction == Reduction::sum)
        return scene.mode != Mode::radiograph;
    return scene.volumes.at(volume).valueColour.value_or(scene.valueColour) == ValueColour::transferFunction;
}

} // namespace tessera
