// viewer/window/endoscopy_panel.cpp: the panel of endoscopy.h, and what is drawn of lines over the picture.
#include "viewer/window/endoscopy.h"
#include "viewer/window/overlays.h" // pictureFromPatient

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <imgui.h>

namespace tessera {
namespace {

constexpr ImU32 kLineInk = IM_COL32(255, 110, 160, 220), kBranchInk = IM_COL32(255, 110, 160, 110),
                kHere = IM_COL32(255, 230, 90, 255), kUnseen = IM_COL32(90, 210, 255, 255),
                kCompassInk = IM_COL32(235, 235, 235, 110);
constexpr double kMapShare = 0.26; // of the picture's height
constexpr double kMapMargin = 12;
constexpr std::size_t kListedPatches = 12; // the largest

ImVec2 at(const glm::dvec2& p) {
    return {static_cast<float>(p.x), static_cast<float>(p.y)};
}

/// From the first line to this one.
std::vector<std::size_t> routeTo(const std::vector<CentreLine>& lines, std::size_t line) {
    std::vector<std::size_t> route = {line};
    while (lines[route.front()].parent)
        route.insert(route.begin(), *lines[route.front()].parent);
    return route;
}

} // namespace

void Endoscopy::searchPanel(Desk& desk) {
    if (searching_) {
        const LineState line = desk.viewing().line();
        ImGui::ProgressBar(static_cast<float>(line.share), {-60, 0}, line.what.c_str());
        ImGui::SameLine();
        if (ImGui::Button("stop"))
            desk.viewing().callOffLine();
        return;
    }
    const auto gather = [&](const char* name, bool tree) {
        if (ImGui::Button(name)) {
            places_.clear();
            gathers_ = desk.showSlices = true;
            tree_ = tree;
        }
    };
    gather("line: click its places", false);
    ImGui::SameLine();
    gather("tree: one click", true);
    if (gathers_) {
        ImGui::TextDisabled("click in the lumen, on the planes");
        if (!tree_) {
            ImGui::Text("%zu places", places_.size());
            ImGui::SameLine();
            if (ImGui::SmallButton("find (Enter)") && !places_.empty())
                find(desk, places_, false);
        }
    }
    if (!path_)
        return;
    ImGui::TextWrapped("%s", about_.c_str());
    if (path_->lumen && !places_.empty()) {
        auto value = static_cast<float>(threshold_.value_or(shownThreshold_));
        ImGui::SetNextItemWidth(110);
        if (ImGui::DragFloat("threshold", &value, 5, 0, 0, "%.0f"))
            threshold_ = static_cast<double>(value);
        if (threshold_) {
            ImGui::SameLine();
            if (ImGui::SmallButton("find again"))
                find(desk, places_, tree_);
        }
    }
}

void Endoscopy::flightPanel(Desk& desk) {
    Flight& flight = *path_->flight;
    if (ImGui::Button(playing_ ? "pause (Space)" : "fly (Space)"))
        play(desk, !playing_);
    ImGui::SameLine();
    if (ImGui::Button("look ahead (Home)") && curve_) {
        look_.reset();
        show(desk, false);
    }
    ImGui::SameLine();
    if (ImGui::Button("leave")) {
        playing_ = inside_ = false;
        look_.reset();
        desk.resetCamera();
    }
    auto place = static_cast<float>(placeMm_);
    if (ImGui::SliderFloat("place", &place, 0, static_cast<float>(curve_->lengthMm()), "%.0f mm"))
        flyTo(desk, static_cast<double>(place));
    auto speed = static_cast<float>(flight.speedMmPerS), angle = static_cast<float>(flight.viewAngle);
    if (ImGui::SliderFloat("speed", &speed, 1, 200, "%.0f mm/s"))
        flight.speedMmPerS = std::max(1.0, static_cast<double>(speed)), film_.reset();
    bool anew = false;
    if (ImGui::SliderFloat("view", &angle, 30, 150, "%.0f deg")) {
        flight.viewAngle = static_cast<double>(angle);
        anew = true;
    }
    bool backwards = flight.backwards;
    if (ImGui::Checkbox("backwards", &backwards)) {
        flight.backwards = backwards;
        path_->keyframes.clear(); // their order is the flight's
        placeMm_ = curve_->lengthMm() - placeMm_;
        anew = true;
    }
    if (path_->lines.size() > 1) {
        char name[32];
        std::snprintf(name, sizeof name, "branch %zu", flight.route.back());
        if (ImGui::BeginCombo("to", name)) {
            for (std::size_t i = 0; i < path_->lines.size(); ++i) {
                std::snprintf(name, sizeof name, "branch %zu", i);
                if (ImGui::Selectable(name, i == flight.route.back())) {
                    flight.route = routeTo(path_->lines, i);
                    flight.fromMm = 0;
                    flight.toMm.reset();
                    path_->keyframes.clear(); // they lie along the route of before
                    anew = true;
                }
            }
            ImGui::EndCombo();
        }
    }
    if (anew)
        flyAnew(desk);
}

void Endoscopy::keyframePanel(Desk& desk) {
    if (ImGui::Button("record keyframe"))
        record(desk);
    for (std::size_t i = 0; i < path_->keyframes.size(); ++i) {
        Keyframe& key = path_->keyframes[i];
        ImGui::PushID(static_cast<int>(i));
        auto mm = static_cast<float>(key.placeMm.value_or(0));
        // Between its neighbours: keyframes keep their order.
        const double first = path_->flight->fromMm, last = first + curve_->lengthMm();
        double low = i == 0 ? first : *path_->keyframes[i - 1].placeMm + 0.1,
               high = i + 1 == path_->keyframes.size() ? last : *path_->keyframes[i + 1].placeMm - 0.1;
        if (path_->flight->backwards) {
            low = i + 1 == path_->keyframes.size() ? first : *path_->keyframes[i + 1].placeMm + 0.1;
            high = i == 0 ? last : *path_->keyframes[i - 1].placeMm - 0.1;
        }
        ImGui::SetNextItemWidth(90);
        if (ImGui::DragFloat("##mm", &mm, 1, static_cast<float>(low), static_cast<float>(high), "%.0f mm") &&
            low < high)
            key.placeMm = std::clamp(static_cast<double>(mm), low, high), film_.reset();
        ImGui::SameLine();
        if (ImGui::SmallButton("go"))
            flyTo(desk, path_->flight->backwards ? last - *key.placeMm : *key.placeMm - first);
        ImGui::SameLine();
        const bool gone = ImGui::SmallButton("remove");
        ImGui::PopID();
        if (gone) {
            path_->keyframes.erase(path_->keyframes.begin() + static_cast<std::ptrdiff_t>(i));
            film_.reset();
            return;
        }
    }
}

void Endoscopy::coveragePanel(Desk& desk) {
    if (ImGui::Button("what is seen of the wall"))
        desk.trying([&] { measureCoverage(desk, bothWays_); });
    ImGui::SameLine();
    ImGui::Checkbox("there and back", &bothWays_);
    if (!coverage_)
        return;
    ImGui::TextWrapped("%s", coverageAbout_.c_str());
    for (std::size_t i = 0; i < unseen().size(); ++i) {
        const UnseenPatch& p = unseen()[i];
        ImGui::PushID(static_cast<int>(i));
        if (ImGui::SmallButton("look"))
            lookAtPatch(desk, i);
        ImGui::PopID();
        ImGui::SameLine();
        ImGui::Text("%.0f mm2 at %.0f mm", p.areaMm2, p.alongMm);
    }
}

void Endoscopy::panel(Desk& desk) {
    searchPanel(desk);
    if (path_ && curve_) {
        flightPanel(desk);
        keyframePanel(desk);
        if (!searching_)
            coveragePanel(desk);
    }
    ImGui::SetNextItemWidth(-110);
    ImGui::InputTextWithHint("##path", "path.json", file_, sizeof file_);
    const bool named = file_[0] != '\0';
    ImGui::SameLine();
    if (ImGui::Button("load") && named)
        desk.trying([&] { load(desk, file_); });
    ImGui::SameLine();
    if (ImGui::Button("save") && named)
        desk.trying([&] { save(desk, file_); });
}

/// Those that are listed.
std::span<const UnseenPatch> Endoscopy::unseen() const {
    if (!coverage_)
        return {};
    return std::span(coverage_->patches).first(std::min(coverage_->patches.size(), kListedPatches));
}

/// From outside, from the front: the volume's box, the lines, and where one is.
void Endoscopy::drawMap(ImDrawList& draw, const Desk& desk, const Area& area) const {
    const VolumeInfo& info = desk.volume()->info;
    glm::dvec3 low(1e30), high(-1e30);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 voxel =
            glm::dvec3(info.extentVoxels) * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
        const glm::dvec3 mm(info.patientFromVoxel * glm::dvec4(voxel, 1));
        low = glm::min(low, mm);
        high = glm::max(high, mm);
    }
    const double height = kMapShare * area.size.y, scale = height / (high.z - low.z),
                 width = scale * (high.x - low.x);
    const glm::dvec2 corner = area.from + glm::dvec2(kMapMargin, area.size.y - height - 3 * kMapMargin);
    const auto onMap = [&](const glm::dvec3& mm) {
        return corner + scale * glm::dvec2(mm.x - low.x, high.z - mm.z);
    };
    draw.AddRectFilled(at(corner), at(corner + glm::dvec2(width, height)), IM_COL32(10, 12, 16, 190));
    draw.AddRect(at(corner), at(corner + glm::dvec2(width, height)), kCompassInk);
    for (const CentreLine& line : path_->lines)
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
            draw.AddLine(at(onMap(line.points[i])), at(onMap(line.points[i + 1])), kLineInk, 1.2f);
    for (const UnseenPatch& patch : unseen())
        draw.AddCircle(at(onMap(patch.middleMm)), 2.5f, kUnseen);
    const Camera& camera = desk.camera();
    const glm::dvec2 here = onMap(camera.position);
    const glm::dvec3 forward = -patientFromCamera(camera)[2];
    draw.AddLine(at(here), at(here + 12.0 * glm::dvec2(forward.x, -forward.z)), kHere, 2);
    draw.AddCircleFilled(at(here), 3.5f, kHere);
    if (info.orientationKnown) {
        draw.AddText(at(corner + glm::dvec2(3, height / 2 - 7)), kCompassInk, "R");
        draw.AddText(at(corner + glm::dvec2(width - 12, height / 2 - 7)), kCompassInk, "L");
    }
    char words[48];
    std::snprintf(words, sizeof words, "%.0f of %.0f mm", placeMm_, curve_->lengthMm());
    draw.AddText(at(corner + glm::dvec2(4, -18)), kHere, words);
}

