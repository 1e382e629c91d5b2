// render/backends/reference/light_sources.h: the light sources of a scene.
#pragma once

#include "render/backends/reference/reference.h"
#include "render/light/directions.h"

#include <glm/vec3.hpp>
#include <vector>

namespace tessera {

/// Patient space; the same for all rays of light.
class LightSources {
  public:
    explicit LightSources(const ReferenceInput& input);

    static constexpr int kPlacesOfSoftLight = 4;
    static constexpr double kOffsetVoxels = 2; // towards a light, of where rays of shadow start

    struct Caster {
        bool isPoint = false;
        glm::dvec3 middle{0};           // unit, towards the light; or a place, mm
        std::vector<glm::dvec3> places; // over its disk, the same; one alone: the middle
    };
    bool hasOcclusion = false;
    Occlusion occlusion;
    std::vector<SphereDirection> directions; // of occlusion
    int ambientChannels = 0;                 // of light from all sides
    std::vector<Caster> casters;
    double offsetMm = 0;
};

} // namespace tessera
