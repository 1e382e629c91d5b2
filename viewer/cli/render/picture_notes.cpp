// viewer/cli/render/picture_notes.cpp: see picture_notes.h.
#include "viewer/cli/render/picture_notes.h"

#include "core/base/error.h"
#include "core/scene/preset.h"
#include "core/scene/slice_view.h"
#include "render/picture/render_scene.h"
#include "render/plan/drawn_part.h"
#include "viewer/cli/options/options.h" // formatNumber
#include "viewer/session/label_list.h"  // showsUnlabelled

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <variant>

namespace tessera {
namespace {

/// "z from -400 to -1.5"
std::string rangeAlong(int axis, const VolumeInfo& info) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int n = 0; n < 8; ++n) {
        const glm::dvec3 corner = glm::dvec3(info.extentVoxels) * glm::dvec3(n & 1, (n >> 1) & 1, n >> 2);
        const double at = (info.patientFromVoxel * glm::dvec4(corner, 1))[axis];
        low = std::min(low, at);
        high = std::max(high, at);
    }
    constexpr int kDigits = 6; // micrometres of a metre
    return std::string(1, "xyz"[axis]) + " from " + formatNumber(low, kDigits) + " to " +
           formatNumber(high, kDigits);
}

} // namespace

std::string placeOf(const VolumeInfo& info) {
    return rangeAlong(0, info) + ", " + rangeAlong(1, info) + " and " + rangeAlong(2, info) + " mm";
}

void requireSliceInVolume(const Scene& scene, const VolumeInfo& info, const std::string& where) {
    if (scene.mode != Mode::slice)
        return;
    Scene alone = scene;
    alone.cuts = {};
    for (SceneVolume& volume : alone.volumes)
        volume.cuts = {};
    if (drawnPart(alone, info).meets(glm::dvec3(0), glm::dvec3(info.extentVoxels)))
        return;
    const SlicePlane& slice = scene.slice;
    const std::string name = orientationNames()[static_cast<std::size_t>(slice.orientation)];
    constexpr std::array<int, 3> kAxes = {2, 1, 0}; // in the order of Orientation
    if (slice.orientation == Orientation::oblique)
        throw badFile(where, "a plane that meets the volume, which lies in " + placeOf(info),
                      "one outside it");
    throw badFile(where,
                  "a plane that meets the volume, in " +
                      rangeAlong(kAxes[static_cast<std::size_t>(slice.orientation)], info) + " mm",
                  name + ":" + formatNumber(slice.positionMm.value_or(0), 6));
}

namespace {

/// True if any value of the volume is visible under the transfer function.
bool showsAnything(const TransferChoice& choice, const RenderResult& result) {
    const auto* function = std::get_if<TransferFunction>(&choice);
    if (!function) {
        const std::string& preset = std::get<std::string>(choice);
        if (preset == "auto")
            return result.highest > result.lowest;
        const TransferFunction named = presetFunction(preset, {result.lowest, result.highest, true, 1, {}});
        return showsAnything(named, result);
    }
    if (function->extinction(result.lowest) > 0 || function->extinction(result.highest) > 0)
        return true;
    return std::any_of(function->kinks().begin(), function->kinks().end(), [&](double v) {
        return v >= result.lowest && v <= result.highest && function->extinction(v) > 0;
    });
}

/// True if a surface of the value can lie between the volume's voxels.
bool isAmong(double value, const RenderResult& result) {
    return value >= result.lowest && value <= result.highest;
}
bool hasSurfaceAmong(const std::vector<Isosurface>& surfaces, const RenderResult& result) {
    return std::any_of(surfaces.begin(), surfaces.end(), [&](const Isosurface& surface) {
        return surface.opacity > 0 && isAmong(surface.value, result);
    });
}

/// "-1024 to 3071 HU"
std::string rangeOf(const RenderResult& result, const VolumeInfo& info) {
    return formatNumber(result.lowest) + " to " + formatNumber(result.highest) +
           (info.unit.empty() ? "" : " " + info.unit);
}

/// "level 2" or "levels 0 to 4", and the passes where there were several.
std::string levelText(const RenderResult& result) {
    int coarsest = result.level;
    for (int level = 0; level < kLevelCount; ++level)
        if (result.bricksOfLevel[static_cast<std::size_t>(level)] > 0)
            coarsest = level;
    std::string text = coarsest <= result.level
                           ? "level " + std::to_string(result.level)
                           : "levels " + std::to_string(result.level) + " to " + std::to_string(coarsest);
    if (result.passes > 1)
        text += " in " + std::to_string(result.passes) + " passes";
    return text;
}

/// Of all that a picture takes, its check and its measurement too.
double secondsOf(const RenderResult& result) {
    return result.secondsPreparing + result.secondsLoading + result.secondsDrawing + result.secondsChecking;
}

} // namespace

void noteWritten(const RenderTask& task, const Scene& scene, const RenderResult& result,
                 const std::string& kind) {
    task.common.note("wrote " + task.arguments.out + ": " + std::to_string(scene.imageSize.x) + " x " +
                     std::to_string(scene.imageSize.y) + kind + ", " + levelText(result) + ", " +
                     result.device + ", " + formatNumber(secondsOf(result), 3) + " s");
}

