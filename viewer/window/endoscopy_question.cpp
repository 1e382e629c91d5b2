// viewer/window/endoscopy_question.cpp: endoscopy.h's question before a line is flown that may have left the
// lumen.
#include "viewer/window/endoscopy.h"

#include "core/animation/path.h"
#include "core/base/shown_text.h"

#include <imgui.h>
#include <utility>

namespace tessera {
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
