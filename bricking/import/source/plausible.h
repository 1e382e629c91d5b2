// bricking/import/source/plausible.h: bounds on a header's geometry and rescale values. All formats share
// them; the message names the field at fault.
#pragma once

#include "core/base/volume.h"

#include <string>

namespace tessera {

constexpr double kLeastSpacingMm = 1e-6, kMostSpacingMm = 1e6; // a nanometre to a kilometre a voxel
constexpr double kFarthestMm = 1e7;                            // of the first voxel from the origin
constexpr double kMostSkewDegrees = 45; // of an axis from the normal of the others; gantries tilt by 30
constexpr double kMostHounsfield = 1e7; // of any value after slope and intercept
constexpr double kLeastSlope = 1e-20, kMostValue = 1e12; // of data without a unit

/// Names of a format's geometry fields: "PixelSpacing (0028,0030)", "sform (srow_x, srow_y, srow_z)".
struct GeometryFields {
    const char* spacing;
    const char* orientation;
    const char* position;
};

/// Throws InputError naming `where` and the field for a spacing or position that is not finite or out of
/// bounds, and for axes too far from right angles.
void requirePlausibleGeometry(const VolumeInfo& info, const GeometryFields& fields, const std::string& where);

/// Throws InputError naming `where` and the field for a slope or intercept that is not finite, a slope of 0,
/// and values out of bounds. Throws it for a slope too small against the intercept to keep values distinct.
/// @param largestStored  the largest stored magnitude, or 0 for floating-point data
void requirePlausibleRescale(double slope, double intercept, double largestStored, bool isHounsfield,
                             const char* slopeField, const char* interceptField, const std::string& where);

} // namespace tessera
