// bricking/import/source/plausible.cpp: see plausible.h.
#include "bricking/import/source/plausible.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {
namespace {

std::string shown(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

/// Degrees between an axis and the normal of the other two; 90 where these are parallel.
double skewOf(const VolumeInfo& info, int axis) {
    const auto direction = [&](int i) { return glm::normalize(glm::dvec3(info.patientFromVoxel[i % 3])); };
    const glm::dvec3 normal = glm::cross(direction(axis + 1), direction(axis + 2));
    const double length = glm::length(normal);
    if (!(length > 1e-9))
        return 90;
    return glm::degrees(std::acos(std::min(1.0, std::abs(glm::dot(normal / length, direction(axis))))));
}

} // namespace

void requirePlausibleGeometry(const VolumeInfo& info, const GeometryFields& fields,
                              const std::string& where) {
    const glm::dvec3 spacing = info.spacingMm();
    for (int axis = 0; axis < 3; ++axis)
        if (!(spacing[axis] >= kLeastSpacingMm && spacing[axis] <= kMostSpacingMm))
            throw badFile(where, std::string(fields.spacing) + " with a voxel spacing from 1e-06 to 1e+06 mm",
                          shown(spacing[axis]) + " mm along axis " + std::to_string(axis));
    const glm::dvec3 first = firstVoxelCentreMm(info);
    for (int axis = 0; axis < 3; ++axis)
        if (!(std::abs(first[axis]) <= kFarthestMm))
            throw badFile(where, std::string(fields.position) + " within 1e+07 mm of the origin",
                          shown(first[axis]) + " mm");
    for (int axis = 0; axis < 3; ++axis)
        if (const double skew = skewOf(info, axis); skew > kMostSkewDegrees)
            throw badFile(where,
                          std::string(fields.orientation) +
                              " with axes within 45 degrees of being perpendicular (a gantry tilts by 30)",
                          skew > 89.9
                              ? std::string("a singular orientation")
                              : "axis " + std::to_string(axis) + " skewed by " + shown(skew) + " degrees");
}

void requirePlausibleRescale(double slope, double intercept, double largestStored, bool isHounsfield,
                             const char* slopeField, const char* interceptField, const std::string& where) {
    if (slope == 0 || !std::isfinite(slope))
        throw badFile(where, std::string(slopeField) + ", the rescale slope, finite and other than 0",
                      shown(slope));
    if (!std::isfinite(intercept))
        throw badFile(where, std::string(interceptField) + ", the rescale intercept, finite",
                      shown(intercept));
    const double most = isHounsfield ? kMostHounsfield : kMostValue;
    const std::string within = " that leaves values within +-" + shown(most) + (isHounsfield ? " HU" : "");
    if (std::abs(slope) * std::max(1.0, largestStored) > most || std::abs(slope) < kLeastSlope)
        throw badFile(where, std::string(slopeField) + within + " and apart", "a slope of " + shown(slope));
    if (std::abs(intercept) > most)
        throw badFile(where, std::string(interceptField) + within, "an intercept of " + shown(intercept));
    // A float has 24 bits: beyond, neighbouring stored values become one.
    if (largestStored > 0 && std::abs(slope) < std::ldexp(std::abs(intercept), -24))
        throw badFile(where,
                      std::string(slopeField) + " large enough beside the intercept to tell values apart",
                      "a slope of " + shown(slope) + " beside an intercept of " + shown(intercept));
}

} // namespace tessera
