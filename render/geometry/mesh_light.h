// render/geometry/mesh_light.h: MeshLight: the shares of the scene's lights that reach a place on a mesh:
// past the volume by shadow maps of it, past meshes by rays (docs/sampling.md, "Meshes").
#pragma once

#include "core/scene/lighting.h"
#include "render/light/shadow_maps.h"
#include "render/plan/frame_plan.h"

#include <array>
#include <vector>

namespace tessera {

class MeshLight {
  public:
    using Shares = std::array<double, Lighting::kMaxLights>;

    /// @param plan  as it is drawn; outlives this. Its bricks are read from its cache
    /// @param threads  0: all processors
    MeshLight(const FramePlan& plan, int threads);

    /// By the numbers of LightingNumbers; 1 of lights that cast no shadow.
    /// @param place  patient space, mm
    /// @param normal  unit, towards the viewer
    Shares at(const glm::dvec3& place, const glm::dvec3& normal) const;

    /// True if lights of the plan cast shadows that meshes receive.
    static bool isNeeded(const FramePlan& plan);

  private:
    struct Source {
        PlacedLight light;
        std::vector<ShadowMaps> maps; // of each volume; none: the light casts no shadow
    };
    const FramePlan& plan_;
    std::vector<Source> sources_; // shining lights, in order
};

} // namespace tessera
