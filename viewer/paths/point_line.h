// viewer/paths/point_line.h: a centre-line through points that someone placed.
#pragma once

#include "core/animation/path.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace tessera {

/// Points in their order along a line.
struct PlacedPoints {
    std::vector<glm::dvec3> mm;   // LPS
    std::vector<double> radiusMm; // distances to the wall, one a point, or none
    bool closed = false;          // goes on from the last to the first
};

/// The longest line that is made of points, mm, and their largest number.
constexpr double kLongestLineMm = 1e5;
constexpr std::size_t kMostPlacedPoints = 100000;

/// The centripetal Catmull-Rom curve through the points, evenly spaced by at most 1 mm, closer where it bends
/// sharply. Points that coincide with the one before count once. Radii are interpolated; without any they are
/// 0. (Yuksel, Schaefer and Keyser, Parameterization and applications of Catmull-Rom curves, 2011: without
/// loops, near its points.)
/// @param where  the file and its part, for messages
/// Throws InputError for fewer than two places, for coordinates beyond 1e7 mm, and for a longer line.
CentreLine lineThrough(const PlacedPoints& points, const std::string& where);

} // namespace tessera
