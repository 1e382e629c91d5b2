// core/base/magnitude.h: numbers from files and options: their limits, and sizes as people type them. Beyond
// the limits, arithmetic in float or double overflows, so such numbers are refused on input.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <string>

namespace tessera {

/// Of a value, physical units: the range of a voxel.
constexpr double kLargestValue = std::numeric_limits<float>::max();
/// Of a position's components and of lengths, mm: a million kilometres. Their fourth powers are far from
/// overflow.
constexpr double kFarthestPlaceMm = 1e12;
/// Least length of a direction: its cube is far above the smallest float.
constexpr double kShortestDirection = 1e-30;

/// These throw InputError naming `where` for a number beyond the bound, or not finite.
/// @param what  "a point's value", for the message
void checkValue(double value, const std::string& what, const std::string& where);
void checkPlace(const glm::dvec3& placeMm, const std::string& what, const std::string& where);
/// Applies the bound of positions to each component; the length, and its square, must not be 0.
void checkDirection(const glm::dvec3& direction, const std::string& what, const std::string& where);
void checkLength(double mm, const std::string& what, const std::string& where);

/// A number for a message: "1e+308", "-0.25".
std::string shownNumber(double number);

/// "640x480". Throws InputError naming `where` for anything but whole numbers from 1 to `largest`.
glm::ivec2 parseImageSize(const std::string& text, const std::string& where, int largest);
/// "256x192x300". The same for three axes.
glm::ivec3 parseVolumeSize(const std::string& text, const std::string& where, int largest);

} // namespace tessera
