// viewer/window/mode_panel.cpp: see panels.h.
#include "viewer/window/panels.h"

#include "core/scene/mode.h"
#include "viewer/window/boxes.h"

#include <algorithm>
#include <glm/common.hpp>
#include <imgui.h>
#include <string>
#include <variant>
#include <vector>

namespace tessera {
namespace {

/// Of the volume, along an axis of the patient, mm.
struct Range {
    double low = 1e30, high = -1e30;
};
Range rangeAlong(const VolumeInfo& info, int axis) {
    Range range;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 voxel =
            glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        const double mm = (info.patientFromVoxel * glm::dvec4(voxel, 1))[axis];
        range.low = std::min(range.low, mm);
        range.high = std::max(range.high, mm);
    }
    return range;
}

/// The plane, its place along its axis, and its thickness.
void slicePlane(WindowState& desk) {
    Scene scene = desk.scene();
    SlicePlane& slice = scene.slice;
    std::vector<std::string> planes(orientationNames().begin(), orientationNames().begin() + 3);
    const auto turned =
        nameBox("plane", orientationNames()[static_cast<std::size_t>(slice.orientation)], planes);
    bool moving = false, changed = false;
    if (turned) {
        desk.beginEdit();
        slice.orientation = parseName<Orientation>(*turned, "plane");
        slice.positionMm.reset();
        changed = true;
    }
    if (slice.orientation != Orientation::oblique) {
        const int axis = 2 - static_cast<int>(slice.orientation); // z of axial, y of coronal, x of sagittal
        const Range range = rangeAlong(desk.volume()->info, axis);
        auto mm = static_cast<float>(slice.positionMm.value_or((range.low + range.high) / 2));
        if (ImGui::SliderFloat("place", &mm, static_cast<float>(range.low), static_cast<float>(range.high),
                               "%.1f mm")) {
            slice.positionMm = static_cast<double>(mm);
            moving = changed = true;
        }
        if (ImGui::IsItemActivated())
            desk.beginEdit();
    }
    auto thickness = static_cast<float>(slice.thicknessMm);
    if (ImGui::DragFloat("thickness", &thickness, 0.2f, 0, 500, thickness > 0 ? "%.1f mm" : "plane alone")) {
        slice.thicknessMm = std::max(0.0, static_cast<double>(thickness));
        moving = changed = true;
    }
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    if (slice.thicknessMm > 0) {
        const auto& names = reductionNames();
        if (const auto taken =
                nameBox("shows", names[static_cast<std::size_t>(slice.reduction) - 1], names)) {
            desk.beginEdit();
            slice.reduction = parseName<Reduction>(*taken, "shows");
            changed = true;
        }
    }
    if (changed)
        desk.setScene(scene, moving);
}

/// The sum that is shown white; 0: the greatest of the picture.
void exposurePanel(WindowState& desk) {
    Scene scene = desk.scene();
    if (scene.mode == Mode::absorption)
        return;
    const auto* const window = std::get_if<GreyWindow>(&scene.window);
    auto most = static_cast<float>(window ? window->high() : 0);
    if (ImGui::DragFloat(scene.mode == Mode::radiograph ? "white is" : "brightest", &most, 1, 0, 1e5f,
                         most <= 0                        ? "the greatest sum"
                         : scene.mode == Mode::radiograph ? "%.0f mm of water"
                                                          : "a sum of %.1f")) {
        scene.window = std::string("auto");
        if (const double low = window ? window->low() : 0; double{most} > std::max(low, 0.0))
            scene.window = GreyWindow{(low + double{most}) / 2, double{most} - low};
        desk.setScene(scene, true);
    }
    if (ImGui::IsItemActivated())
        desk.beginEdit();
}

} // namespace

void modePanel(WindowState& desk) {
    Scene scene = desk.scene();
    if (const auto taken = nameBox("mode", modeNames()[static_cast<std::size_t>(scene.mode)], modeNames())) {
        desk.beginEdit();
        const Mode before = scene.mode;
        const bool showedSums = reductionOf(scene) == Reduction::sum;
        scene.mode = parseName<Mode>(*taken, "mode");
        if (scene.mode != before && (showedSums || reductionOf(scene) == Reduction::sum))
            scene.window = std::string("auto"); // each has a unit of its own
        if (scene.mode == Mode::radiograph && scene.valueColour == ValueColour::transferFunction)
            scene.valueColour = ValueColour::window;
        desk.setScene(scene, false);
        return;
    }
    if (scene.mode == Mode::isosurface) {
        surfacesPanel(desk);
        return;
    }
    if (scene.mode == Mode::composite)
        return;
    if (reductionOf(scene) == Reduction::sum) {
        exposurePanel(desk);
        return;
    }
    if (scene.mode == Mode::slice)
        slicePlane(desk);
    bool began = false;
    const ValueSummary& values = desk.volume()->values;
    const auto window = windowBox(windowOf(scene.window, values, scene.mode), values, scene.mode, began);
    if (began)
        desk.beginEdit();
    if (window) {
        scene = desk.scene();
        scene.window = *window;
        desk.setScene(scene, true);
    }
}

void surfacesPanel(WindowState& desk) {
    Scene scene = desk.scene();
    const ValueSummary values = withoutFills(desk.volume()->values);
    const double range = values.highest - values.lowest;
    bool changed = false, moving = false;
    for (std::size_t i = 0; i < scene.surfaces.size() && !changed; ++i) {
        ImGui::PushID(static_cast<int>(i));
        Isosurface& surface = scene.surfaces[i];
        float value = static_cast<float>(surface.value), opacity = static_cast<float>(surface.opacity);
        ImGui::SetNextItemWidth(110);
        const bool moved = ImGui::DragFloat("##value", &value, static_cast<float>(range / 2000),
                                            static_cast<float>(values.lowest),
                                            static_cast<float>(values.highest), formatFor(range));
        if (ImGui::IsItemActivated())
            desk.beginEdit();
        ImGui::SameLine();
        ImGui::SetNextItemWidth(90);
        const bool faded = ImGui::SliderFloat("##opacity", &opacity, 0.02f, 1, "opacity %.2f");
        if (ImGui::IsItemActivated())
            desk.beginEdit();
        ImGui::SameLine();
        const bool gone = ImGui::SmallButton("remove");
        ImGui::PopID();
        if (moved || faded) {
            surface.value = static_cast<double>(value);
            surface.opacity = static_cast<double>(opacity);
            changed = moving = true;
        }
        if (gone) {
            desk.beginEdit();
            scene.surfaces.erase(scene.surfaces.begin() + static_cast<std::ptrdiff_t>(i));
            changed = true;
        }
    }
    if (scene.surfaces.size() < Scene::kMaxSurfaces && ImGui::Button("add isosurface")) {
        desk.beginEdit();
        scene.surfaces.push_back(desk.surfaceOffered());
        changed = true;
    }
    if (changed)
        desk.setScene(scene, moving);
}

} // namespace tessera
