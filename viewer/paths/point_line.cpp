// viewer/paths/point_line.cpp: see point_line.h.
#include "viewer/paths/point_line.h"

#include "bricking/analysis/lumen/smooth_line.h"
#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace tessera {
namespace {

constexpr double kSpacingMm = 1, kLeastSpacingMm = 1.0 / 16, kFarthestMm = 1e7;

/// Points that differ from those before them.
PlacedPoints placesOf(const PlacedPoints& points, const std::string& where) {
    constexpr double kSamePlaceMm = 1e-6;
    PlacedPoints places;
    places.closed = points.closed;
    for (std::size_t i = 0; i < points.mm.size(); ++i) {
        const glm::dvec3& at = points.mm[i];
        for (int axis = 0; axis < 3; ++axis)
            if (!(std::abs(at[axis]) <= kFarthestMm))
                throw badFile(where, "coordinates of at most 1e7 mm",
                              std::to_string(at[axis]) + " of point " + std::to_string(i + 1));
        if (!places.mm.empty() && glm::length(at - places.mm.back()) <= kSamePlaceMm)
            continue;
        places.mm.push_back(at);
        if (!points.radiusMm.empty())
            places.radiusMm.push_back(points.radiusMm[i]);
    }
    if (places.mm.size() < CentreLine::kFewestPoints)
        throw badFile(where, "at least two points in different places", std::to_string(places.mm.size()));
    if (places.closed && glm::length(places.mm.front() - places.mm.back()) > kSamePlaceMm) {
        places.mm.push_back(places.mm.front());
        if (!places.radiusMm.empty())
            places.radiusMm.push_back(places.radiusMm.front());
    }
    return places;
}

/// The point at t, 0 to 1, of the span from b to c: the recursion of Barry and Goldman (A recursive
/// evaluation algorithm for a class of Catmull-Rom splines, 1988) with knots that are square roots of
/// distances apart.
glm::dvec3 centripetal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d,
                       double t) {
    const auto gap = [](const glm::dvec3& from, const glm::dvec3& to) {
        return std::sqrt(glm::length(to - from));
    };
    const double t0 = 0, t1 = t0 + gap(a, b), t2 = t1 + gap(b, c), t3 = t2 + gap(c, d);
    const double at = t1 + t * (t2 - t1);
    const auto between = [&](const glm::dvec3& p, const glm::dvec3& q, double from, double to) {
        return ((to - at) * p + (at - from) * q) / (to - from);
    };
    const glm::dvec3 ab = between(a, b, t0, t1), bc = between(b, c, t1, t2), cd = between(c, d, t2, t3);
    const glm::dvec3 abc = between(ab, bc, t0, t2), bcd = between(bc, cd, t1, t3);
    return between(abc, bcd, t1, t2);
}

} // namespace

CentreLine lineThrough(const PlacedPoints& given, const std::string& where) {
    if (given.mm.size() > kMostPlacedPoints)
        throw badFile(where, "at most " + std::to_string(kMostPlacedPoints) + " points",
                      std::to_string(given.mm.size()));
    const PlacedPoints places = placesOf(given, where);
    const std::vector<glm::dvec3>& p = places.mm;
    const std::size_t last = p.size() - 1;
    const double chords = arcsOf(p).back();
    if (!(chords <= kLongestLineMm))
        throw badFile(where, "a line of at most " + std::to_string(static_cast<int>(kLongestLineMm)) + " mm",
                      std::to_string(chords) + " mm");
    std::vector<glm::dvec3> curve;
    std::vector<double> radii;
    const auto radiusAt = [&](std::size_t i) { return places.radiusMm.empty() ? 0.0 : places.radiusMm[i]; };
    for (std::size_t i = 0; i < last; ++i) {
        const glm::dvec3 before = i > 0 ? p[i - 1] : places.closed ? p[last - 1] : 2.0 * p[0] - p[1];
        const glm::dvec3 after = i + 2 <= last   ? p[i + 2]
                                 : places.closed ? p[1]
                                                 : 2.0 * p[last] - p[last - 1];
        const int parts = static_cast<int>(
            std::clamp(std::ceil(8 * glm::length(p[i + 1] - p[i]) / kSpacingMm), 8.0, 8 * kLongestLineMm));
        for (int k = 0; k < parts; ++k) {
            const double t = static_cast<double>(k) / parts;
            curve.push_back(k == 0 ? p[i] : centripetal(before, p[i], p[i + 1], after, t));
            radii.push_back(radiusAt(i) + t * (radiusAt(i + 1) - radiusAt(i)));
        }
    }
    curve.push_back(p[last]);
    radii.push_back(radiusAt(last));

    const EvenSteps steps = evenSteps(curve, kSpacingMm, kLeastSpacingMm);
    CentreLine line;
    line.points = steps.mm;
    line.spacingMm = steps.spacingMm;
    for (const double place : steps.places) {
        const std::size_t i = std::min(static_cast<std::size_t>(place), radii.size() - 2);
        line.radiusMm.push_back(radii[i] + (place - static_cast<double>(i)) * (radii[i + 1] - radii[i]));
    }
    return line;
}

} // namespace tessera
