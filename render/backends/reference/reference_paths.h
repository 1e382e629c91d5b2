// render/backends/reference/reference_paths.h: paths of light through the finest level, in double. Ways
// between scatterings have no bounds, null collisions or table: optical depths are inverted cell by cell.
// Scatterings are those of all engines (render/transport/path.h).
#pragma once

#include "render/backends/reference/light_rays.h"
#include "render/backends/reference/ray_integral.h"
#include "render/transport/path.h"

#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// For one thread.
class ReferencePaths {
  public:
    /// All outlive it.
    /// @param of  has `paths`
    ReferencePaths(const IntegralInput& of, LatticeReader& samples);

    /// The colour of a path of light that a ray sees the end of, and the ray's opacity.
    /// @param parts  of the ray that are drawn, in order, mm
    glm::dvec4 operator()(const ReferenceRay& ray, std::span<const RayPart> parts, double alpha,
                          const PathStart& start);

  private:
    struct NoField {};
    using Tracer = PathTracer<NoField>;

    PathTissue tissueAt(const glm::dvec3& p);
    /// Voxel space.
    glm::dvec3 gradientAt(const glm::dvec3& p, Gradient by);
    /// Share of light.
    double left(const Way& way);
    /// mm; below 0: there is none.
    double toCollision(const Way& way, double share);
    std::span<const RayPart> partsOf(const Way& way);

    const PathScene& scene_;
    const StoredFunction& function_;
    const Optics& optics_;
    LatticeReader& samples_;
    Selection finest_;
    std::optional<LabelField> labels_;
    LightRays rays_;
    NoField noField_;
    PathWork work_;
    Tracer tracer_;
    std::vector<RayPart> parts_; // of a way
};

} // namespace tessera
