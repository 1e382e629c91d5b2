// viewer/window/boxes.cpp: see boxes.h.
#include "viewer/window/boxes.h"

#include "core/image/colour.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>

namespace tessera {

std::optional<std::string> nameBox(const char* label, const std::string& chosen,
                                   const std::vector<std::string>& names) {
    std::optional<std::string> taken;
    if (ImGui::BeginCombo(label, chosen.c_str(), ImGuiComboFlags_HeightLarge)) {
        for (const std::string& name : names)
            if (ImGui::Selectable(name.c_str(), name == chosen))
                taken = name;
        ImGui::EndCombo();
    }
    return taken;
}

std::optional<GreyWindow> windowBox(const GreyWindow& window, const ValueSummary& values, Mode mode,
                                    bool& began) {
    std::string chosen = "its own";
    for (const std::string& name : windowNames()) // the last match wins: it is more specific than "auto"
        if (windowOf(name, values, mode) == window)
            chosen = name;
    std::optional<GreyWindow> changed;
    if (const auto name = nameBox("window", chosen, windowNames())) {
        began = true;
        changed = windowOf(*name, values, mode);
    }
    float numbers[2] = {static_cast<float>(window.centre), static_cast<float>(window.width)};
    const ValueSummary measured = withoutFills(values);
    const double range = std::max(window.width, (measured.highest - measured.lowest) / 100);
    if (ImGui::DragFloat2("centre, width", numbers, static_cast<float>(range / 200), 0, 0,
                          formatFor(range)) &&
        numbers[1] > 0)
        changed = GreyWindow{static_cast<double>(numbers[0]), static_cast<double>(numbers[1])};
    began = began || ImGui::IsItemActivated();
    return changed;
}

const char* formatFor(double range) {
    constexpr const char* kFormats[] = {"%.0f", "%.1f", "%.2f", "%.3f", "%.4f"};
    if (!(range > 0))
        return "%.4g";
    const int decimals = static_cast<int>(std::ceil(2 - std::log10(range)));
    return decimals > 4 ? "%.4g" : kFormats[std::clamp(decimals, 0, 4)];
}

double roundStep(double least) {
    if (!(least > 0) || !std::isfinite(least))
        return 1;
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double part : {1.0, 2.0, 5.0})
        if (part * power >= least)
            return part * power;
    return 10 * power;
}

void wrapped(const char* format, ...) {
    va_list values;
    va_start(values, format);
    ImGui::TextWrappedV(format, values);
    va_end(values);
}

void drawLabel(ImDrawList& draw, const ImVec2& at, ImU32 colour, const std::string& words) {
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    draw.AddRectFilled({at.x - 4, at.y - 2}, {at.x + size.x + 4, at.y + size.y + 2},
                       IM_COL32(12, 14, 18, 205), 3);
    draw.AddText(at, colour, words.c_str());
}

bool eyeButton(EyeState state) {
    constexpr float kWide = 22, kHalf = 7, kRise = 6;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float height = ImGui::GetTextLineHeight();
    const bool clicked = ImGui::InvisibleButton("eye", {kWide, height});
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    if (ImGui::IsItemHovered())
        draw.AddRectFilled(at, {at.x + kWide, at.y + height}, ImGui::GetColorU32(ImGuiCol_ButtonHovered), 3);
    const ImU32 ink =
        ImGui::GetColorU32(state == EyeState::shut ? ImGuiCol_TextDisabled : ImGuiCol_Text, 0.9f);
    const ImVec2 middle(at.x + kWide / 2, at.y + height / 2);
    const ImVec2 left(middle.x - kHalf, middle.y), right(middle.x + kHalf, middle.y);
    for (const float rise : {-kRise, kRise})
        draw.AddBezierQuadratic(left, {middle.x, middle.y + rise}, right, ink, 1.2f);
    if (state == EyeState::open)
        draw.AddCircleFilled(middle, 2.3f, ink, 8);
    else if (state == EyeState::shut)
        draw.AddLine({left.x + 1, middle.y + 5}, {right.x - 1, middle.y - 5}, ink, 1.2f);
    ImGui::SameLine(0, 2);
    return clicked;
}

glm::vec3 screenRgb(const glm::dvec3& linear) {
    return {srgbFromLinear(linear.r), srgbFromLinear(linear.g), srgbFromLinear(linear.b)};
}

} // namespace tessera
