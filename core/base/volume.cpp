// core/base/volume.cpp: see volume.h.
#include "core/base/volume.h"

#include "core/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace tessera {

std::size_t bytesPerValue(ValueType type) {
    switch (type) {
    case ValueType::u8:
        return 1;
    case ValueType::i16:
    case ValueType::u16:
        return 2;
    case ValueType::f32:
        return 4;
    }
    return 0;
}

const char* name(ValueType type) {
    switch (type) {
    case ValueType::u8:
        return "uint8";
    case ValueType::i16:
        return "int16";
    case ValueType::u16:
        return "uint16";
    case ValueType::f32:
        return "float32";
    }
    return "?";
}

glm::dvec3 VolumeInfo::spacingMm() const {
    return {glm::length(glm::dvec3(patientFromVoxel[0])), glm::length(glm::dvec3(patientFromVoxel[1])),
            glm::length(glm::dvec3(patientFromVoxel[2]))};
}

std::uint64_t VolumeInfo::voxelCount() const {
    return static_cast<std::uint64_t>(extentVoxels.x) * static_cast<std::uint64_t>(extentVoxels.y) *
           static_cast<std::uint64_t>(extentVoxels.z);
}

void VolumeInfo::validate(const std::string& where) const {
    double bytes = static_cast<double>(bytesPerValue(type));
    for (int axis = 0; axis < 3; ++axis) {
        if (extentVoxels[axis] < 1)
            throw badFile(where, "at least 1 voxel along every axis",
                          std::to_string(extentVoxels[axis]) + " along axis " + std::to_string(axis));
        bytes *= extentVoxels[axis];
    }
    if (!(bytes < 0x1p62))
        throw badFile(where, "fewer than 2^62 bytes", "an extent product that is larger");
    const glm::dvec3 spacing = spacingMm();
    for (int axis = 0; axis < 3; ++axis)
        if (!(spacing[axis] > 0) || !std::isfinite(spacing[axis]))
            throw badFile(where, "a positive, finite voxel spacing",
                          std::to_string(spacing[axis]) + " mm along axis " + std::to_string(axis));
    for (int axis = 0; axis < 3; ++axis)
        if (!std::isfinite(patientFromVoxel[3][axis]))
            throw badFile(where, "a finite position of the first voxel", "a value that is not finite");
    const double det = std::abs(glm::determinant(glm::dmat3(patientFromVoxel)));
    if (!(det >= 1e-6 * spacing.x * spacing.y * spacing.z))
        throw badFile(where, "three independent voxel directions", "a singular orientation matrix");
    if (!std::isfinite(rescaleSlope) || !std::isfinite(rescaleIntercept) || rescaleSlope == 0)
        throw badFile(where, "a finite rescale slope other than 0 and a finite intercept",
                      std::to_string(rescaleSlope) + " and " + std::to_string(rescaleIntercept));
}

glm::dmat4 patientFromVoxelOf(const glm::dvec3& firstCentreMm, const glm::dvec3& stepX,
                              const glm::dvec3& stepY, const glm::dvec3& stepZ) {
    const glm::dvec3 corner = firstCentreMm - 0.5 * (stepX + stepY + stepZ);
    return {glm::dvec4(stepX, 0), glm::dvec4(stepY, 0), glm::dvec4(stepZ, 0), glm::dvec4(corner, 1)};
}

glm::dvec3 firstVoxelCentreMm(const VolumeInfo& info) {
    return glm::dvec3(info.patientFromVoxel * glm::dvec4(0.5, 0.5, 0.5, 1));
}

PatientBox patientBoxOf(const VolumeInfo& info) {
    PatientBox box;
    box.low = box.high = glm::dvec3(info.patientFromVoxel[3]);
    for (int axis = 0; axis < 3; ++axis)
        for (int step = 0; step < 3; ++step) { // -0 is no number to show
            const double along = info.patientFromVoxel[step][axis] * info.extentVoxels[step];
            (along < 0 ? box.low : box.high)[axis] += along + 0.0;
        }
    return box;
}

void storeFill(const VolumeInfo& info, std::byte* out) {
    const auto put = [&](auto value) { std::memcpy(out, &value, sizeof value); };
    switch (info.type) {
    case ValueType::u8:
        return put(static_cast<std::uint8_t>(info.fillStored));
    case ValueType::i16:
        return put(static_cast<std::int16_t>(info.fillStored));
    case ValueType::u16:
        return put(static_cast<std::uint16_t>(info.fillStored));
    case ValueType::f32:
        return put(static_cast<float>(info.fillStored));
    }
}

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
