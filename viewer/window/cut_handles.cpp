// viewer/window/cut_handles.cpp: see cut_handles.h.
#include "viewer/window/cut_handles.h"

#include "viewer/session/view_geometry.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <imgui.h>
#include <vector>

namespace tessera {
namespace {

constexpr ImU32 kInk = IM_COL32(255, 160, 90, 255), kHeld = IM_COL32(255, 220, 140, 255),
                kEdge = IM_COL32(255, 160, 90, 130);
constexpr double kReach = 10;           // distance in units at which a handle can be grabbed
constexpr double kArrowOfHeight = 0.08; // a handle's arrow as a fraction of the picture's height

/// The frame of a box: a corner, and vectors along its edges, mm per unit.
struct BoxFrame {
    glm::dvec3 origin{0};
    glm::dmat3 axes{1.0};
    glm::dvec3 mmPerUnit{1};
    glm::dvec3 at(const glm::dvec3& place) const { return origin + axes * place; }
};
BoxFrame frameOf(const VolumeInfo& info, const CropBox& box) {
    BoxFrame frame;
    if (box.space == CropBox::Space::patient)
        return frame;
    frame.origin = glm::dvec3(info.patientFromVoxel[3]);
    frame.axes = glm::dmat3(info.patientFromVoxel);
    frame.mmPerUnit = info.spacingMm();
    return frame;
}

/// The target of a handle: a plane along its normal, or a side of the crop box along its axis.
struct Grip {
    std::size_t plane = 0;
    int axis = -1; // of the box; -1: a plane
    bool high = false;
    glm::dvec3 point{0}, direction{0}; // mm; unit
};

std::vector<Grip> gripsOf(const WindowState& desk) {
    std::vector<Grip> grips;
    const Cuts& cuts = desk.scene().cuts;
    for (std::size_t i = 0; i < cuts.planes.size(); ++i)
        grips.push_back({i, -1, false, cuts.planes[i].point, glm::normalize(cuts.planes[i].normal)});
    if (cuts.boxes.empty())
        return grips;
    const CropBox& box = cuts.boxes.front();
    const BoxFrame frame = frameOf(desk.volume()->info, box);
    for (int axis = 0; axis < 3; ++axis)
        for (const bool high : {false, true}) {
            glm::dvec3 place = (box.low + box.high) / 2.0;
            place[axis] = (high ? box.high : box.low)[axis];
            grips.push_back(
                {0, axis, high, frame.at(place), glm::normalize(frame.axes[axis]) * (high ? 1.0 : -1.0)});
        }
    return grips;
}

/// Pushes it.
/// @param mm  along its direction
void push(Scene& scene, const VolumeInfo& info, const Grip& grip, double mm) {
    if (grip.axis < 0) {
        scene.cuts.planes[grip.plane].point += mm * grip.direction;
        return;
    }
    CropBox& box = scene.cuts.boxes.front();
    const double units = mm / frameOf(info, box).mmPerUnit[grip.axis];
    constexpr double kThinnest = 0.5; // units
    double &low = box.low[grip.axis], &high = box.high[grip.axis];
    if (grip.high)
        high = std::max(high + units, low + kThinnest);
    else
        low = std::min(low - units, high - kThinnest);
    if (box.space == CropBox::Space::voxels) {
        const double extent = info.extentVoxels[grip.axis];
        low = std::clamp(low, 0.0, extent - kThinnest);
        high = std::clamp(high, low + kThinnest, extent);
    }
}

/// A handle on the picture, pixels: its position and the end of its arrow.
struct Handle {
    glm::dvec2 from{0}, to{0};
    double mm = 0; // length of the arrow
};

std::optional<Handle> handleOf(const WindowState& desk, const glm::ivec2& size, const Grip& grip) {
    Handle handle;
    const Camera& camera = desk.camera();
    const double halfHeightMm = camera.projection == Projection::parallel
                                    ? camera.parallelScale
                                    : 0.25 * glm::length(grip.point - camera.position);
    handle.mm = 2 * kArrowOfHeight * halfHeightMm * (grip.axis < 0 ? 1.0 : 0.4);
    if (!pictureFromPatient(camera, size, grip.point, handle.from) ||
        !pictureFromPatient(camera, size, grip.point + handle.mm * grip.direction, handle.to))
        return std::nullopt;
    return handle;
}

} // namespace

void CutHandles::toggleBox(WindowState& desk) {
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

void CutHandles::addPlane(WindowState& desk) {
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

void CutHandles::boxes(WindowState& desk) {
    const VolumeInfo& info = desk.volume()->info;
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
    const bool voxels = box.space == CropBox::Space::voxels;
    const glm::dvec3 mm = frameOf(info, box).mmPerUnit, extent = glm::dvec3(info.extentVoxels) * mm;
    bool moved = false;
    const char* const names[] = {"x", "y", "z"};
    for (int axis = 0; axis < 3; ++axis) {
        float ends[2] = {static_cast<float>(box.low[axis] * mm[axis]),
                         static_cast<float>(box.high[axis] * mm[axis])};
        const float most = static_cast<float>(extent[axis]);
        if (ImGui::DragFloatRange2(names[axis], &ends[0], &ends[1], most / 400, voxels ? 0 : -2e4f,
                                   voxels ? most : 2e4f, "%.1f mm", "%.1f mm") &&
            ends[0] < ends[1]) {
            box.low[axis] = static_cast<double>(ends[0]) / mm[axis];
            box.high[axis] = static_cast<double>(ends[1]) / mm[axis];
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

void CutHandles::planes(WindowState& desk) {
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

namespace {

void hideTableBox(WindowState& desk) {
    Scene scene = desk.scene();
    HideTable& choice = scene.volumes.front().hideTable;
    bool hides = choice == HideTable::automatic;
    if (!ImGui::Checkbox("hide the table, if found", &hides))
        return;
    desk.beginEdit();
    choice = hides ? HideTable::automatic : HideTable::no;
    desk.setScene(scene, false);
}

} // namespace

void CutHandles::panel(WindowState& desk) {
    if (desk.volume()->values.isHu)
        hideTableBox(desk);
    boxes(desk);
    planes(desk);
}

bool CutHandles::handle(WindowState& desk, const Area& area) {
    const std::vector<Grip> grips = desk.volume() ? gripsOf(desk) : std::vector<Grip>();
    if (grips.empty()) {
        held_.reset();
        return false;
    }
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 mouse(io.MousePos.x, io.MousePos.y), place = area.pictureFromWindow(mouse);
    if (!held_ && !io.WantCaptureMouse && ImGui::IsMouseClicked(0)) {
        double nearest = kReach * area.pixelsPerUnit;
        for (std::size_t i = 0; i < grips.size(); ++i)
            if (const auto handle = handleOf(desk, area.pixels(), grips[i]);
                handle && glm::length(handle->from - place) <= nearest) {
                nearest = glm::length(handle->from - place);
                held_ = i;
            }
        if (held_)
            desk.beginEdit();
    }
    if (!held_)
        return false;
    if (!ImGui::IsMouseDown(0) || *held_ >= grips.size()) {
        held_.reset();
        return true;
    }
    if (io.MouseDelta.x == 0 && io.MouseDelta.y == 0)
        return true;
    const glm::dvec2 delta = glm::dvec2(io.MouseDelta.x, io.MouseDelta.y) * area.pixelsPerUnit;
    const Grip& grip = grips[*held_];
    if (const auto handle = handleOf(desk, area.pixels(), grip)) {
        // Movement along the projected direction. If the direction is seen end on, vertical movement counts
        // as along an arrow of full length.
        const glm::dvec2 way = handle->to - handle->from;
        const double full = kArrowOfHeight * area.pixels().y * (grip.axis < 0 ? 1.0 : 0.4);
        const double length = glm::length(way);
        const double mm = length > 0.3 * full ? handle->mm * glm::dot(delta, way) / (length * length)
                                              : -handle->mm * delta.y / full;
        Scene scene = desk.scene();
        push(scene, desk.volume()->info, grip, mm);
        desk.setScene(scene, true);
    }
    return true;
}

void CutHandles::draw(const WindowState& desk, const Area& area) const {
    if (!desk.volume())
        return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const auto at = [](const glm::dvec2& p) {
        return ImVec2(static_cast<float>(p.x), static_cast<float>(p.y));
    };
    draw.PushClipRect(at(area.from), at(area.from + area.size));
    if (!desk.scene().cuts.boxes.empty()) {
        const CropBox& box = desk.scene().cuts.boxes.front();
        const BoxFrame frame = frameOf(desk.volume()->info, box);
        const auto corner = [&](int n) {
            return frame.at({n & 1 ? box.high.x : box.low.x, n & 2 ? box.high.y : box.low.y,
                             n & 4 ? box.high.z : box.low.z});
        };
        glm::dvec2 a(0), b(0);
        for (int n = 0; n < 8; ++n)
            for (int axis = 0; axis < 3; ++axis)
                if (const int other = n | 1 << axis;
                    other != n && pictureFromPatient(desk.camera(), area.pixels(), corner(n), a) &&
                    pictureFromPatient(desk.camera(), area.pixels(), corner(other), b))
                    draw.AddLine(at(area.from + a / area.pixelsPerUnit),
                                 at(area.from + b / area.pixelsPerUnit), kEdge, 1);
    }
    const std::vector<Grip> grips = gripsOf(desk);
    for (std::size_t i = 0; i < grips.size(); ++i) {
        const auto handle = handleOf(desk, area.pixels(), grips[i]);
        if (!handle)
            continue;
        const ImVec2 from = at(area.from + handle->from / area.pixelsPerUnit),
                     to = at(area.from + handle->to / area.pixelsPerUnit);
        const ImU32 ink = held_ == i ? kHeld : kInk;
        draw.AddLine(from, to, ink, 2);
        if (grips[i].axis < 0) {
            draw.AddCircleFilled(from, 5, ink);
            draw.AddCircle(from, 9, ink, 0, 1.5f);
        } else {
            draw.AddRectFilled({from.x - 4, from.y - 4}, {from.x + 4, from.y + 4}, ink);
        }
    }
    draw.PopClipRect();
}

} // namespace tessera
