// viewer/window/part_drawing.cpp: see part_drawing.h.
#include "viewer/window/part_drawing.h"

#include "core/image/colour.h"
#include "viewer/annotations/figure_layout.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <imgui.h>
#include <string>
#include <variant>
#include <vector>

namespace tessera {
namespace {

constexpr double kLetterUnits = 14;

/// The camera of the middle rows of its picture.
/// @param share  of the picture's height
Camera middleOf(Camera camera, double share) {
    camera.parallelScale *= share;
    camera.viewAngle = glm::degrees(2 * std::atan(std::tan(glm::radians(camera.viewAngle) / 2) * share));
    return camera;
}

/// Draws a layout, whose places are pixels, in the screen's units.
class Painter {
  public:
    Painter(ImDrawList& draw, const Area& area) : draw_(draw), area_(area) {}

    void paint(const LaidLines& lines) const {
        for (const bool isEdge : {true, false}) {
            const double more = isEdge ? lines.edge : 0;
            if (isEdge && more == 0)
                continue;
            for (const std::vector<glm::dvec2>& line : lines.lines)
                for (std::size_t n = 1; n < line.size(); ++n)
                    segment(line[n - 1], line[n], lines.width + 2 * more, more, ink(lines.ink, isEdge));
        }
    }
    void paint(const LaidArea& area) const {
        std::vector<ImVec2> corners;
        for (const glm::dvec2& corner : area.corners)
            corners.push_back(at(corner));
        const auto code = [](float linear) {
            return static_cast<int>(
                std::lround(255 * srgbFromLinear(std::clamp(static_cast<double>(linear), 0.0, 1.0))));
        };
        const auto alpha = static_cast<int>(std::lround(255 * std::clamp(area.opacity, 0.0f, 1.0f)));
        draw_.AddConvexPolyFilled(
            corners.data(), static_cast<int>(corners.size()),
            IM_COL32(code(area.colour.r), code(area.colour.g), code(area.colour.b), alpha));
    }
    void paint(const LaidWords& words) const {
        const ImVec2 from = at({words.at.x, words.at.y - words.size.ascent});
        const auto size = static_cast<float>(words.pixels / area_.pixelsPerUnit);
        for (const ImVec2& by : {ImVec2(-1, -1), ImVec2(1, -1), ImVec2(-1, 1), ImVec2(1, 1)})
            draw_.AddText(ImGui::GetFont(), size, {from.x + by.x, from.y + by.y}, ink(words.ink, true),
                          words.words.c_str());
        draw_.AddText(ImGui::GetFont(), size, from, ink(words.ink, false), words.words.c_str());
    }

  private:
    static ImU32 ink(Ink ink, bool isEdge) {
        const bool light = (ink == Ink::light) != isEdge;
        return light ? IM_COL32(235, 235, 235, isEdge ? 200 : 255) : IM_COL32(0, 0, 0, isEdge ? 200 : 255);
    }
    ImVec2 at(const glm::dvec2& pixel) const {
        const glm::dvec2 place = area_.from + pixel / area_.pixelsPerUnit;
        return {static_cast<float>(place.x), static_cast<float>(place.y)};
    }
    /// Longer at either end, as an edge around it is.
    void segment(const glm::dvec2& a, const glm::dvec2& b, double width, double longer, ImU32 colour) const {
        const glm::dvec2 way = b - a;
        const glm::dvec2 along = glm::length(way) > 0 ? longer * glm::normalize(way) : glm::dvec2(0);
        draw_.AddLine(at(a - along), at(b + along), colour,
                      static_cast<float>(std::max(1.0, width / area_.pixelsPerUnit)));
    }

    ImDrawList& draw_;
    const Area& area_;
};

} // namespace

void drawPart(ImDrawList& draw, const Area& area, FigurePart part, double rows) {
    const glm::ivec2 size = area.pixels();
    const int free = static_cast<int>(std::lround(rows * area.pixelsPerUnit));
    const int height = size.y - 2 * free;
    if (height < 1)
        return;
    part.from = {0, free};
    part.size = {size.x, height};
    part.camera = middleOf(part.camera, static_cast<double>(height) / size.y);
    part.annotations.margin = AnnotationMargin::none; // a pane has no strips
    part.annotations.textPoints = kLetterUnits * area.pixelsPerUnit;
    Figure figure;
    figure.size = size;
    figure.dpi = kPointsPerInch;
    figure.parts = {std::move(part)};
    const auto measure = [&area](const std::string& words, double pixels, bool) { // one weight alone
        const ImFont& font = *ImGui::GetFont();
        const auto units = static_cast<float>(pixels / area.pixelsPerUnit);
        const ImVec2 box = font.CalcTextSizeA(units, FLT_MAX, 0, words.c_str());
        const double ascent = static_cast<double>(font.Ascent / font.FontSize) * pixels;
        return WordSize{static_cast<double>(box.x) * area.pixelsPerUnit, ascent, pixels - ascent};
    };
    const FigureLayout layout = layOut(figure, measure);
    const Painter painter(draw, area);
    for (const LaidShape& shape : layout.shapes)
        std::visit([&](const auto& one) { painter.paint(one); }, shape);
    for (const LaidWords& words : layout.words)
        painter.paint(words);
}

} // namespace tessera