void warnBlank(const RenderTask& task, const RenderResult& result) {
    const Scene& scene = task.scene;
    const VolumeInfo& info = task.store.info();
    const Reduction reduction = reductionOf(scene);
    const bool composites =
        reduction == Reduction::composite || (reduction == Reduction::sum && scene.mode != Mode::radiograph);
    std::string why = "the camera sees nothing of the volume, which lies in " + placeOf(info);
    std::string fix = " --view anterior";
    if (composites && !(result.highest > result.lowest)) {
        why = "all values of the volume are " + formatNumber(result.lowest), fix = "";
    } else if (scene.mode == Mode::isosurface && !hasSurfaceAmong(scene.surfaces, result)) {
        why = "none of the isosurfaces' values is among the volume's, which go from " + rangeOf(result, info);
        fix = " --isosurface " + formatNumber(0.5 * (result.lowest + result.highest));
    } else if (composites && scene.mode != Mode::isosurface && !hasSurfaceAmong(scene.surfaces, result) &&
               !showsAnything(scene.volumes.front().transferFunction, result)) {
        why =
            "the transfer function shows none of the volume's values, which go from " + rangeOf(result, info);
        fix = " --preset auto";
    } else if (!drawnPart(sceneOfVolume(scene, 0), info)
                    .meets(glm::dvec3(0), glm::dvec3(info.extentVoxels))) {
        why = "the cuts leave nothing of the volume, which lies in " + placeOf(info), fix = "";
    } else if (isSeenFromEdge(scene)) {
        why = "the slice is seen from its edge", fix = "";
    } else if (result.labels && result.labels->shown == 0 && !showsUnlabelled(scene.volumes.front().labels)) {
        why = "none of the labels that are shown has a voxel on the volume", fix = "";
    } else if (scene.cuts.any()) {
        why = "what shows of the volume lies outside of the cuts, or of what the camera sees; the volume "
              "lies in " +
              placeOf(info),
        fix = "";
    }
    task.common.problem("the picture is blank: " + why + "; try: " +
                        (fix.empty()
                             ? "tessera info " + task.arguments.in
                             : "tessera render " + task.arguments.in + " -o " + task.arguments.out + fix));
}

void noteMirrored(const RenderTask& task) {
    const Scene& scene = task.scene;
    const auto* const view = std::get_if<FittedView>(&scene.camera);
    if (scene.mode != Mode::slice || scene.slice.orientation != Orientation::oblique || !view || view->named)
        return;
    const glm::dvec3 normal = poseOf(scene.slice, glm::dvec3(0)).normal, size = glm::abs(normal);
    const bool isAxial = size.z >= size.x && size.z >= size.y, isCoronal = !isAxial && size.y >= size.x;
    if ((isAxial && normal.z > 0) || (isCoronal && normal.y > 0))
        task.common.note(std::string("the slice is seen from the ") + (isAxial ? "head" : "back") +
                         ", with the patient's left at the picture's left, unlike " +
                         (isAxial ? "axial" : "coronal") + " slices; the opposite normal turns it");
}

void noteTable(const RenderTask& task, const RenderResult& result) {
    if (result.patientTable && result.patientTable->why.empty())
        task.common.note("the table is left out (" + formatNumber(result.patientTable->litres, 2) +
                         " l); --hide-table no draws it");
    else if (result.patientTable && result.patientTable->isUnknown)
        task.common.note("a table would be drawn: " + result.patientTable->why);
    else if (result.patientTable)
        task.common.detail("nothing is left out as a table: " + result.patientTable->why);
}

void noteLeftOut(const RenderTask& task, const RenderResult& result) {
    if (result.leftOut.empty())
        return;
    const Scene& scene = task.scene;
    const auto* const name = std::get_if<std::string>(&scene.volumes.front().transferFunction);
    const bool isWindow = reductionOf(scene) != Reduction::composite;
    task.common.note((isWindow || !name ? std::string("auto") : *name) + " leaves out " +
                     sayFills(result.leftOut));
}

void noteMissingSurfaces(const RenderTask& task, const RenderResult& result) {
    if (reductionOf(task.scene) != Reduction::composite)
        return;
    for (const Isosurface& surface : task.scene.surfaces)
        if (surface.opacity > 0 && !isAmong(surface.value, result))
            task.common.note("isosurface " + formatNumber(surface.value, 6) +
                             ": the volume has no such value, so nothing of it is in the picture; its values "
                             "go from " +
                             rangeOf(result, task.store.info()));
}

void noteUnseenSky(const RenderTask& task) {
    if (task.scene.lighting.environment && !followsWays(task.scene))
        task.common.note("lighting.environment: nothing shows it, neither paths of light nor an isosurface "
                         "with a reflection");
}

void noteMissedError(const RenderTask& task, const RenderResult& result) {
    const double asked = task.scene.quality.maxError.value_or(0);
    if (!(asked > 0))
        return;
    if (result.measured && result.measured->keptLight && !result.measured->light)
        task.common.note("--max-error is about rays and levels: the error of the light itself is not "
                         "measured (--verify full does)");
    if (!result.shortfall.empty())
        task.common.note("the picture is not known to be within --max-error " + formatNumber(asked, 2) +
                         ": " + result.shortfall);
    else if (!result.measured && result.errors && result.errors->luvP99() > asked)
        task.common.note("the picture's error is estimated at " + formatNumber(result.errors->luvP99(), 2) +
                         " (L*u*v*, 99th percentile), more than " + formatNumber(asked, 2) +
                         ": no step tried is fine enough");
}

} // namespace tessera
