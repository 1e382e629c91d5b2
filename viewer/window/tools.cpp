// viewer/window/tools.cpp: see tools.h.
#include "viewer/window/tools.h"

#include "core/scene/measurement.h"
#include "viewer/session/view_geometry.h"
#include "viewer/window/boxes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <imgui.h>
#include <numbers>
#include <string>

namespace tessera {
namespace {

constexpr ImU32 kMeasureInk = IM_COL32(120, 220, 255, 255), kPending = IM_COL32(255, 210, 80, 255);
constexpr double kLeastMove = 4; // pixels between two corners of an outline
constexpr int kCirclePieces = 64;

} // namespace

void Tools::stop() {
    tool_ = Tool::none;
    pending_ = {};
    question_ = 0;
    outline_.clear();
    drawing_ = false;
}

void Tools::take(Tool tool) {
    const bool same = tool_ == tool;
    stop();
    tool_ = same ? Tool::none : tool;
}

void Tools::button(const char* name, Tool tool) {
    const bool on = tool_ == tool;
    if (on)
        ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
    if (ImGui::Button(name))
        take(tool);
    if (on)
        ImGui::PopStyleColor();
}

void Tools::panel(WindowState& desk) {
    button("distance (M)", Tool::distance);
    ImGui::SameLine();
    button("angle (G)", Tool::angle);
    ImGui::SameLine();
    button("circle (C)", Tool::circle);
    if (measures())
        ImGui::TextDisabled("click %zu points, in the volume or a plane",
                            pointsOf(pending_.kind) - pending_.points.size());
    Scene scene = desk.scene();
    for (std::size_t i = 0; i < scene.measurements.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        const bool gone = ImGui::SmallButton("remove");
        ImGui::SameLine();
        wrapped("%s", desk.describe(scene.measurements[i]).c_str());
        ImGui::PopID();
        if (gone) {
            desk.beginEdit();
            scene.measurements.erase(scene.measurements.begin() + static_cast<std::ptrdiff_t>(i));
            desk.setScene(scene, false);
            break;
        }
    }
}

void Tools::scissorsPanel(WindowState& desk) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted("scissors keep");
    ImGui::SameLine();
    button("inside", Tool::scissorsInside);
    ImGui::SameLine();
    button("outside (K)", Tool::scissorsOutside);
    if (tool_ == Tool::scissorsInside || tool_ == Tool::scissorsOutside)
        ImGui::TextDisabled("draw around it with the left button");
    Scene scene = desk.scene();
    for (std::size_t i = 0; i < scene.cuts.scissors.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        const bool gone = ImGui::SmallButton("remove");
        ImGui::SameLine();
        ImGui::Text("outline %zu, %s kept", i + 1,
                    scene.cuts.scissors[i].keep == Keep::inside ? "inside" : "outside");
        ImGui::PopID();
        if (gone) {
            desk.beginEdit();
            scene.cuts.scissors.erase(scene.cuts.scissors.begin() + static_cast<std::ptrdiff_t>(i));
            desk.setScene(scene, false);
            break;
        }
    }
}

bool Tools::placed(WindowState& desk, const glm::dvec3& mm) {
    if (!measures())
        return false;
    pending_.kind = tool_ == Tool::distance ? MeasurementKind::distance
                    : tool_ == Tool::angle  ? MeasurementKind::angle
                                            : MeasurementKind::circle;
    pending_.points.push_back(mm);
    if (pending_.points.size() == pointsOf(pending_.kind)) {
        Scene scene = desk.scene();
        scene.measurements.push_back(pending_);
        desk.beginEdit();
        desk.tell(tessera::describe(pending_));
        desk.setScene(scene, false);
        pending_ = {};
        tool_ = Tool::none;
    }
    return true;
}

