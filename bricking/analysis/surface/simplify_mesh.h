// bricking/analysis/surface/simplify_mesh.h: fewer triangles for a closed mesh, by collapsing edges where the
// least error is made (Garland and Heckbert 1997, "Surface simplification using quadric error metrics").
//
// An edge is collapsed only where the surface stays what it is (the link condition: Dey and others 1999,
// "Topology preserving edge contraction") and no triangle turns over. So a closed mesh stays closed: every
// edge keeps two triangles, and no hole or handle comes or goes.
#pragma once

#include "core/base/budget.h"
#include "core/base/progress.h" // ShareDone
#include "core/base/triangle_mesh.h"

#include <cstddef>
#include <cstdint>
#include <limits>

namespace tessera {

struct SimplifyRequest {
    std::uint64_t mostTriangles = 0; // goal; it ends earlier where no more edge can be collapsed
    /// Of a point: the root of the mean squared distance to the planes of the triangles that it stands for,
    /// mm.
    double mostErrorMm = std::numeric_limits<double>::infinity();
};

/// Memory that it takes besides the mesh.
std::size_t simplifyBytes(std::uint64_t points, std::uint64_t triangles);

/// Simplifies a mesh that is closed, each of whose edges has two triangles, without normals. The result
/// depends on the mesh and the request alone.
/// @param ram  charged with simplifyBytes() meanwhile; throws InputError if it has no room
/// @return the largest error of a point, mm
double simplifyMesh(TriangleMesh& mesh, const SimplifyRequest& request, MemoryBudget& ram,
                    const ShareDone& progress = {});

} // namespace tessera
