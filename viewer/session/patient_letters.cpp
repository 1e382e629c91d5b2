// viewer/session/patient_letters.cpp: see patient_letters.h.
#include "viewer/session/patient_letters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <utility>

namespace tessera {

std::string directionLetters(const glm::dvec3& direction) {
    constexpr double kSinOfTen = 0.17364817766693033;       // 10 degrees
    constexpr double kAlike = 1e6;                          // parts of 1 that are told apart
    constexpr const char* kTowards[3] = {"RL", "AP", "IS"}; // LPS: to -, to +
    const double length = glm::length(direction);
    if (!(length > 0) || !std::isfinite(length))
        return {};
    std::array<std::pair<double, char>, 3> parts;
    for (int axis = 0; axis < 3; ++axis) {
        const double part = direction[axis] / length;
        parts[static_cast<std::size_t>(axis)] = {std::round(kAlike * std::abs(part)) / kAlike,
                                                 kTowards[axis][part > 0]};
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::string letters(1, parts[0].second);
    if (parts[1].first > kSinOfTen)
        letters += parts[1].second;
    return letters;
}

EdgeLetters edgeLetters(const Camera& camera) {
    const glm::dmat3 axes = patientFromCamera(camera);
    return {directionLetters(-axes[0]), directionLetters(axes[0]), directionLetters(axes[1]),
            directionLetters(-axes[1])};
}

} // namespace tessera