bool Tools::handle(WindowState& desk, const Area& area) {
    if (tool_ == Tool::none || !desk.volume())
        return false;
    const ImGuiIO& io = ImGui::GetIO();
    const glm::dvec2 mouse(io.MousePos.x, io.MousePos.y), place = area.pictureFromWindow(mouse);
    const glm::dvec2 size(area.pixels());
    const bool over =
        !io.WantCaptureMouse && place.x >= 0 && place.y >= 0 && place.x < size.x && place.y < size.y;
    if (measures()) {
        pending_.kind = tool_ == Tool::distance ? MeasurementKind::distance
                        : tool_ == Tool::angle  ? MeasurementKind::angle
                                                : MeasurementKind::circle;
        if (over && ImGui::IsMouseClicked(0))
            question_ = desk.viewing().pick(place);
        if (const auto& picked = desk.picked(); question_ != 0 && picked && picked->number >= question_) {
            question_ = 0;
            if (picked->hit)
                placed(desk, picked->mm);
            else
                desk.tell("nothing is visible there");
        }
        return over && (ImGui::IsMouseDown(0) || ImGui::IsMouseReleased(0));
    }
    if (over && ImGui::IsMouseClicked(0)) {
        drawing_ = true;
        outline_ = {place};
    }
    if (!drawing_)
        return false;
    if (ImGui::IsMouseDown(0)) {
        if (glm::length(place - outline_.back()) >= kLeastMove && outline_.size() < Cuts::kMostPoints)
            outline_.push_back(place);
        return true;
    }
    drawing_ = false;
    if (outline_.size() < 3) {
        desk.tell("an outline needs an area");
    } else {
        Scissors cut;
        cut.camera = desk.camera();
        cut.aspect = size.x / size.y;
        cut.keep = tool_ == Tool::scissorsInside ? Keep::inside : Keep::outside;
        for (const glm::dvec2& p : outline_)
            cut.outline.push_back(p / size);
        Scene scene = desk.scene();
        if (scene.cuts.scissors.size() >= Cuts::kMostOfAKind) {
            desk.tell("no more than 16 outlines cut at once", true);
        } else {
            scene.cuts.scissors.push_back(std::move(cut));
            desk.beginEdit();
            desk.setScene(scene, false);
        }
    }
    stop();
    return true;
}

void Tools::draw(WindowState& desk, const Area& area) const {
    if (!desk.volume())
        return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const auto corner = area.from, end = area.from + area.size;
    draw.PushClipRect({static_cast<float>(corner.x), static_cast<float>(corner.y)},
                      {static_cast<float>(end.x), static_cast<float>(end.y)});
    const auto at = [&](const glm::dvec3& mm, ImVec2& out) {
        glm::dvec2 pixel(0);
        if (!pictureFromPatient(desk.camera(), area.pixels(), mm, pixel))
            return false;
        const glm::dvec2 p = area.from + pixel / area.pixelsPerUnit;
        out = {static_cast<float>(p.x), static_cast<float>(p.y)};
        return true;
    };
    const auto line = [&](const glm::dvec3& a, const glm::dvec3& b, ImU32 colour) {
        ImVec2 p, q;
        if (at(a, p) && at(b, q))
            draw.AddLine(p, q, colour, 1.5f);
    };
    const auto one = [&](const Measurement& m, ImU32 colour) {
        ImVec2 p;
        for (const glm::dvec3& point : m.points)
            if (at(point, p))
                draw.AddCircleFilled(p, 3, colour);
        const bool whole = m.points.size() == pointsOf(m.kind);
        if (m.kind != MeasurementKind::circle) {
            for (std::size_t i = 0; i + 1 < m.points.size(); ++i)
                line(m.points[i], m.points[i + 1], colour);
        } else if (whole && std::isfinite(valueOf(m))) {
            const glm::dvec3 centre = circleCentre(m), u = m.points[0] - centre;
            const glm::dvec3 normal =
                glm::normalize(glm::cross(m.points[1] - m.points[0], m.points[2] - m.points[0]));
            const glm::dvec3 v = glm::cross(normal, u);
            const auto on = [&](int i) {
                const double angle = 2 * std::numbers::pi * i / kCirclePieces;
                return centre + std::cos(angle) * u + std::sin(angle) * v;
            };
            for (int i = 0; i < kCirclePieces; ++i)
                line(on(i), on(i + 1), colour);
        }
        if (whole && at(m.points[1], p))
            drawLabel(draw, {p.x + 12, p.y - 16}, colour, desk.describe(m));
    };
    for (const Measurement& m : desk.scene().measurements)
        one(m, kMeasureInk);
    one(pending_, kPending);
    for (std::size_t i = 0; i + 1 < outline_.size(); ++i) {
        const glm::dvec2 a = area.from + outline_[i] / area.pixelsPerUnit,
                         b = area.from + outline_[i + 1] / area.pixelsPerUnit;
        draw.AddLine({static_cast<float>(a.x), static_cast<float>(a.y)},
                     {static_cast<float>(b.x), static_cast<float>(b.y)}, kPending, 1.5f);
    }
    draw.PopClipRect();
}

} // namespace tessera
