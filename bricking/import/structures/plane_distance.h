// bricking/import/structures/plane_distance.h: signed distances from the rings of a plane on a grid of
// points.
#pragma once

#include "bricking/import/structures/structure_planes.h"

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

namespace tessera {

struct PlaneGrid {
    glm::dvec2 origin{0}; // of point (0, 0), mm in the plane
    double step = 1;      // mm
    int nx = 0, ny = 0;
    std::size_t points() const { return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny); }
    /// Memory of distancesTo() besides its result.
    std::size_t scratchBytes() const { return points() * (sizeof(std::uint32_t) + sizeof(float)); }
};

/// Distances to the nearest ring in steps, [y][x]; negative inside, by even and odd crossings. Sides that are
/// there twice, as those of a keyhole, count for nothing. Near rings they are exact; further away the nearest
/// side of a ring is handed on from point to point, which errs by less than a step. None is nearer to 0 than
/// 1e-4.
void distancesTo(const StructurePlane& plane, const PlaneGrid& grid, std::span<float> out);

} // namespace tessera
