// viewer/annotations/part_layout.cpp: see part_layout.h.
#include "viewer/annotations/part_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <utility>
#include <variant>

namespace tessera {
namespace {

constexpr double kMostOfHeight = 12, kMostOfWidth = 16; // parts of the box that letters may have

} // namespace

double letterPixels(const FigurePart& part, double dpi) {
    const double most = std::min(part.size.y / kMostOfHeight, part.size.x / kMostOfWidth);
    return std::min(part.annotations.textPoints * dpi / kPointsPerInch, std::max(kLeastPixels, most));
}

void LaidBlock::write(LaidWords line, const glm::dvec2& at) {
    line.at = {at.x + line.edge, at.y + line.edge + line.size.ascent};
    words.push_back(std::move(line));
}

void LaidBlock::move(const glm::dvec2& by) {
    for (LaidShape& shape : shapes) {
        if (auto* const lines = std::get_if<LaidLines>(&shape)) {
            for (std::vector<glm::dvec2>& points : lines->lines)
                for (glm::dvec2& point : points)
                    point += by;
        } else {
            for (glm::dvec2& corner : std::get<LaidArea>(shape).corners)
                corner += by;
        }
    }
    for (LaidWords& line : words)
        line.at += by;
}

PartLayout::PartLayout(const FigurePart& p, double figureDpi, const MeasureWords& measure, FigureLayout& out,
                       Room room)
    : part(p), dpi(figureDpi), em(letterPixels(p, figureDpi)), edge(std::max(1.0, 0.1 * em)), gap(0.3 * em),
      margin(std::max(2.0, 0.4 * em)), stroke(std::max(1.0, std::round(em / 8))),
      ink((room == Room::strips ? p.stripsAreLight : p.onLight) ? Ink::dark : Ink::light),
      from(room == Room::strips ? glm::dvec2(p.from - p.strips.corner()) : glm::dvec2(p.from) + margin),
      to(room == Room::strips ? glm::dvec2(p.from - p.strips.corner() + p.size + p.strips.size())
                              : glm::dvec2(p.from + p.size) - margin),
      extent_(room == Room::strips ? glm::dvec2(p.size) - 2 * margin : to - from), measure_(measure),
      out_(out) {
    if (room == Room::strips)
        taken_.push_back({glm::dvec2(p.from), glm::dvec2(p.from + p.size)});
}

LaidWords PartLayout::line(const std::string& words, double size, bool bold) const {
    LaidWords line;
    line.words = words;
    line.pixels = size * em;
    line.edge = edge;
    line.size = measure_(words, line.pixels, bold);
    line.bold = bold;
    line.ink = ink;
    return line;
}

bool PartLayout::isFree(const glm::dvec2& corner, const glm::dvec2& size) const {
    constexpr double kRounding = 1e-6;
    const glm::dvec2 end = corner + size;
    if (corner.x < from.x - kRounding || corner.y < from.y - kRounding || end.x > to.x + kRounding ||
        end.y > to.y + kRounding)
        return false;
    return std::none_of(taken_.begin(), taken_.end(), [&](const Taken& t) {
        return corner.x < t.to.x && t.from.x < end.x && corner.y < t.to.y && t.from.y < end.y;
    });
}

namespace {
/// Whole pixels, for sharp lines, to either side where the margin asks for one.
std::array<glm::dvec2, 3> wholeCorners(const glm::dvec2& wanted) {
    return {glm::floor(wanted), glm::ceil(wanted), wanted};
}
} // namespace

bool PartLayout::hasRoom(const glm::dvec2& corner, const glm::dvec2& size) const {
    return std::ranges::any_of(wholeCorners(corner),
                               [&](const glm::dvec2& whole) { return isFree(whole, size); });
}

bool PartLayout::place(LaidBlock block, const std::vector<glm::dvec2>& corners, const std::string& what) {
    for (const glm::dvec2& wanted : corners)
        for (const glm::dvec2& corner : wholeCorners(wanted))
            if (isFree(corner, block.size)) {
                block.move(corner);
                const glm::dvec2 beside(gap, 0); // or two lines are read as one
                taken_.push_back({corner - beside, corner + block.size + beside});
                for (LaidShape& shape : block.shapes)
                    out_.shapes.push_back(std::move(shape));
                for (LaidWords& line : block.words)
                    out_.words.push_back(std::move(line));
                if (!block.cut.empty())
                    leaveOut("the end of " + block.cut);
                return true;
            }
    leaveOut(what);
    return false;
}

void PartLayout::leaveOut(const std::string& what) {
    out_.leftOut.push_back(what);
}

std::vector<glm::dvec2> PartLayout::slide(const glm::dvec2& first, int towards) const {
    std::vector<glm::dvec2> corners{first};
    const double step = std::max(1.0, 0.5 * em); // positive, whatever the letters
    for (double by = step; by < height(); by += step) {
        if (towards >= 0)
            corners.push_back({first.x, first.y + by});
        if (towards <= 0)
            corners.push_back({first.x, first.y - by});
    }
    return corners;
}

} // namespace tessera
