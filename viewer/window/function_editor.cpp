// viewer/window/function_editor.cpp: see function_editor.h.
#include "viewer/window/function_editor.h"

#include "core/base/shown_text.h"
#include "core/image/colour.h"
#include "core/scene/preset.h"
#include "viewer/window/boxes.h"
#include "viewer/window/function_edits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <imgui.h>

namespace tessera {
namespace {

constexpr float kHeight = 150, kColours = 14, kAxis = 18, kGrab = 7;

ImU32 screenColour(const glm::dvec3& linear, double alpha = 1) {
    const auto part = [](double x) { return static_cast<int>(std::lround(255 * srgbFromLinear(x))); };
    return IM_COL32(part(linear.r), part(linear.g), part(linear.b), static_cast<int>(255 * alpha));
}

/// Small opacities matter: the curve's height is their square root.
double heightOf(double opacity) {
    return std::sqrt(opacity);
}
double opacityAt(double height) {
    return height * height;
}

} // namespace

void FunctionEditor::presets(WindowState& desk) {
    if (ImGui::BeginCombo("preset", desk.presetName().c_str())) {
        const auto row = [&](const std::string& name) {
            if (ImGui::Selectable(name.c_str()))
                desk.trying([&] { desk.takePreset(name); });
        };
        for (const std::string& name : presetNames())
            row(name);
        const auto own = desk.ownPresets();
        if (!own.empty())
            ImGui::Separator();
        for (const std::string& name : own)
            row(name);
        ImGui::EndCombo();
    }
}

void FunctionEditor::files(WindowState& desk) {
    if (!ImGui::TreeNode("save as mine, import, export"))
        return;
    ImGui::SetNextItemWidth(-70);
    ImGui::InputTextWithHint("##name", "name or file", name_, sizeof name_);
    const bool named = name_[0] != '\0';
    const std::string name = name_;
    if (ImGui::Button("save as mine") && named)
        desk.trying([&] { desk.keepPreset(name); });
    ImGui::SameLine();
    if (ImGui::Button("import") && named)
        desk.trying([&] { desk.takePreset(name); });
    if (ImGui::Button("for Slicer") && named)
        desk.trying([&] { desk.writePreset(name + ".vp.json", "slicer"); });
    ImGui::SameLine();
    if (ImGui::Button("for ParaView") && named)
        desk.trying([&] { desk.writePreset(name + ".json", "paraview"); });
    ImGui::TreePop();
}

void FunctionEditor::curve(WindowState& desk) {
    const VolumeSeen& volume = *desk.volume();
    const TransferFunction& f = desk.function();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float width = std::max(120.0f, ImGui::GetContentRegionAvail().x);
    ImGui::InvisibleButton("curve", {width, kHeight + kColours + kAxis},
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    const bool over = ImGui::IsItemHovered(), active = ImGui::IsItemActive();
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(corner, {corner.x + width, corner.y + kHeight}, IM_COL32(18, 20, 24, 255));

    const auto xOf = [&](double value) {
        return corner.x + static_cast<float>((value - from_) / (to_ - from_)) * width;
    };
    const auto yOf = [&](double opacity) {
        return corner.y + (1 - static_cast<float>(heightOf(opacity))) * kHeight;
    };
    draw->PushClipRect(corner, {corner.x + width, corner.y + kHeight + kColours}, true);
    // The histogram, of logarithms.
    const std::vector<double>& counts = volume.histogram;
    const double most = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
    const double perBin =
        (volume.highest() - volume.lowest()) / static_cast<double>(std::max<std::size_t>(1, counts.size()));
    for (std::size_t i = 0; i < counts.size() && most > 0; ++i) {
        const double value = volume.lowest() + static_cast<double>(i) * perBin;
        const auto height = static_cast<float>(std::log1p(counts[i]) / std::log1p(most)) * kHeight;
        draw->AddRectFilled({xOf(value), corner.y + kHeight - height},
                            {xOf(value + perBin), corner.y + kHeight}, IM_COL32(70, 78, 92, 255));
    }
    // Opacity, coloured, and the colours below.
    const int columns = static_cast<int>(width);
    for (int x = 0; x < columns; ++x) {
        const double value = from_ + (to_ - from_) * (x + 0.5) / columns;
        const double opacity = -std::expm1(-f.extinction(value) * f.referenceLengthMm());
        const glm::dvec3 colour = f.colour(value);
        const float left = corner.x + static_cast<float>(x);
        draw->AddRectFilled({left, yOf(opacity)}, {left + 1, corner.y + kHeight}, screenColour(colour, 0.45));
        draw->AddRectFilled({left, corner.y + kHeight}, {left + 1, corner.y + kHeight + kColours},
                            screenColour(colour));
    }
    const std::vector<OpacityPoint>& points = f.opacityPoints();
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
        draw->AddLine({xOf(points[i].value), yOf(points[i].opacity)},
                      {xOf(points[i + 1].value), yOf(points[i + 1].opacity)}, IM_COL32(235, 235, 235, 255),
                      1.5f);
    for (std::size_t i = 0; i < points.size(); ++i)
        draw->AddCircleFilled({xOf(points[i].value), yOf(points[i].opacity)}, held_ == i ? 6.0f : 4.0f,
                              IM_COL32(255, 255, 255, 255));
    if (const auto& picked = desk.picked(); picked && picked->hit && picked->mesh.empty())
        draw->AddLine({xOf(picked->value), corner.y}, {xOf(picked->value), corner.y + kHeight},
                      IM_COL32(255, 210, 80, 160));
    draw->PopClipRect();
    axis(*draw, {corner.x, corner.y + kHeight + kColours}, width);

    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const double value =
        from_ + (to_ - from_) * std::clamp(static_cast<double>((mouse.x - corner.x) / width), 0.0, 1.0);
    const double opacity =
        opacityAt(std::clamp(1 - static_cast<double>((mouse.y - corner.y) / kHeight), 0.0, 1.0));
    std::optional<std::size_t> near;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (std::hypot(xOf(points[i].value) - mouse.x, yOf(points[i].opacity) - mouse.y) <= kGrab)
            near = i;
    if (over) {
        char text[96];
        std::snprintf(text, sizeof text, "%s: opacity %.3f per %.3g mm",
                      valueText(value, volume.info.unit).c_str(),
                      -std::expm1(-f.extinction(value) * f.referenceLengthMm()), f.referenceLengthMm());
        ImGui::SetTooltip("%s", text);
        if (near && ImGui::IsMouseDoubleClicked(0)) {
            coloured_ = *near;
            held_.reset();
            ImGui::OpenPopup("colour");
            return;
        }
        if (ImGui::IsMouseClicked(0)) {
            desk.beginEdit();
            if (near)
                held_ = near;
            else {
                std::size_t made = 0;
                const TransferFunction more = withNewPoint(f, value, opacity, made);
                held_ = made;
                desk.setFunction(more, true);
            }
        } else if (near && ImGui::IsMouseClicked(1)) {
            desk.beginEdit();
            desk.setFunction(withoutPoint(f, *near), false);
            held_.reset();
        }
    }
    if (held_ && active && ImGui::IsMouseDown(0)) {
        const ImVec2 moved = ImGui::GetIO().MouseDelta;
        if (moved.x != 0 || moved.y != 0)
            desk.setFunction(withPointAt(desk.function(), *held_, value, opacity), true);
    } else if (!ImGui::IsMouseDown(0)) {
        held_.reset();
    }
    // Nearer, at the pointer; the wheel alone goes through the panel.
    if (over && ImGui::GetIO().MouseWheel != 0 && ImGui::GetIO().KeyCtrl) {
        const double factor = std::exp2(-0.25 * static_cast<double>(ImGui::GetIO().MouseWheel));
        from_ = value + (from_ - value) * factor;
        to_ = value + (to_ - value) * factor;
        const double range = volume.highest() - volume.lowest();
        if (to_ - from_ > range || to_ - from_ < range / 1000)
            showAll(volume);
    }
}

void FunctionEditor::showAll(const VolumeSeen& volume) {
    from_ = volume.lowest();
    to_ = volume.highest() > from_ ? volume.highest() : from_ + 1;
}

/// Round values below the curve.
void FunctionEditor::axis(ImDrawList& draw, const ImVec2& corner, float width) const {
    constexpr double kPixelsApart = 55;
    const double step = roundStep((to_ - from_) * kPixelsApart / static_cast<double>(width));
    for (double value = std::ceil(from_ / step) * step; value <= to_; value += step) {
        const float x = corner.x + static_cast<float>((value - from_) / (to_ - from_)) * width;
        const std::string text = numberText(std::abs(value) < step / 1000 ? 0 : value);
        const float wide = ImGui::CalcTextSize(text.c_str()).x;
        draw.AddLine({x, corner.y}, {x, corner.y + 4}, IM_COL32(200, 200, 205, 255));
        draw.AddText({std::clamp(x - wide / 2, corner.x, corner.x + width - wide), corner.y + 3},
                     IM_COL32(200, 200, 205, 255), text.c_str());
    }
}

void FunctionEditor::colourOf(WindowState& desk) {
    if (!ImGui::BeginPopup("colour"))
        return;
    const auto& points = desk.function().opacityPoints();
    if (coloured_ < points.size()) {
        const double value = points[coloured_].value;
        const glm::dvec3 linear = desk.function().colour(value);
        float rgb[3];
        for (int c = 0; c < 3; ++c)
            rgb[c] = static_cast<float>(srgbFromLinear(linear[c]));
        if (ImGui::ColorPicker3("##colour", rgb)) {
            if (ImGui::IsItemActivated())
                desk.beginEdit();
            const glm::dvec3 colour(linearFromSrgb(static_cast<double>(rgb[0])),
                                    linearFromSrgb(static_cast<double>(rgb[1])),
                                    linearFromSrgb(static_cast<double>(rgb[2])));
            desk.setFunction(withColourAt(desk.function(), value, colour, (to_ - from_) / 200), true);
        }
    }
    ImGui::EndPopup();
}

void FunctionEditor::draw(WindowState& desk) {
    const VolumeSeen* const volume = desk.volume();
    if (!volume)
        return;
    if (of_ != volume) {
        of_ = volume;
        showAll(*volume);
        held_.reset();
    }
    presets(desk);
    ImGui::SameLine();
    if (ImGui::SmallButton("undo") && desk.history().canUndo())
        desk.undo();
    curve(desk);
    colourOf(desk);
    if (const std::size_t points = desk.function().gradientOpacity().points().size(); points > 0)
        ImGui::Text("and gradient opacity, %zu points", points);
    if (to_ - from_ < (volume->highest() - volume->lowest()) * (1 - 1e-9) && ImGui::SmallButton("all values"))
        showAll(*volume);
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    wrapped("drag points; click: new, right: remove, double: colour; Ctrl and wheel: zoom; Alt and drag in "
            "the picture: shift");
    ImGui::PopStyleColor();
    files(desk);
}

} // namespace tessera
