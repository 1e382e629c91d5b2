// viewer/window/cut_handles.cpp: see cut_handles.h.
#include "viewer/window/cut_handles.h"

#include "viewer/session/camera_moves.h"
#include "viewer/window/overlays.h" // pictureFromPatient

#include <cstdio>
#include <glm/geometric.hpp>
#include <imgui.h>

namespace tessera {
namespace {

constexpr ImU32 kInk = IM_COL32(255, 160, 90, 255), kHeld = IM_COL32(255, 220, 140, 255);
constexpr double kReach = 10;           // pixels around a handle that take it
constexpr double kArrowOfHeight = 0.08; // of the picture: how long a handle's arrow is

/// A plane's handle on the picture, pixels: where it stands, and the end of a way along its normal.
struct Handle {
    glm::dvec2 from{0}, to{0};
    double mm = 0; // of that way
};

std::optional<Handle> handleOf(const Desk& desk, const glm::ivec2& size, const CutPlane& plane) {
    Handle handle;
    const Camera& camera = desk.camera();
    const glm::dvec3 normal = glm::normalize(plane.normal);
    const double halfHeightMm = camera.projection == Projection::parallel
                                    ? camera.parallelScale
                                    : 0.25 * glm::length(plane.point - camera.position);
    handle.mm = 2 * kArrowOfHeight * halfHeightMm;
    if (!pictureFromPatient(camera, size, plane.point, handle.from) ||
        !pictureFromPatient(camera, size, plane.point + handle.mm * normal, handle.to))
        return std::nullopt;
    return handle;
}

} // namespace

void CutHandles::toggleBox(Desk& desk) {
    if (!desk.volume())
        return;
    Scene scene = desk.scene();
    std::vector<CropBox>& boxes = scene.cuts.boxes;
    if (boxes.empty())
        boxes.push_back({glm::dvec3(0), glm::dvec3(desk.volume()->info.extentVoxels), CropBox::Space::voxels,
                         Keep::inside});
    else
        boxes.clear();
    desk.beginEdit();
    desk.setScene(scene, false);
}

void CutHandles::addPlane(Desk& desk) {
    if (!desk.volume())
        return;
    Scene scene = desk.scene();
    if (scene.cuts.planes.size() >= Cuts::kMostOfAKind) {
        desk.tell("no more than 16 planes cut at once", true);
        return;
    }
    // Inside is where the normal points: away from the viewer.
    const glm::dvec3 toViewer = patientFromCamera(desk.camera())[2];
    scene.cuts.planes.push_back({desk.slices().placeMm, -toViewer, Keep::inside});
    desk.beginEdit();
    desk.setScene(scene, false);
}

void CutHandles::boxes(Desk& desk) {
    const glm::dvec3 extent(desk.volume()->info.extentVoxels);
    Scene scene = desk.scene();
    std::vector<CropBox>& boxes = scene.cuts.boxes;
    bool on = !boxes.empty();
    if (ImGui::Checkbox("crop box (B)", &on)) {
        toggleBox(desk);
        return;
    }
    if (boxes.empty())
        return;
    CropBox& box = boxes.front();
    bool moved = false;
    const char* const names[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
        float ends[2] = {static_cast<float>(box.low[axis]), static_cast<float>(box.high[axis])};
        const float most = static_cast<float>(extent[axis]);
        if (ImGui::DragFloatRange2(names[axis], &ends[0], &ends[1], most / 400, 0, most, "%.0f", "%.0f") &&
            ends[0] < ends[1]) {
            box.low[axis] = static_cast<double>(ends[0]);
            box.high[axis] = static_cast<double>(ends[1]);
            moved = true;
        }
        if (ImGui::IsItemActivated())
            desk.beginEdit();
    }
    bool outside = box.keep == Keep::outside;
    if (ImGui::Checkbox("keep outside", &outside)) {
        desk.beginEdit();
        box.keep = outside ? Keep::outside : Keep::inside;
        moved = true;
    }
    if (moved)
        desk.setScene(scene, true);
}

void CutHandles::planes(Desk& desk) {
    if (ImGui::Button("cut by a plane (N)"))
        addPlane(desk);
    Scene scene = desk.scene();
    for (std::size_t i = 0; i < scene.cuts.planes.size(); ++i) {
        CutPlane& plane = scene.cuts.planes[i];
        ImGui::PushID(static_cast<int>(i));
        bool moving = false, done = false;
        const glm::dvec3 normal = glm::normalize(plane.normal);
        float mm = static_cast<float>(glm::dot(plane.point, normal));
        const float before = mm;
        ImGui::SetNextItemWidth(90);
        if (ImGui::DragFloat("##mm", &mm, 0.5f, 0, 0, "%.1f mm")) {
            plane.point += static_cast<double>(mm - before) * normal;
            moving = true;
        }
        if (ImGui::IsItemActivated())
            desk.beginEdit();
        const auto button = [&](const char* name, const auto& act) {
            ImGui::SameLine();
            if (ImGui::SmallButton(name)) {
                desk.beginEdit();
                act();
                done = true;
            }
        };
        button("face me", [&] { plane.normal = -patientFromCamera(desk.camera())[2]; });
        button("flip", [&] { plane.normal = -plane.normal; });
        button("remove",
               [&] { scene.cuts.planes.erase(scene.cuts.planes.begin() + static_cast<std::ptrdiff_t>(i)); });
        ImGui::PopID();
        if (moving || done) {
            desk.setScene(scene, moving);
            return;
        }
    }
}

void CutHandles::panel(Desk& desk) {
    boxes(desk);
    planes(desk);
}

bool CutHandles::handle(Desk& desk, const Area& area) {
    if (!desk.volume() || desk.scene().cuts.planes.empty()) {
        held_.reset();
        return false;
    }
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 mouse(io.MousePos.x, io.MousePos.y), place = area.pictureFromWindow(mouse);
    if (!held_ && !io.WantCaptureMouse && ImGui::IsMouseClicked(0))
        for (std::size_t i = 0; i < desk.scene().cuts.planes.size(); ++i)
            if (const auto handle = handleOf(desk, area.pixels(), desk.scene().cuts.planes[i]);
                handle && glm::length(handle->from - place) <= kReach * area.pixelsPerUnit) {
                held_ = i;
                desk.beginEdit();
            }
    if (!held_)
        return false;
    if (!ImGui::IsMouseDown(0) || *held_ >= desk.scene().cuts.planes.size()) {
        held_.reset();
        return true;
    }
    if (io.MouseDelta.x == 0 && io.MouseDelta.y == 0)
        return true;
    Scene scene = desk.scene();
    CutPlane& plane = scene.cuts.planes[*held_];
    const glm::dvec2 delta = glm::dvec2(io.MouseDelta.x, io.MouseDelta.y) * area.pixelsPerUnit;
    if (const auto handle = handleOf(desk, area.pixels(), plane)) {
        // Along the normal as it is seen; up and down where it is seen end on, by what a way of the picture's
        // height would be.
        const glm::dvec2 way = handle->to - handle->from;
        const double least = 0.3 * kArrowOfHeight * area.pixels().y, length = glm::length(way);
        const double mm = length > least ? handle->mm * glm::dot(delta, way) / (length * length)
                                         : -handle->mm * delta.y / (kArrowOfHeight * area.pixels().y);
        plane.point += mm * glm::normalize(plane.normal);
        desk.setScene(scene, true);
    }
    return true;
}

void CutHandles::draw(const Desk& desk, const Area& area) const {
    if (!desk.volume())
        return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    for (std::size_t i = 0; i < desk.scene().cuts.planes.size(); ++i) {
        const auto handle = handleOf(desk, area.pixels(), desk.scene().cuts.planes[i]);
        if (!handle)
            continue;
        const glm::dvec2 a = area.from + handle->from / area.pixelsPerUnit,
                         b = area.from + handle->to / area.pixelsPerUnit;
        const ImU32 ink = held_ == i ? kHeld : kInk;
        const ImVec2 from(static_cast<float>(a.x), static_cast<float>(a.y));
        draw.AddLine(from, {static_cast<float>(b.x), static_cast<float>(b.y)}, ink, 2);
        draw.AddCircleFilled(from, 5, ink);
        draw.AddCircle(from, 9, ink, 0, 1.5f);
    }
}

} // namespace tessera
