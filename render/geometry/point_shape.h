// render/geometry/point_shape.h: PointShape: points of a file, of no lattice: balls for rays, and for splats
// Gaussians (render/backends/splat/splat_points.h).
#pragma once

#include "render/geometry/tube_shape.h"

#include <span>

namespace tessera {

class PointShape : public TubeShape {
  public:
    /// @param points  one at least (checked); patient space, mm
    PointShape(std::span<const glm::vec3> points, double radiusMm, MemoryBudget& ram);
    const char* partName() const override { return "points"; }
};

} // namespace tessera
