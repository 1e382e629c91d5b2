// viewer/window/slice_panel.cpp: see slice_panel.h.
#include "viewer/window/slice_panel.h"

#include "core/base/shown_text.h"
#include "viewer/session/patient_letters.h"
#include "viewer/window/beside.h"
#include "viewer/window/boxes.h"
#include "viewer/window/part_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <epoxy/gl.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <imgui.h>
#include <string>

namespace tessera {
namespace {

constexpr ImU32 kLine[] = {IM_COL32(230, 90, 80, 150), IM_COL32(90, 200, 110, 150),
                           IM_COL32(100, 150, 240, 150)};
constexpr double kNarrow = 20; // units: too little for a plane
constexpr ImU32 kPlaneText = IM_COL32(235, 235, 235, 255);

ImVec2 at(const glm::dvec2& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

/// Drawn if all of it lies within a voxel of the plane.
void drawMeasurement(ImDrawList& draw, const Measurement& m, const std::string& words, const Area& view,
                     const SliceFrame& frame) {
    constexpr ImU32 kInk = IM_COL32(120, 220, 255, 255);
    constexpr double kNearMm = 1;
    for (const glm::dvec3& p : m.points)
        if (std::abs(glm::dot(p - frame.pose.point, frame.pose.normal)) > kNearMm)
            return;
    const auto place = [&](const glm::dvec3& p) {
        return view.from + frame.pictureFromPatient(p) / view.pixelsPerUnit;
    };
    for (std::size_t i = 0; i < m.points.size(); ++i) {
        draw.AddCircleFilled(at(place(m.points[i])), 3, kInk);
        if (i > 0 && m.kind != MeasurementKind::circle)
            draw.AddLine(at(place(m.points[i - 1])), at(place(m.points[i])), kInk, 1.5f);
    }
    if (m.kind == MeasurementKind::circle && m.points.size() == 3 && std::isfinite(valueOf(m)))
        draw.AddCircle(at(place(circleCentre(m))),
                       static_cast<float>(valueOf(m) / frame.mmPerPixel / view.pixelsPerUnit), kInk, 0, 1.5f);
    if (m.points.size() > 1)
        drawLabel(draw, at(place(m.points[1]) + glm::dvec2(10, -16)), kInk, words);
}

} // namespace

SlicePanel::SlicePanel() {
    glGenTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
    for (const unsigned texture : textures_) {
        glBindTexture(GL_TEXTURE_2D, texture);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    }
}

SlicePanel::~SlicePanel() {
    glDeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
}

bool SlicePanel::divide(WindowState& desk, const Area& picture, const Area& planes) {
    constexpr double kReach = 4;
    const ImGuiIO& io = ImGui::GetIO();
    const double border = planes.from.x - 1, x = static_cast<double>(io.MousePos.x);
    const bool over = !io.WantCaptureMouse && std::abs(x - border) <= kReach;
    if (over && ImGui::IsMouseClicked(0))
        divides_ = true;
    if (!ImGui::IsMouseDown(0))
        divides_ = false;
    if (over || divides_)
        ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    if (divides_) {
        const double whole = picture.size.x + planes.size.x;
        desk.setPlanesShare(1 - (x - picture.from.x) / std::max(1.0, whole));
    }
    return divides_;
}

struct SlicePanel::Scan {
    Viewing& viewing;
    const VolumeInfo& info;
    glm::dvec3 shift; // from the same place of the first scan
    std::string name; // "": there is one scan
    Beside* beside;   // null: the first scan, with these:
    Tools* tools;
    Endoscopy* endoscopy;

