// viewer/annotations/mark_layout.cpp: measurements and arrows of a part, for part_layout.h, where its camera
// sees them.
#include "core/base/shown_text.h"
#include "core/scene/measurement.h"
#include "viewer/annotations/part_layout.h"
#include "viewer/session/view_geometry.h" // pictureFromPatient

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera {
namespace {

/// A place in the part's box; none: not there.
std::optional<glm::dvec2> seen(const FigurePart& part, const glm::dvec3& mm) {
    glm::dvec2 pixel(0);
    if (!pictureFromPatient(part.camera, part.size, mm, pixel) || pixel.x < 0 || pixel.y < 0 ||
        pixel.x > part.size.x || pixel.y > part.size.y)
        return std::nullopt;
    return glm::dvec2(part.from) + pixel;
}

/// False beside the slice that the part shows, if it is one.
bool liesIn(const FigurePart& part, const glm::dvec3& mm) {
    return !part.plane ||
           std::abs(glm::dot(mm - part.plane->point, part.plane->normal)) <= part.plane->halfMm;
}

/// The part of a line that lies in a box; false: none.
bool clip(glm::dvec2& a, glm::dvec2& b, const glm::dvec2& from, const glm::dvec2& to) {
    double first = 0, last = 1; // parts of the way (Liang and Barsky 1984)
    const glm::dvec2 way = b - a;
    for (int axis = 0; axis < 2; ++axis)
        for (const auto& [slope, room] :
             {std::pair(-way[axis], a[axis] - from[axis]), std::pair(way[axis], to[axis] - a[axis])}) {
            if (slope == 0 && room < 0)
                return false;
            if (slope < 0)
                first = std::max(first, room / slope);
            else if (slope > 0)
                last = std::min(last, room / slope);
        }
    if (!(first <= last))
        return false;
    b = a + last * way;
    a += first * way;
    return true;
}

/// The part of a line in the patient that the camera sees, in the figure; added where there is any.
/// @param edge  room that the line's own width takes
void addLine(std::vector<std::vector<glm::dvec2>>& lines, const FigurePart& part, glm::dvec3 a, glm::dvec3 b,
             double edge) {
    constexpr double kNearest = 1e-3; // before a perspective eye, parts of its distance
    if (part.camera.projection == Projection::perspective) {
        const glm::dvec3 towards = patientFromCamera(part.camera)[2];
        const double least = kNearest * focalDistanceMm(part.camera);
        const double depthA = glm::dot(part.camera.position - a, towards),
                     depthB = glm::dot(part.camera.position - b, towards);
        if (depthA < least && depthB < least)
            return;
        const glm::dvec3 way = b - a;
        if (depthA < least)
            a += (least - depthA) / (depthB - depthA) * way;
        else if (depthB < least)
            b = a + (least - depthA) / (depthB - depthA) * way;
    }
    glm::dvec2 p(0), q(0);
    if (!pictureFromPatient(part.camera, part.size, a, p) ||
        !pictureFromPatient(part.camera, part.size, b, q))
        return;
    const glm::dvec2 corner(part.from);
    if (clip(p, q, glm::dvec2(edge), glm::dvec2(part.size) - edge) && p != q)
        lines.push_back({corner + p, corner + q});
}

/// Points of a circle through three, the first again at the end.
std::vector<glm::dvec3> circlePoints(const Measurement& circle) {
    constexpr int kPieces = 72;
    const std::vector<glm::dvec3>& p = circle.points;
    const glm::dvec3 centre = circleCentre(circle), u = p[0] - centre;
    const glm::dvec3 v = glm::cross(glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0])), u);
    std::vector<glm::dvec3> points;
    for (int i = 0; i <= kPieces; ++i) {
        const double angle = 2 * std::numbers::pi * i / kPieces;
        points.push_back(centre + std::cos(angle) * u + std::sin(angle) * v);
    }
    return points;
}

LaidLines strokeOf(const PartLayout& in) {
    LaidLines lines;
    lines.width = in.stroke;
    lines.edge = in.edge;
    lines.ink = in.ink;
    return lines;
}

/// Corners of a box beside a point: to its right and left, above and below, near before far.
std::vector<glm::dvec2> beside(const glm::dvec2& point, const glm::dvec2& size, double em) {
    std::vector<glm::dvec2> corners;
    for (const double far : {0.7, 1.5, 3.0, 5.0})
        for (const glm::dvec2 side : {glm::dvec2(1, -1), {1, 1}, {-1, -1}, {-1, 1}, {0, -1}, {0, 1}})
            corners.push_back(point + side * (far * em + 0.5 * size) - 0.5 * size);
    return corners;
}

/// @param values  a second line; "" none
void layMeasurement(PartLayout& in, const Measurement& m, const std::string& values) {
    std::vector<glm::dvec3> points = m.points;
    if (!std::all_of(points.begin(), points.end(), [&](const glm::dvec3& p) { return liesIn(in.part, p); }))
        return in.leaveOut("the measurement " + describe(m) + ": it does not lie in the slice");
    const bool whole = std::isfinite(valueOf(m));
    if (m.kind == MeasurementKind::circle && whole)
        points = circlePoints(m);
    LaidLines stroke = strokeOf(in);
    for (std::size_t i = 0; i + 1 < points.size(); ++i)
        addLine(stroke.lines, in.part, points[i], points[i + 1], in.stroke / 2 + in.edge);
    if (stroke.lines.empty())
        return in.leaveOut("the measurement " + describe(m) + ": the picture does not show it");
    glm::dvec2 anchor = stroke.lines.front().front();
    if (const auto middle = seen(in.part, m.points[m.points.size() > 1 ? 1 : 0]))
        anchor = *middle;
    in.add(std::move(stroke));
    if (!whole)
        return;
    LaidBlock block;
    for (const std::string& words : {describe(m), values})
        if (!words.empty()) {
            const LaidWords line = in.line(words);
            block.write(line, {0, block.size.y});
            const glm::dvec2 box = PartLayout::boxOf(line);
            block.size = {std::max(block.size.x, box.x), block.size.y + box.y};
        }
    const std::vector<glm::dvec2> corners = beside(anchor, block.size, in.em);
    in.place(std::move(block), corners, "the words " + describe(m));
}

