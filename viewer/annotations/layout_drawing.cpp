// viewer/annotations/layout_drawing.cpp: see layout_drawing.h.
#include "viewer/annotations/layout_drawing.h"

#include "core/image/colour.h"

#include <algorithm>
#include <cairo.h>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <variant>
#include <vector>

namespace tessera {
namespace {

struct Bounds {
    glm::dvec2 from{std::numeric_limits<double>::infinity()}, to{-std::numeric_limits<double>::infinity()};
    void add(const glm::dvec2& p) { from = glm::min(from, p), to = glm::max(to, p); }
    bool meets(const glm::dvec2& a, const glm::dvec2& b) const {
        return from.x <= b.x && a.x <= to.x && from.y <= b.y && a.y <= to.y;
    }
};

Bounds boundsOf(const LaidShape& shape) {
    Bounds bounds;
    if (const auto* const area = std::get_if<LaidArea>(&shape)) {
        for (const glm::dvec2& corner : area->corners)
            bounds.add(corner);
        return bounds;
    }
    constexpr double kCorners = 10; // miters reach so many times half the width, at most
    const auto& lines = std::get<LaidLines>(shape);
    for (const std::vector<glm::dvec2>& points : lines.lines)
        for (const glm::dvec2& point : points)
            bounds.add(point);
    const double more = kCorners * (lines.width / 2 + lines.edge);
    bounds.from -= more, bounds.to += more;
    return bounds;
}

void trace(cairo_t* cairo, const std::vector<glm::dvec2>& points) {
    cairo_new_sub_path(cairo);
    for (const glm::dvec2& p : points)
        cairo_line_to(cairo, p.x, p.y);
    if (points.size() > 2 && points.front() == points.back())
        cairo_close_path(cairo);
}

void draw(cairo_t* cairo, const LaidArea& area) {
    const glm::dvec3 c = codeOfColour(area.colour);
    cairo_set_source_rgba(cairo, c.r, c.g, c.b, static_cast<double>(area.opacity));
    trace(cairo, area.corners);
    cairo_close_path(cairo);
    cairo_fill(cairo);
}

void draw(cairo_t* cairo, const LaidLines& lines) {
    const double ink = lines.ink == Ink::light ? 1 : 0;
    cairo_set_line_cap(cairo, CAIRO_LINE_CAP_BUTT);
    cairo_set_line_join(cairo, CAIRO_LINE_JOIN_MITER);
    if (lines.edge > 0) {
        for (const std::vector<glm::dvec2>& points : lengthened(lines))
            trace(cairo, points);
        cairo_set_source_rgb(cairo, 1 - ink, 1 - ink, 1 - ink);
        cairo_set_line_width(cairo, lines.width + 2 * lines.edge);
        cairo_stroke(cairo);
    }
    for (const std::vector<glm::dvec2>& points : lines.lines)
        trace(cairo, points);
    cairo_set_source_rgb(cairo, ink, ink, ink);
    cairo_set_line_width(cairo, lines.width);
    cairo_stroke(cairo);
}

bool meets(const LaidWords& words, const glm::dvec2& from, const glm::dvec2& to) {
    const double around = words.pixels; // letters may reach out of their box
    return Bounds{words.from() - around, words.to() + around}.meets(from, to);
}

} // namespace

glm::dvec3 codeOfColour(const glm::vec3& linear) {
    glm::dvec3 code(0);
    for (int c = 0; c < 3; ++c)
        code[c] =
            std::round(255 * srgbFromLinear(std::clamp(static_cast<double>(linear[c]), 0.0, 1.0))) / 255;
    return code;
}

std::vector<std::vector<glm::dvec2>> lengthened(const LaidLines& lines) {
    std::vector<std::vector<glm::dvec2>> all = lines.lines;
    for (std::vector<glm::dvec2>& points : all) {
        if (points.size() < 2 || points.front() == points.back())
            continue;
        const std::size_t n = points.size();
        const glm::dvec2 first = glm::normalize(points[0] - points[1]),
                         last = glm::normalize(points[n - 1] - points[n - 2]);
        points[0] += lines.edge * first;
        points[n - 1] += lines.edge * last;
    }
    return all;
}

void drawLayout(cairo_t* cairo, const FigureLayout& layout, PangoWords& words, const glm::dvec2& from,
                const glm::dvec2& to) {
    for (const LaidShape& shape : layout.shapes)
        if (boundsOf(shape).meets(from, to))
            std::visit([cairo](const auto& one) { draw(cairo, one); }, shape);
    for (const LaidWords& one : layout.words)
        if (meets(one, from, to))
            words.draw(cairo, one);
}

bool drawsWithin(const FigureLayout& layout, const glm::dvec2& from, const glm::dvec2& to) {
    return std::any_of(layout.shapes.begin(), layout.shapes.end(),
                       [&](const LaidShape& shape) { return boundsOf(shape).meets(from, to); }) ||
           std::any_of(layout.words.begin(), layout.words.end(),
                       [&](const LaidWords& one) { return meets(one, from, to); });
}

} // namespace tessera
