// viewer/window/beside.cpp: see beside.h.
#include "viewer/window/beside.h"

#include <glm/geometric.hpp>
#include <imgui.h>
#include <string>
#include <utility>
#include <variant>

namespace tessera {
namespace {

glm::dvec3 middleOf(const VolumeInfo& info) {
    return {info.patientFromVoxel * glm::dvec4(0.5 * glm::dvec3(info.extentVoxels), 1)};
}

bool inOneFrame(const VolumeInfo& a, const VolumeInfo& b) {
    return !a.frameOfReference.empty() && a.frameOfReference == b.frameOfReference;
}

void move(Camera& camera, const glm::dvec3& by) {
    camera.position += by;
    camera.focalPoint += by;
}

/// Without boxes in voxels, which are of one volume.
Cuts moved(Cuts cuts, const glm::dvec3& by) {
    std::erase_if(cuts.boxes, [](const CropBox& box) { return box.space == CropBox::Space::voxels; });
    for (CropBox& box : cuts.boxes) {
        box.low += by;
        box.high += by;
    }
    for (CutPlane& plane : cuts.planes)
        plane.point += by;
    for (Scissors& scissors : cuts.scissors)
        move(scissors.camera, by);
    return cuts;
}

/// The axis along which a plane's position is.
int axisOf(const SlicePlane& slice) {
    return slice.orientation == Orientation::axial ? 2 : slice.orientation == Orientation::coronal ? 1 : 0;
}

/// @param middle  of its volume, where a plane without a position lies
SlicePlane moved(SlicePlane slice, const glm::dvec3& middle, const glm::dvec3& by) {
    const int axis = axisOf(slice);
    slice.point += by;
    slice.positionMm = slice.positionMm.value_or(middle[axis]) + by[axis];
    return slice;
}

} // namespace

glm::dvec3 shiftBetween(const VolumeInfo& from, const VolumeInfo& to) {
    return inOneFrame(from, to) ? glm::dvec3(0) : middleOf(to) - middleOf(from);
}

Scene sceneBeside(const Scene& scene, const VolumeInfo& of, const VolumeSeen& other) {
    const glm::dvec3 by = shiftBetween(of, other.info);
    Scene beside = scene;
    beside.volumes = {other.scene.volumes.front()};
    const SceneVolume& look = scene.volumes.front();
    if (of.unit == other.info.unit) {
        beside.volumes.front().transferFunction = look.transferFunction;
        beside.volumes.front().window = look.window;
        beside.volumes.front().valueColour = look.valueColour;
    } else {
        beside.window = other.scene.window;
    }
    beside.meshes.clear();
    beside.measurements.clear();
    beside.annotations = {};
    beside.cuts = moved(scene.cuts, by);
    beside.slice = moved(scene.slice, middleOf(of), by);
    if (auto* const camera = std::get_if<Camera>(&beside.camera))
        move(*camera, by);
    return beside;
}

Beside::Beside(std::unique_ptr<Viewing> viewing, std::filesystem::path path)
    : viewing_(std::move(viewing)), path_(std::move(path)) {}

void Beside::update(const WindowState& desk, const glm::ivec2& pictureSize) {
    if (!opened_ && pictureSize.x > 0) {
        viewing_->open(path_, pictureSize);
        opened_ = true;
    }
    state_ = viewing_->state();
    if (auto volume = viewing_->volume(); volume != volume_) {
        volume_ = std::move(volume);
        of_ = nullptr; // it is asked for anew
    }
    if (!volume_ || !desk.volume() || desk.isFitting())
        return;
    const bool moving = !desk.hasAsked();
    if (of_ == desk.volume() && asked_ == desk.asked() && size_ == pictureSize && moving_ == moving)
        return;
    of_ = desk.volume();
    asked_ = desk.asked();
    size_ = pictureSize;
    moving_ = moving;
    Scene scene = sceneBeside(desk.scene(), desk.volume()->info, *volume_);
    scene.imageSize = pictureSize;
    viewing_->show(scene, moving);
}

bool Beside::atRest() const {
    const bool fails =
        state_.kind == ViewingState::Kind::failed || state_.kind == ViewingState::Kind::choosing;
    return fails || (volume_ && state_.atRest);
}

std::string Beside::about(const WindowState& desk) const {
    const std::string name = path_.stem().string();
    if (state_.kind == ViewingState::Kind::failed)
        return name + " cannot be shown: " + state_.what;
    if (state_.kind == ViewingState::Kind::choosing)
        return name + " has several volumes: --beside takes one";
    if (!volume_ || !desk.volume())
        return name + " is being opened";
    return name + (inOneFrame(desk.volume()->info, volume_->info)
                       ? ", in the same frame of reference"
                       : ", middle on middle: the scans do not say how they lie to one another");
}

void drawBeside(const Beside& beside, const WindowState& desk, const Area& area) {
    constexpr float kMargin = 14, kTop = 12;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const ImVec2 from(static_cast<float>(area.from.x), static_cast<float>(area.from.y));
    const float end = from.y + static_cast<float>(area.size.y);
    draw.AddLine({from.x - 1, from.y}, {from.x - 1, end}, IM_COL32(235, 235, 235, 130), 2);
    const std::string words = beside.about(desk);
    const float wrap = static_cast<float>(area.size.x) - 2 * kMargin;
    for (const bool shade : {true, false})
        draw.AddText(ImGui::GetFont(), ImGui::GetFontSize(),
                     {from.x + kMargin + (shade ? 1.0f : 0.0f), from.y + kTop + (shade ? 1.0f : 0.0f)},
                     shade ? IM_COL32(0, 0, 0, 200) : IM_COL32(235, 235, 235, 255), words.c_str(), nullptr,
                     wrap);
}

} // namespace tessera