LaidBlock wordsOf(const PartLayout& in, const Arrow& arrow, const std::string& what) {
    constexpr double kWidest = 14; // letters
    constexpr std::size_t kMostLines = 3;
    LaidBlock block;
    const BrokenWords broken =
        brokenWords(printableLines(arrow.text), in.em, std::min(kWidest * in.em, 0.6 * in.width()),
                    kMostLines, in.measure());
    block.cut = broken.cut ? "the words of " + what : "";
    for (const std::string& text : broken.lines) {
        const LaidWords line = in.line(text);
        block.write(line, {0, block.size.y});
        block.size.x = std::max(block.size.x, PartLayout::boxOf(line).x);
        block.size.y += PartLayout::boxOf(line).y;
    }
    return block;
}

/// The shaft and the head's two sides, from the other end to the tip.
LaidLines arrowLines(const PartLayout& in, const glm::dvec2& end, const glm::dvec2& tip) {
    constexpr double kHead = 0.7, kHalfAngle = 0.42; // letters; radians
    LaidLines lines = strokeOf(in);
    const double length = glm::length(tip - end), head = std::min(kHead * in.em, length);
    const glm::dvec2 back = (end - tip) / length;
    lines.lines.push_back({end, tip});
    std::vector<glm::dvec2> sides;
    for (const double angle : {-kHalfAngle, kHalfAngle}) {
        const double c = std::cos(angle), s = std::sin(angle);
        sides.push_back(tip + head * glm::dvec2(c * back.x - s * back.y, s * back.x + c * back.y));
    }
    lines.lines.push_back({sides[0], tip, sides[1]});
    return lines;
}

bool holds(const PartLayout& in, const LaidLines& lines) {
    for (const std::vector<glm::dvec2>& points : lines.lines)
        for (const glm::dvec2& p : points)
            if (p.x < in.from.x || p.y < in.from.y || p.x > in.to.x || p.y > in.to.y)
                return false;
    return true;
}

void layArrow(PartLayout& in, const Arrow& arrow) {
    constexpr double kLeast = 0.5; // letters, of an arrow's length
    constexpr int kTurns = 8;
    const std::string what = "the arrow" + (arrow.text.empty() ? "" : " \"" + printable(arrow.text) + "\"");
    if (!liesIn(in.part, arrow.place))
        return in.leaveOut(what + ": its place does not lie in the slice");
    const std::optional<glm::dvec2> tip = seen(in.part, arrow.place);
    if (!tip)
        return in.leaveOut(what + ": the picture does not show its place");
    const glm::dvec2 asked = arrow.offset * (in.dpi / kPointsPerInch);
    const LaidBlock words = wordsOf(in, arrow, what);
    // As asked; else turned, shorter and longer.
    for (const double factor : {1.0, 0.6, 1.6})
        for (int turn = 0; turn < kTurns; ++turn) {
            const int eighths = (turn + 1) / 2 * (turn % 2 == 1 ? 1 : -1); // 0, 1, -1, 2, ...
            const double angle = eighths * std::numbers::pi / 4, c = std::cos(angle), s = std::sin(angle);
            const glm::dvec2 offset =
                factor * glm::dvec2(c * asked.x - s * asked.y, s * asked.x + c * asked.y);
            if (glm::length(offset) < kLeast * in.em)
                continue;
            const glm::dvec2 end = *tip + offset;
            LaidLines lines = arrowLines(in, end, *tip);
            const glm::dvec2 way = glm::normalize(offset), half = 0.5 * words.size;
            // The middle of the words lies on the arrow's line, their box touches its end.
            const double reach = std::min(way.x != 0 ? (half.x + in.gap) / std::abs(way.x) : 1e9,
                                          way.y != 0 ? (half.y + in.gap) / std::abs(way.y) : 1e9);
            const glm::dvec2 corner = end + reach * way - half;
            if (!holds(in, lines) || !(words.words.empty() || in.isFree(glm::floor(corner), words.size)))
                continue;
            in.add(std::move(lines));
            if (!words.words.empty())
                in.place(words, {corner}, what);
            else if (!words.cut.empty())
                in.leaveOut(words.cut);
            return;
        }
    in.leaveOut(what);
}

} // namespace

void layMeasurements(PartLayout& in) {
    if (in.part.annotations.measurements)
        for (std::size_t n = 0; n < in.part.measurements.size(); ++n)
            layMeasurement(in, in.part.measurements[n], n < in.part.values.size() ? in.part.values[n] : "");
}

void layArrows(PartLayout& in) {
    for (const Arrow& arrow : in.part.annotations.arrows)
        layArrow(in, arrow);
}

} // namespace tessera
