// bricking/import/structures/structure_surface.h: a structure's contours as a closed surface: signed
// distances in every plane, linear between planes (shape-based interpolation: Herman, Zheng and Bucholtz
// 1992), and their surface at 0 by VTK's flying edges.
//
// Each of the two outermost planes of a piece goes on for half the distance to its neighbour, where the
// surface is closed by a plane. Where neighbouring planes are further apart than the largest gap, the pieces
// before and behind are closed each by itself.
#pragma once

#include "bricking/import/structures/structure_set.h"
#include "core/base/budget.h"
#include "core/base/triangle_mesh.h"

#include <cstddef>
#include <string>
#include <vector>

namespace tessera {

struct SurfaceOptions {
    /// Of the grid in a plane. 0: a quarter of the contours' median width (StructurePlanes::widthMm), from
    /// kFinestStepMm to kSurfaceStepMm; coarser where memory is short.
    double stepMm = 0;
    double gapMm = 0; // the largest distance of planes that are joined; 0: kJoinedSpacings median distances
};
constexpr double kSurfaceStepMm = 1, kFinestStepMm = 0.25, kJoinedSpacings = 3.5;

struct StructureSurface {
    TriangleMesh mesh;                      // patient space (LPS), mm, with normals; empty: there is none
    std::vector<std::size_t> otherContours; // numbers of those that are not part of it
    std::vector<std::string> notes;         // for people: gaps, other contours, a coarser grid
};

/// @param ram  is charged for grid and triangles, which are counted first; nothing is left charged
/// Throws InputError naming the structure if the memory does not suffice.
StructureSurface surfaceOf(const Structure& structure, const SurfaceOptions& options, MemoryBudget& ram);

} // namespace tessera
