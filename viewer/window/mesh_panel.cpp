// viewer/window/mesh_panel.cpp: see mesh_panel.h.
#include "viewer/window/mesh_panel.h"

#include "core/base/shown_text.h"
#include "core/image/colour.h"
#include "viewer/session/file_kind.h"
#include "viewer/window/boxes.h"

#include <algorithm>
#include <imgui.h>
#include <utility>

namespace tessera {
namespace {

constexpr float kMeshSwatch = 14;
constexpr const char* kTakeAway = "x";

/// @param edit  of the mesh, which is a copy
template <typename Edit> void editMesh(WindowState& desk, std::size_t number, bool moving, const Edit& edit) {
    Scene scene = desk.scene();
    edit(scene.meshes[number]);
    desk.setScene(scene, moving);
}

} // namespace

void MeshPanel::draw(WindowState& desk) {
    if (reductionOf(desk.scene()) != Reduction::composite)
        wrapped("mode %s draws no meshes", nameOf(desk.scene().mode).c_str());
    for (std::size_t n = 0; n < desk.scene().meshes.size(); ++n) {
        ImGui::PushID(static_cast<int>(n));
        row(desk, n);
        ImGui::PopID();
    }
    look(desk);
}

void MeshPanel::row(WindowState& desk, std::size_t number) {
    const SceneMesh& mesh = desk.scene().meshes[number];
    const std::string name = printable(mesh.name());
    const bool shows = mesh.show;
    if (eyeButton(shows ? EyeState::open : EyeState::shut)) {
        desk.beginEdit();
        editMesh(desk, number, false, [&](SceneMesh& edited) { edited.show = !shows; });
        return;
    }
    const glm::vec3 rgb = screenRgb(mesh.colour.value_or(kMeshColour));
    if (ImGui::ColorButton("colour", {rgb.r, rgb.g, rgb.b, 1},
                           ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoDragDrop,
                           {kMeshSwatch, ImGui::GetTextLineHeight()})) {
        look_ = number;
        opensLook_ = true;
    }
    ImGui::SameLine(0, 6);
    const float wide = ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(kTakeAway).x -
                       3 * ImGui::GetStyle().FramePadding.x;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::PushClipRect(at, {at.x + wide, at.y + ImGui::GetTextLineHeightWithSpacing()}, true);
    ImGui::GetWindowDrawList()->AddText(at, ImGui::GetColorU32(shows ? ImGuiCol_Text : ImGuiCol_TextDisabled),
                                        name.c_str());
    ImGui::PopClipRect();
    ImGui::Dummy({std::max(1.0f, wide), ImGui::GetTextLineHeight()});
    if (!mesh.path.empty() && ImGui::IsItemHovered())
        ImGui::SetTooltip("%s", printable(mesh.path.string()).c_str());
    ImGui::SameLine(0, 0);
    if (ImGui::SmallButton(kTakeAway)) {
        Scene scene = desk.scene();
        scene.meshes.erase(scene.meshes.begin() + static_cast<std::ptrdiff_t>(number));
        desk.beginEdit();
        desk.setScene(scene, false, true);
    }
}

void MeshPanel::look(WindowState& desk) {
    if (std::exchange(opensLook_, false))
        ImGui::OpenPopup("look of a mesh");
    if (look_ >= desk.scene().meshes.size() || !ImGui::BeginPopup("look of a mesh"))
        return;
    const SceneMesh mesh = desk.scene().meshes[look_]; // a copy: edits make another scene
    ImGui::TextUnformatted(printable(mesh.name()).c_str());
    const glm::vec3 now = screenRgb(mesh.colour.value_or(kMeshColour));
    float rgb[3] = {now.r, now.g, now.b};
    ImGui::SetNextItemWidth(200);
    const bool coloured = ImGui::ColorPicker3("##colour", rgb);
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    auto opacity = static_cast<float>(mesh.opacity);
    ImGui::SetNextItemWidth(200);
    const bool faded = ImGui::SliderFloat("opacity", &opacity, 0, 1, "%.2f");
    if (ImGui::IsItemActivated())
        desk.beginEdit();
    if (coloured)
        editMesh(desk, look_, true, [&](SceneMesh& edited) {
            edited.colour = glm::dvec3(linearFromSrgb(static_cast<double>(rgb[0])),
                                       linearFromSrgb(static_cast<double>(rgb[1])),
                                       linearFromSrgb(static_cast<double>(rgb[2])));
        });
    if (faded)
        editMesh(desk, look_, true, [&](SceneMesh& edited) {
            edited.opacity = std::clamp(static_cast<double>(opacity), 0.0, 1.0);
        });
    if (mesh.colour && ImGui::Button("colour as at first")) {
        desk.beginEdit();
        editMesh(desk, look_, false, [](SceneMesh& edited) { edited.colour.reset(); });
    }
    if (meansStructureSet(mesh.path)) {
        ImGui::SetNextItemWidth(200);
        if (const auto taken = nameBox("contours", nameOf(mesh.contours), namesOf<ContourStyle>().all())) {
            desk.beginEdit();
            editMesh(desk, look_, false, [&](SceneMesh& edited) {
                edited.contours = parseName<ContourStyle>(*taken, "contours");
            });
        }
    }
    ImGui::EndPopup();
}

} // namespace tessera
