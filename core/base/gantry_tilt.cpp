// core/base/gantry_tilt.cpp: see gantry_tilt.h.
#include "core/base/gantry_tilt.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {

double gantryTiltDegrees(const glm::dmat4& patientFromVoxel, int stackAxis) {
    const glm::dvec3 across(patientFromVoxel[(stackAxis + 1) % 3]);
    const glm::dvec3 down(patientFromVoxel[(stackAxis + 2) % 3]);
    glm::dvec3 stack = glm::normalize(glm::dvec3(patientFromVoxel[stackAxis]));
    if (stack.z < 0)
        stack = -stack; // towards the head
    const glm::dvec3 normal = glm::normalize(glm::cross(across, down));
    const double cosine = std::min(1.0, std::abs(glm::dot(normal, stack)));
    const glm::dvec3 anterior(0, -1, 0);
    const glm::dvec3 anteriorInSlice = anterior - normal * glm::dot(normal, anterior);
    const double degrees = glm::degrees(std::acos(cosine));
    return glm::dot(anteriorInSlice, stack) < -1e-9 ? -degrees : degrees;
}

double gantryTiltDegrees(const VolumeInfo& info) {
    const auto& axes = info.originalOrder.sourceAxis;
    const auto stack = std::find(axes.begin(), axes.end(), 2);
    return gantryTiltDegrees(info.patientFromVoxel,
                             stack == axes.end() ? 2 : static_cast<int>(stack - axes.begin()));
}

} // namespace tessera
