// bricking/import/structures/structure_planes.h: StructurePlanes: the closed planar contours of a structure,
// by the parallel planes that they lie in.
#pragma once

#include "bricking/import/structures/structure_set.h"
#include "core/base/budget.h"

#include <array>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

namespace tessera {

constexpr double kPlanarMm = 0.1;     // how far points may lie off their contour's plane
constexpr double kSamePlaneMm = 0.05; // planes this near are one

struct StructurePlane {
    double at = 0;                              // along the planes' normal, mm
    std::vector<std::vector<glm::dvec2>> rings; // mm in the plane; nested ones are holes, by even and odd
};

struct StructurePlanes {
    glm::dmat3 patientFromPlane{1};     // orthonormal; the third column is the normal
    std::vector<StructurePlane> planes; // ascending
    double spacingMm = 0;               // median distance of neighbours; 0: fewer than two planes
    double widthMm = 0; // median of the rings' twice their area over their length: the radius of a circle
    std::vector<std::size_t> otherContours; // of the structure, which lie in none of the planes: not closed,
                                            // not planar, or in a plane of another direction
    Charge charge;
};

/// Planes of the direction of the largest contour.
/// @param ram  is charged for the lists, before they are allocated
StructurePlanes planesOf(const Structure& structure, MemoryBudget& ram);

} // namespace tessera