void Endoscopy::drawOnPlane(ImDrawList& draw, const Area& view, const SliceFrame& frame) const {
    if (!path_)
        return;
    constexpr double kNearMm = 1.5;
    const auto near = [&](const glm::dvec3& p) {
        return std::abs(glm::dot(p - frame.pose.point, frame.pose.normal)) <= kNearMm;
    };
    const auto place = [&](const glm::dvec3& p) {
        return view.from + frame.pictureFromPatient(p) / view.pixelsPerUnit;
    };
    for (const CentreLine& line : path_->lines)
        for (std::size_t i = 0; i < line.points.size(); ++i)
            if (near(line.points[i])) {
                draw.AddCircleFilled(at(place(line.points[i])), 1.5f, kLineInk);
                if (i + 1 < line.points.size() && near(line.points[i + 1]))
                    draw.AddLine(at(place(line.points[i])), at(place(line.points[i + 1])), kLineInk, 1.5f);
            }
    for (const UnseenPatch& patch : unseen())
        if (near(patch.middleMm))
            draw.AddCircle(at(place(patch.middleMm)), 4, kUnseen, 0, 1.5f);
}

void Endoscopy::draw(Desk& desk, const Area& area) const {
    if (!desk.volume())
        return;
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    draw.PushClipRect(at(area.from), at(area.from + area.size));
    const auto seen = [&](const glm::dvec3& mm, glm::dvec2& out) {
        glm::dvec2 pixel(0);
        if (!pictureFromPatient(desk.camera(), area.pixels(), mm, pixel))
            return false;
        out = area.from + pixel / area.pixelsPerUnit;
        return true;
    };
    glm::dvec2 a(0), b(0);
    if (path_ && !inside_)
        for (std::size_t n = 0; n < path_->lines.size(); ++n) {
            const auto& route = path_->flight->route;
            const bool flown = std::find(route.begin(), route.end(), n) != route.end();
            const auto& points = path_->lines[n].points;
            for (std::size_t i = 0; i + 1 < points.size(); ++i)
                if (seen(points[i], a) && seen(points[i + 1], b))
                    draw.AddLine(at(a), at(b), flown ? kLineInk : kBranchInk, 2);
        }
    for (const UnseenPatch& patch : unseen())
        if (seen(patch.middleMm, a))
            draw.AddCircle(at(a), 5, kUnseen, 0, 1.5f);
    for (const glm::dvec3& place : places_)
        if (gathers_ && seen(place, a))
            draw.AddCircleFilled(at(a), 4, kHere);
    if (inside_ && path_ && curve_)
        drawMap(draw, desk, area);
    draw.PopClipRect();
}

} // namespace tessera
