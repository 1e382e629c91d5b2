// render/geometry/mesh_rays.h: MeshRays: the surfaces that a picture's rays meet, one after another, and the
// light that they send back (docs/sampling.md, "Meshes"). In double from the ray's plane near the volume;
// places and colours become floats here alone, so all engines get the same.
#pragma once

#include "render/contract/ray.h"
#include "render/geometry/mesh_light.h"
#include "render/geometry/shape.h"
#include "render/plan/frame_plan.h"

#include <glm/vec4.hpp>
#include <optional>
#include <vector>

namespace tessera {

/// How far outside of a cut a surface counts as kept, voxels: one in the cut's own plane is.
constexpr double kCutTolerance = 1e-3;

class MeshRays {
  public:
    /// @param plan  as it is; outlives this. Its meshes have been read (checked)
    /// @param light  of shadows on meshes, which it outlives; null: no light is shadowed
    MeshRays(const FramePlan& plan, const RayFrame<double>& frame, const MeshLight* light = nullptr);

    /// A place in the order of a ray's surfaces. Those of equal t come in the order of the scene.
    struct Order {
        double t = -kFar; // voxels along the ray's line
        std::uint32_t part = 0;
        std::int32_t mesh = -1; // -1: before all
    };
    struct Surface {
        Order at;
        glm::vec4 colour{0};  // lit, not premultiplied; opacity
        glm::vec3 ambient{0}; // what ambient light adds to that, times the opacity
        glm::dvec3 normal{0}; // unit, patient space, towards the viewer; 0: it has none
    };
    /// The surface of a ray behind another one. None: nothing is left, up to kFar.
    std::optional<Surface> next(const RayLine<double>& line, const Order& after) const;

    /// Beyond every place of a volume or mesh; voxels.
    static constexpr double kFar = 1e30;

  private:
    void light(const SceneMesh& mesh, const ShapeHit& hit, const ShapeRay& ray, Surface& surface) const;

    const FramePlan& plan_;
    const MeshLight* light_;
    glm::dmat4 patientFromVoxel_;
    leaf::LightingNumbers lighting_; // of surfaces, whatever a gradient's length
};

} // namespace tessera
