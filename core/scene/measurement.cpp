// core/scene/measurement.cpp: see measurement.h.
#include "core/scene/measurement.h"

#include "core/base/shown_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
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
        std::snprintf(text, sizeof text, "%.1f\u00b0", value);
    else
        std::snprintf(text, sizeof text, "radius %.1f mm, area %.0f mm\u00b2", value,
                      std::numbers::pi * value * value);
    return text;
}

namespace {

constexpr double kLargestShare = 0.25; // of the picture's width
constexpr double kMmPerMetre = 1000, kMetresFrom = 10000;

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

} // namespace tessera
