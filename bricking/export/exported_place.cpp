// bricking/export/exported_place.cpp: see exported_place.h.
#include "bricking/export/exported_place.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace tessera {

glm::dvec3 ExportedPlace::spacing() const {
    return {glm::length(step[0]), glm::length(step[1]), glm::length(step[2])};
}

double ExportedPlace::shear() const {
    double most = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3;
        most = std::max(most,
                        std::abs(glm::dot(step[a], step[b])) / (glm::length(step[a]) * glm::length(step[b])));
    }
    return most;
}

ExportedPlace placeOf(const VolumeInfo& info) {
    ExportedPlace place;
    for (int axis = 0; axis < 3; ++axis)
        place.step[static_cast<std::size_t>(axis)] = glm::dvec3(info.patientFromVoxel[axis]);
    place.firstCentre = firstVoxelCentreMm(info);
    // The reader's subtraction rounds: a neighbour of the centre may give the corner exactly.
    const glm::dvec3 half = 0.5 * (place.step[0] + place.step[1] + place.step[2]);
    for (int axis = 0; axis < 3; ++axis) {
        const double corner = info.patientFromVoxel[3][axis];
        double& centre = place.firstCentre[axis];
        constexpr double kFar = std::numeric_limits<double>::infinity();
        for (const double candidate : {corner + half[axis], std::nextafter(centre, kFar),
                                       std::nextafter(centre, -kFar), corner + half[axis]})
            if (centre - half[axis] != corner && candidate - half[axis] == corner)
                centre = candidate;
    }
    return place;
}

std::string exactText(double value) {
    std::array<char, 32> text{};
    const std::to_chars_result end = std::to_chars(text.data(), text.data() + text.size(), value + 0.0);
    return {text.data(), end.ptr}; // -0 + 0 is 0
}

std::string exactText(const glm::dvec3& value, const char* between) {
    return exactText(value.x) + between + exactText(value.y) + between + exactText(value.z);
}

} // namespace tessera
