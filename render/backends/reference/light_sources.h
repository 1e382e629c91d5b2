// render/backends/reference/light_sources.h: the light sources of a scene.
#pragma once

#include "render/backends/reference/reference.h"
#include "render/light/directions.h"

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// In patient space; common to all rays of light.
class LightSources {
  public:
    explicit LightSources(const ReferenceInput& input);

    static constexpr int kPlacesOfSoftLight = 4;
    static constexpr double kOffsetVoxels = 2; // offset of the start of shadow rays, towards a light

    struct Caster {
        bool isPoint = false;
        glm::dvec3 middle{0};           // unit, towards the light; or a point, mm
        std::vector<glm::dvec3> places; // the same, over its disk; one alone: the centre
    };
    bool hasOcclusion = false;
    Occlusion occlusion;
    std::vector<SphereDirection> directions; // of occlusion
    int ambientChannels = 0;                 // of ambient light
    std::vector<Caster> casters;
    double offsetMm = 0;
    std::span<const SceneMesh> meshes; // that take their light
};

} // namespace tessera
