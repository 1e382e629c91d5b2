// viewer/window/endoscopy_panel.cpp: the panel of endoscopy.h, and its question before a line is flown that
// may have left the lumen.
#include "viewer/window/endoscopy.h"

#include "core/animation/path.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <imgui.h>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t kListedPatches = 12; // the largest

/// From the first line to this one.
std::vector<std::size_t> routeTo(const std::vector<CentreLine>& lines, std::size_t line) {
    std::vector<std::size_t> route = {line};
    while (lines[route.front()].parent)
        route.insert(route.begin(), *lines[route.front()].parent);
    return route;
}

} // namespace

void Endoscopy::searchPanel(WindowState& desk) {
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
    gather("line: click its points", false);
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

void Endoscopy::flightPanel(WindowState& desk) {
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
                    path_->keyframes.clear(); // they belong to the previous route
                    anew = true;
                }
            }
            ImGui::EndCombo();
        }
    }
    if (anew)
        flyAnew(desk);
}

void Endoscopy::keyframePanel(WindowState& desk) {
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

void Endoscopy::coveragePanel(WindowState& desk) {
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

void Endoscopy::panel(WindowState& desk) {
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

/// The listed patches.
std::span<const UnseenPatch> Endoscopy::unseen() const {
    if (!coverage_)
        return {};
    return std::span(coverage_->patches).first(std::min(coverage_->patches.size(), kListedPatches));
}

namespace {

constexpr double kLeastFlightMm = 1; // shorter flights are not offered

} // namespace

/// The reason why the line may leave the lumen; empty: no indication.
std::string Endoscopy::doubt() const {
    return path_ && path_->lumen ? doubtText(*path_->lumen) : "";
}

/// The end of the flight that stays in the lumen, along its route; none: unknown.
std::optional<double> Endoscopy::stopMm() const {
    if (!path_ || !path_->lumen || path_->flight->route.size() != 1 || path_->flight->route.front() != 0)
        return std::nullopt;
    const std::optional<double> leaves = path_->lumen->leavesAtMm;
    return leaves && *leaves >= path_->flight->fromMm + kLeastFlightMm ? leaves : std::nullopt;
}

/// Asks the user if necessary, and halts meanwhile.
bool Endoscopy::mayFly() {
    if (inside_ || trusted_ || doubt().empty())
        return true;
    question_ = Question{playing_};
    playing_ = false;
    return false;
}

void Endoscopy::answer(WindowState& desk, Answer answer) {
    if (!question_)
        return;
    const bool plays = std::exchange(question_, std::nullopt)->plays;
    if (answer == Answer::cancel)
        return;
    trusted_ = true;
    if (answer == Answer::stop)
        if (const std::optional<double> stop = stopMm()) {
            path_->flight->toMm = *stop;
            flyAnew(desk);
        }
    if (plays)
        play(desk, true);
    else
        flyTo(desk, placeMm_);
}

void Endoscopy::drawQuestion(WindowState& desk, const Area& area) {
    if (!question_)
        return;
    const glm::dvec2 middle = area.from + 0.5 * area.size;
    ImGui::SetNextWindowPos({static_cast<float>(middle.x), static_cast<float>(middle.y)}, ImGuiCond_Always,
                            {0.5f, 0.5f});
    ImGui::Begin("##question", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                     ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoMove);
    ImGui::TextUnformatted(doubt().c_str());
    std::optional<Answer> given;
    if (ImGui::Button("fly anyway"))
        given = Answer::fly;
    ImGui::SameLine();
    if (const std::optional<double> stop = stopMm()) {
        if (ImGui::Button(("stop at " + mmText(*stop)).c_str()))
            given = Answer::stop;
        ImGui::SameLine();
    }
    if (ImGui::Button("cancel (Esc)"))
        given = Answer::cancel;
    ImGui::End();
    if (given)
        answer(desk, *given);
}

} // namespace tessera