    /// Of its planes as they are now, but for sizes.
    SliceWish wish(const WindowState& desk) const { return beside ? beside->planes(desk) : desk.slices(); }
};

void SlicePanel::hand(WindowState& desk, const Scan& scan, const Area& view, int plane,
                      const SliceFrame& frame) {
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 mouse(io.MousePos.x, io.MousePos.y);
    const bool over = !io.WantCaptureMouse && mouse.x >= view.from.x && mouse.y >= view.from.y &&
                      mouse.x < view.from.x + view.size.x && mouse.y < view.from.y + view.size.y;
    const SliceWish before = scan.wish(desk);
    SliceWish wish = before;
    if (const glm::dvec3 mm = frame.patientFromPicture(view.pictureFromWindow(mouse));
        !scan.beside && over && ImGui::IsMouseClicked(0) &&
        (scan.tools->placed(desk, mm) || scan.endoscopy->placed(desk, mm)))
        return;
    if (over && ImGui::IsMouseDoubleClicked(0)) {
        desk.enlargedPlane = desk.enlargedPlane == plane ? -1 : plane;
        held_ = -1;
        return;
    }
    if (over && held_ < 0 && (ImGui::IsMouseClicked(0) || ImGui::IsMouseClicked(1))) {
        held_ = plane;
        windows_ = ImGui::IsMouseClicked(1);
    }
    if (held_ == plane && !ImGui::IsMouseDown(0) && !ImGui::IsMouseDown(1))
        held_ = -1;
    if (held_ == plane && windows_) {
        wish.window.centre += static_cast<double>(io.MouseDelta.y) * wish.window.width / 300;
        wish.window.width =
            std::max(1e-3, wish.window.width * std::exp2(static_cast<double>(io.MouseDelta.x) / 150));
    } else if (held_ == plane) {
        wish.placeMm = frame.patientFromPicture(view.pictureFromWindow(mouse));
    } else if (over && io.MouseWheel != 0 && io.KeyCtrl) {
        wish.zoom = std::clamp(wish.zoom * std::exp2(0.25 * static_cast<double>(io.MouseWheel)), 1.0, 32.0);
    } else if (over && io.MouseWheel != 0) { // through the volume, a voxel a notch
        const glm::dvec3 spacing = scan.info.spacingMm();
        const double step = plane == 0 ? spacing.z : plane == 1 ? spacing.y : spacing.x;
        wish.placeMm += static_cast<double>(io.MouseWheel) * step * frame.pose.normal;
    }
    if (wish == before)
        return;
    SliceWish all = desk.slices();
    all.placeMm = wish.placeMm - scan.shift;
    all.zoom = wish.zoom;
    if (!scan.beside || scan.beside->sharesWindow(desk))
        all.window = wish.window;
    else
        scan.beside->setWindow(wish.window);
    desk.setSlices(all);
}

/// Of the planes in an area; what is not shown has no size.
SlicePanel::Views SlicePanel::viewsOf(const WindowState& desk, const Area& area) {
    Views views;
    for (std::size_t n = 0; n < views.size(); ++n) {
        views[n] = area;
        if (desk.enlargedPlane < 0) {
            views[n].size.y = area.size.y / 3 - 2;
            views[n].from.y += static_cast<double>(n) * area.size.y / 3;
        } else if (desk.enlargedPlane != static_cast<int>(n)) {
            views[n].size = glm::dvec2(0);
        }
    }
    return views;
}

SliceWish SlicePanel::sized(SliceWish wish, const Views& views) {
    for (std::size_t n = 0; n < views.size(); ++n)
        wish.sizes[n] = views[n].size.x > 0 ? views[n].pixels() : glm::ivec2(0);
    return wish;
}

void SlicePanel::draw(WindowState& desk, Tools& tools, Endoscopy& endoscopy, const Area& area) {
    if (!desk.volume() || area.size.x < kNarrow)
        return;
    const Views views = viewsOf(desk, area);
    SliceWish wish = sized(desk.slices(), views);
    if (const Labels& labels = desk.labels(); labels.path.empty())
        wish.labels.reset();
    else if (!wish.labels || !(*wish.labels == labels))
        wish.labels = std::make_shared<const Labels>(labels);
    if (!(wish == desk.slices()))
        desk.setSlices(wish);
    drawScan(desk,
             {desk.viewing(), desk.volume()->info, glm::dvec3(0),
              desk.beside() ? desk.volume()->path.stem().string() : "", nullptr, &tools, &endoscopy},
             views);
}

void SlicePanel::drawBeside(WindowState& desk, Beside& beside, const Area& area) {
    if (!desk.volume() || !beside.volume() || area.size.x < kNarrow)
        return;
    const Views views = viewsOf(desk, area);
    const SliceWish wish = sized(beside.planes(desk), views);
    if (askedOf_ != beside.volume() || !(wish == asked_)) {
        askedOf_ = beside.volume();
        asked_ = wish;
        beside.viewing().showSlices(wish);
    }
    drawScan(desk,
             {beside.viewing(), beside.volume()->info, beside.shift(desk), beside.name(), &beside, nullptr,
              nullptr},
             views);
}

void SlicePanel::upload(const Viewing& viewing) {
    const auto shown = viewing.slices();
    if (shown == shown_)
        return;
    shown_ = shown;
    for (std::size_t n = 0; shown && n < 3; ++n) {
        const ShownSlice& plane = shown->planes[n];
        if (plane.display.empty())
            continue;
        glBindTexture(GL_TEXTURE_2D, textures_[n]);
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, plane.frame.size.x, plane.frame.size.y, 0, GL_RGBA,
                     GL_UNSIGNED_BYTE, plane.display.data());
    }
}

void SlicePanel::drawScan(WindowState& desk, const Scan& scan, const Views& views) {
    upload(scan.viewing);
    for (std::size_t n = 0; n < 3; ++n)
        if (views[n].size.x > 0)
            drawPlane(desk, scan, views[n], n);
}

/// @param plane  axial, coronal, sagittal
void SlicePanel::drawPlane(WindowState& desk, const Scan& scan, const Area& view, std::size_t plane) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const SliceWish wish = scan.wish(desk);
    const SliceFrame frame =
        sliceFrame(scan.info, static_cast<Orientation>(plane), wish.placeMm, view.pixels(), wish.zoom);
    hand(desk, scan, view, static_cast<int>(plane), frame);
    draw.PushClipRect(at(view.from), at(view.from + view.size));
    draw.AddRectFilled(at(view.from), at(view.from + view.size), IM_COL32(0, 0, 0, 255));
    if (shown_ && !shown_->planes[plane].display.empty())
        draw.AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(textures_[plane])),
                      at(view.from), at(view.from + view.size));
    const glm::dvec2 cross =
        view.from + frame.pictureFromPatient(desk.slices().placeMm + scan.shift) / view.pixelsPerUnit;
    // A line is the plane that it stands for: axial, coronal, sagittal.
    const std::size_t across = plane == 0 ? 1 : 0, along = plane == 2 ? 1 : 2;
    draw.AddLine(at({view.from.x, cross.y}), at({view.from.x + view.size.x, cross.y}), kLine[across]);
    draw.AddLine(at({cross.x, view.from.y}), at({cross.x, view.from.y + view.size.y}), kLine[along]);
    if (!scan.beside) {
        for (const Measurement& m : desk.scene().measurements)
            drawMeasurement(draw, m, desk.describe(m), view, frame);
        scan.endoscopy->drawOnPlane(draw, view, frame);
    }
    draw.AddRect(at(view.from), at(view.from + view.size - 1.0), kLine[plane]);
    if (scan.info.orientationKnown) {
        const glm::dvec2 middle = view.from + 0.5 * view.size;
        const glm::dvec3 corner = frame.patientFromPicture({0, 0}),
                         right = frame.patientFromPicture({1, 0}) - corner,
                         down = frame.patientFromPicture({0, 1}) - corner;
        const auto write = [&](const glm::dvec2& place, const glm::dvec3& towards) {
            draw.AddText(at(place), kPlaneText, directionLetters(towards).c_str());
        };
        write({view.from.x + 5, middle.y - 7}, -right);
        write({view.from.x + view.size.x - 14, middle.y - 7}, right);
        write({middle.x - 4, view.from.y + 3}, -down);
        write({middle.x - 4, view.from.y + view.size.y - 18}, down);
    }
    if ((plane == 0 || desk.enlargedPlane >= 0) && shown_) {
        const GreyWindow& window = shown_->wish.window;
        const std::string windowText = "C " + numberText(window.centre) + " W " + numberText(window.width);
        std::string value = std::isfinite(shown_->value) ? valueText(shown_->value, scan.info.unit) : "";
        const std::string both = value + (value.empty() ? "" : "   ") + windowText;
        const bool narrow = static_cast<double>(ImGui::CalcTextSize(both.c_str()).x) > view.size.x - 10;
        draw.AddText(at({view.from.x + 5, view.from.y + 18}), kPlaneText,
                     (scan.name + (scan.name.empty() ? "" : "\n") +
                      (narrow && !value.empty() ? value + "\n" + windowText : both))
                         .c_str());
    }
    FigurePart scale;
    scale.annotations.scaleBar = true;
    scale.camera.projection = Projection::parallel;
    scale.camera.parallelScale = parallelScaleOf(frame.mmPerPixel, view.pixels());
    drawPart(draw, view, std::move(scale), kRowOfWords);
    if (shown_ && !shown_->fine)
        draw.AddText(at({view.from.x + 5, view.from.y + view.size.y - 18}), IM_COL32(255, 190, 70, 255),
                     "coarse");
    draw.PopClipRect();
}

} // namespace tessera
