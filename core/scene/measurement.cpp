// core/scene/measurement.cpp: see measurement.h.
#include "core/scene/measurement.h"

#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <numbers>

namespace tessera {
namespace {

/// From the first point to the middle of the circle through three; false where they lie on a line.
bool fromFirstToCentre(const std::vector<glm::dvec3>& p, glm::dvec3& way) {
    const glm::dvec3 a = p[1] - p[0], b = p[2] - p[0], normal = glm::cross(a, b);
    const double twice = 2 * glm::dot(normal, normal);
    if (!(twice > 1e-18 * glm::dot(a, a) * glm::dot(b, b)))
        return false;
    way = (glm::dot(b, b) * glm::cross(normal, a) + glm::dot(a, a) * glm::cross(b, normal)) / twice;
    return true;
}

} // namespace

std::size_t pointsOf(MeasurementKind kind) {
    return kind == MeasurementKind::distance ? 2 : 3;
}

template <> const NameTable<MeasurementKind>& namesOf<MeasurementKind>() {
    static const NameTable<MeasurementKind> names{{{MeasurementKind::distance, "distance"},
                                                   {MeasurementKind::angle, "angle"},
                                                   {MeasurementKind::circle, "circle"}}};
    return names;
}

double valueOf(const Measurement& m) {
    if (m.points.size() != pointsOf(m.kind))
        return std::numeric_limits<double>::quiet_NaN();
    switch (m.kind) {
    case MeasurementKind::distance:
        return glm::length(m.points[1] - m.points[0]);
    case MeasurementKind::angle: {
        // By both sine and cosine, so that small and flat angles are as exact as others.
        const glm::dvec3 a = m.points[0] - m.points[1], b = m.points[2] - m.points[1];
        if (glm::dot(a, a) == 0 || glm::dot(b, b) == 0)
            break;
        return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
    }
    case MeasurementKind::circle: {
        glm::dvec3 way(0);
        return fromFirstToCentre(m.points, way) ? glm::length(way) : std::numeric_limits<double>::infinity();
    }
    }
    return std::numeric_limits<double>::quiet_NaN();
}

glm::dvec3 circleCentre(const Measurement& circle) {
    glm::dvec3 way(0);
    return fromFirstToCentre(circle.points, way) ? circle.points[0] + way
                                                 : 0.5 * (circle.points[0] + circle.points[2]);
}

std::string describe(const Measurement& m) {
    const double value = valueOf(m);
    if (!std::isfinite(value))
        return m.kind == MeasurementKind::circle && m.points.size() == 3 ? "no circle: a line" : "not whole";
    char text[96];
    if (m.kind == MeasurementKind::distance)
        std::snprintf(text, sizeof text, "%.1f mm", value);
    else if (m.kind == MeasurementKind::angle)
        std::snprintf(text, sizeof text, "%.1f deg", value);
    else
        std::snprintf(text, sizeof text, "radius %.1f mm, area %.0f mm2", value,
                      std::numbers::pi * value * value);
    return text;
}

namespace {

constexpr double kLargestShare = 0.25; // of the picture's width
constexpr double kMmPerMetre = 1000, kMetresFrom = 10000;
constexpr int kGlyphWidth = 5, kGlyphHeight = 7, kPitch = kGlyphWidth + 1;

/// The glyphs; one byte per row, its lowest five bits from left to right.
struct Glyph {
    char letter;
    std::array<std::uint8_t, kGlyphHeight> rows;
};
constexpr Glyph kGlyphs[] = {
    {'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}}, {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f}}, {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}}, {'-', {0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00}},
    {'+', {0x00, 0x04, 0x04, 0x1f, 0x04, 0x04, 0x00}}, {'a', {0x00, 0x00, 0x0e, 0x01, 0x0f, 0x11, 0x0f}},
    {'c', {0x00, 0x00, 0x0e, 0x10, 0x10, 0x11, 0x0e}}, {'e', {0x00, 0x00, 0x0e, 0x11, 0x1f, 0x10, 0x0e}},
    {'h', {0x10, 0x10, 0x16, 0x19, 0x11, 0x11, 0x11}}, {'m', {0x00, 0x00, 0x1a, 0x15, 0x15, 0x15, 0x15}},
    {'n', {0x00, 0x00, 0x16, 0x19, 0x11, 0x11, 0x11}}, {'r', {0x00, 0x00, 0x16, 0x19, 0x10, 0x10, 0x10}},
    {'t', {0x08, 0x08, 0x1c, 0x08, 0x08, 0x09, 0x06}}};

/// A picture that is drawn on; what lies outside of it is left out.
class Pen {
  public:
    Pen(Image& image, const glm::vec4& colour) : image_(image), colour_(colour) {}
    /// Of whole pixels, [from, to).
    void fill(const glm::ivec2& from, const glm::ivec2& to) {
        for (int y = std::max(0, from.y); y < std::min(image_.size.y, to.y); ++y)
            for (int x = std::max(0, from.x); x < std::min(image_.size.x, to.x); ++x)
                image_.at(x, y) = colour_;
    }

  private:
    Image& image_;
    glm::vec4 colour_;
};

/// @param unit  pixels of a glyph's dot
/// @param more  that every dot is larger on each side
void write(Pen& pen, glm::ivec2 at, const std::string& text, int unit, int more) {
    for (const char letter : text) {
        for (const Glyph& glyph : kGlyphs)
            for (int y = 0; glyph.letter == letter && y < kGlyphHeight; ++y)
                for (int x = 0; x < kGlyphWidth; ++x)
                    if (glyph.rows[static_cast<std::size_t>(y)] >> (kGlyphWidth - 1 - x) & 1) {
                        const glm::ivec2 dot = at + unit * glm::ivec2(x, y);
                        pen.fill(dot - more, dot + unit + more);
                    }
        at.x += unit * kPitch;
    }
}

} // namespace

double roundLength(double mm) {
    if (!(mm > 0) || !std::isfinite(mm))
        return 1;
    const double power = std::pow(10.0, std::floor(std::log10(mm)));
    for (const double part : {5.0, 2.0})
        if (part * power <= mm)
            return part * power;
    return power;
}

std::string ScaleBar::text() const {
    const bool metres = mm >= kMetresFrom;
    return numberText(metres ? mm / kMmPerMetre : mm) + (metres ? " m" : " mm") +
           (everywhere ? "" : " at the centre");
}

ScaleBar scaleBarOf(double mmPerPixel, double width) {
    ScaleBar bar;
    bar.mm = roundLength(kLargestShare * width * mmPerPixel);
    bar.pixels = bar.mm / mmPerPixel;
    return bar;
}

ScaleBar scaleBarOf(const Camera& camera, const glm::ivec2& imageSize) {
    const bool parallel = camera.projection == Projection::parallel;
    const double half = parallel ? camera.parallelScale // of the picture's height, mm
                                 : glm::length(camera.focalPoint - camera.position) *
                                       std::tan(glm::radians(camera.viewAngle) / 2);
    ScaleBar bar = scaleBarOf(2 * half / imageSize.y, imageSize.x);
    bar.everywhere = parallel;
    return bar;
}

void drawScaleBar(Image& image, const ScaleBar& bar) {
    constexpr double kPixelsPerUnit = 300; // of the picture's height
    const std::string text = bar.text();
    int unit = std::max(1, static_cast<int>(std::lround(image.size.y / kPixelsPerUnit)));
    const auto textWidth = [&] { return unit * kPitch * static_cast<int>(text.size()); };
    while (unit > 1 && textWidth() > image.size.x * 3 / 4)
        --unit;
    const int margin = 6 * unit, end = 2 * unit; // end: half a mark's height
    const int length = static_cast<int>(std::lround(bar.pixels));
    const glm::ivec2 right = image.size - margin; // of the bar, its lower edge
    const glm::ivec2 label(right.x - std::max(textWidth() - unit, 0), right.y - 2 * end - unit * 9);
    for (const bool edge : {true, false}) {
        const int more = edge ? std::max(1, unit / 2) : 0;
        Pen pen(image, edge ? glm::vec4(0, 0, 0, 1) : glm::vec4(1));
        const auto fill = [&](const glm::ivec2& from, const glm::ivec2& to) {
            pen.fill(from - more, to + more);
        };
        const int left = right.x - length, y = right.y - end;
        fill({left, y - unit / 2}, {right.x, y - unit / 2 + unit});
        for (const int x : {left, right.x - unit})
            fill({x, y - end}, {x + unit, y + end});
        write(pen, label, text, unit, more);
    }
}

} // namespace tessera
