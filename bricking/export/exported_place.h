// bricking/export/exported_place.h: where a volume's voxels are, as file formats say it: the centre of the
// first voxel and a step along each axis.
#pragma once

#include "core/base/volume.h"

#include <array>
#include <glm/vec3.hpp>
#include <string>

namespace tessera {

/// Patient space (LPS), mm.
struct ExportedPlace {
    glm::dvec3 firstCentre{0};
    std::array<glm::dvec3, 3> step; // from a voxel's centre to the next one's, along x, y, z
    glm::dvec3 spacing() const;     // lengths of the steps
    /// Largest cosine between two steps: 0 for a box.
    double shear() const;
};
/// patientFromVoxelOf() makes the volume's affine of it again, bit by bit unless rounding forbids it.
ExportedPlace placeOf(const VolumeInfo& info);

/// More than rounded headers bring, as cosine of an angle: such axes are no box.
constexpr double kMostShear = 1e-4;

/// Shortest text of at most 17 digits that reads as the same number.
std::string exactText(double value);
/// "(x,y,z)", "x y z": exactText() of each.
std::string exactText(const glm::dvec3& value, const char* between = " ");

} // namespace tessera
