// core/base/magnitude.cpp: see magnitude.h.
#include "core/base/magnitude.h"

#include "core/base/error.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <sstream>

namespace tessera {
namespace {

/// Also of a number that is none.
void checkWithin(double number, double most, const std::string& what, const char* unit,
                 const std::string& where) {
    if (!(std::abs(number) <= most))
        throw badFile(where, what + " within +-" + shownNumber(most) + unit, shownNumber(number));
}

} // namespace

void checkValue(double value, const std::string& what, const std::string& where) {
    checkWithin(value, kLargestValue, what, ", which a voxel can hold", where);
}

void checkPlace(const glm::dvec3& placeMm, const std::string& what, const std::string& where) {
    for (int axis = 0; axis < 3; ++axis)
        checkWithin(placeMm[axis], kFarthestPlaceMm, what, " mm", where);
}

void checkDirection(const glm::dvec3& direction, const std::string& what, const std::string& where) {
    for (int axis = 0; axis < 3; ++axis)
        checkWithin(direction[axis], kFarthestPlaceMm, what, "", where);
    if (!(glm::length(direction) >= kShortestDirection))
        throw badFile(where, what + " that is not 0", "one of length " + shownNumber(glm::length(direction)));
}

void checkLength(double mm, const std::string& what, const std::string& where) {
    checkWithin(mm, kFarthestPlaceMm, what, " mm", where);
}

std::string shownNumber(double number) {
    std::ostringstream out;
    out << number; // six digits
    return out.str();
}

} // namespace tessera
