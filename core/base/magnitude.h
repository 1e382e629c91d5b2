// core/base/magnitude.h: limits of numbers from files and options. Beyond them, arithmetic in float or double
// overflows somewhere and gives no number. Such numbers are refused where they come in.
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <string>

namespace tessera {

/// Of a value, physical units: what a voxel can hold.
constexpr double kLargestValue = std::numeric_limits<float>::max();
/// Of a place's components and of lengths, mm: a million kilometres. Their squares, and the squares of those,
/// are far from overflow.
constexpr double kFarthestPlaceMm = 1e12;
/// Of a direction, whose length does not count else: its cube is far above the smallest number.
constexpr double kShortestDirection = 1e-30;

/// These throw InputError naming `where` for a number beyond the bound, or one that is none.
/// @param what  "a point's value", for the message
void checkValue(double value, const std::string& what, const std::string& where);
void checkPlace(const glm::dvec3& placeMm, const std::string& what, const std::string& where);
/// The place's bound for each component, and a length that is not 0, nor so small that its square is.
void checkDirection(const glm::dvec3& direction, const std::string& what, const std::string& where);
void checkLength(double mm, const std::string& what, const std::string& where);

/// A number as a message shows it: "1e+308", "-0.25".
std::string shownNumber(double number);

} // namespace tessera
