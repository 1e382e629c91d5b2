// bricking/import/structures/plane_stack.h: PlaneStack: signed distances of neighbouring planes as a grid,
// and the closed surface where they are 0.
#pragma once

#include "bricking/import/structures/plane_distance.h"
#include "bricking/import/structures/structure_planes.h"
#include "core/base/budget.h"
#include "core/base/triangle_mesh.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

class PlaneStack {
  public:
    /// Planes first to end - 1 of a structure with two planes at least.
    /// @param planes  must outlive it
    /// @param stepMm  of the grid in the planes; across them layers are this far apart or a little less, and
    ///     every plane is a layer
    PlaneStack(const StructurePlanes& planes, std::size_t first, std::size_t end, double stepMm);

    std::size_t points() const { return grid_.points() * layers_.size(); }
    /// Memory of the grid and of VTK's walk over it.
    std::size_t gridBytes() const;

    /// @param ram  is charged for the grid, then for the triangles, which are counted before they are made;
    ///     nothing is left charged
    /// @param what  for the message of a budget that is too small
    /// @param mustFit  false: nullopt where the triangles do not fit
    std::optional<TriangleMesh> surface(MemoryBudget& ram, const std::string& what, bool mustFit) const;

  private:
    struct Layer {
        double at = 0;                    // along the normal, mm
        std::size_t below = 0, above = 0; // planes
        double share = 0;                 // of the plane above
        bool isOutside = false;
    };
    std::vector<float> distances() const;
    TriangleMesh contoured(std::vector<float>& values) const;
    glm::dvec3 placeOf(const glm::vec3& point) const;

    const StructurePlanes& planes_;
    PlaneGrid grid_;
    std::vector<Layer> layers_;
};

} // namespace tessera
