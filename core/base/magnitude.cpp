// core/base/magnitude.cpp: see magnitude.h.
#include "core/base/magnitude.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <sstream>
#include <vector>

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

namespace {

/// "AxBxC" as `count` whole numbers in [1, largest]; nothing else.
std::vector<int> parseExtents(const std::string& text, std::size_t count, const std::string& where,
                              int largest) {
    constexpr std::size_t kMaxDigits = 6;
    std::vector<int> numbers;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, 'x');) {
        const bool digits = !part.empty() && part.size() <= kMaxDigits &&
                            part.find_first_not_of("0123456789") == std::string::npos;
        numbers.push_back(digits ? std::stoi(part) : 0);
    }
    const bool inRange =
        std::all_of(numbers.begin(), numbers.end(), [&](int n) { return n >= 1 && n <= largest; });
    if (numbers.size() != count || !inRange || text.back() == 'x')
        throw badFile(where,
                      std::string(count == 2 ? "WIDTHxHEIGHT" : "XxYxZ") + " with numbers from 1 to " +
                          std::to_string(largest),
                      "\"" + text + "\"");
    return numbers;
}

} // namespace

glm::ivec2 parseImageSize(const std::string& text, const std::string& where, int largest) {
    const std::vector<int> n = parseExtents(text, 2, where, largest);
    return {n[0], n[1]};
}
glm::ivec3 parseVolumeSize(const std::string& text, const std::string& where, int largest) {
    const std::vector<int> n = parseExtents(text, 3, where, largest);
    return {n[0], n[1], n[2]};
}

} // namespace tessera
