// render/transport/path_scene.h: what paths of light go through and where they end: a volume's extinction and
// its bounds, lights, the sky.
#pragma once

#include "core/scene/camera.h"
#include "core/scene/lighting.h"
#include "core/scene/transport.h"
#include "render/contract/optics.h"
#include "render/contract/ray_cuts.h"
#include "render/empty_space/extinction_bounds.h"
#include "render/empty_space/occupancy.h"
#include "render/transport/environment_map.h"
#include "render/transport/surface_response.h"

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace tessera {

/// A light that places are lit by: from a direction, or at a place.
struct PathLight {
    bool isPoint = false;
    glm::vec3 towards{0}; // unit, patient space; of a point its place, voxels
    glm::vec3 power{0};   // irradiance at right angles, by channel; of a point before it fades
    glm::vec3 fading{1, 0, 0};
    int number = 0;    // among those that shine
    bool casts = true; // a shadow
    float cosine = 1;  // of half its apparent diameter
};

/// Of a path's first scattering, and of later ones.
struct SurfaceResponses {
    SurfaceResponse first, later;
};

/// What tissue of a range of values scatters by.
struct TissueResponse {
    float from = 0, to = 0; // places in the function's table, `to` excluded
    SurfaceResponses surface;
    Phase phase;
    float meanCosine = 0; // of the phase function
};

struct PathScene {
    const Optics* optics = nullptr;
    const ExtinctionBounds* bounds = nullptr;
    const Occupancy* occupancy = nullptr;        // null: nothing is leapt over
    const Occupancy* surfaceOccupancy = nullptr; // of isosurfaces alone; null: there is none
    Transport transport;
    std::optional<Environment> environment; // none: all is dark beyond the volume
    std::uint32_t seed = 0;
    /// By values: the first is that of all which no other one holds.
    std::vector<TissueResponse> tissues;
    std::vector<SurfaceResponses> isosurfaces; // of optics->surfaces
    Gradient normals = Gradient::central;      // of surfaces that scatter
    float steepFrom = 0, perSteep = 0; // gradient lengths, stored units per mm; 1 over their difference
    glm::mat3 voxelFromPatient{1};     // linear part
    glm::vec3 extent{0};               // voxels
    /// Tissue is within all slabs, and where the cuts keep it; null: there are no others.
    std::vector<RaySlab<float>> slabs;
    const RayCuts* cuts = nullptr;
    std::vector<PathLight> lights;
    glm::vec3 up{0, 0, 1};                      // of the sky, unit, patient space
    glm::vec3 front{0, -1, 0}, right{-1, 0, 0}; // the same: at right angles to it
    /// By which directions to the sky are drawn, as those to lights are; null: by phase functions and
    /// surfaces alone, which find even skies as well.
    std::shared_ptr<const DirectionTable> skyTable;
    float leavesFromMm = 0;             // where ways from surfaces begin, and the contract's to lights
    std::optional<Occlusion> occlusion; // of the contract's light
    std::vector<float> isovalues;       // of optics->surfaces, ascending
};

/// @param lighting  the scene's own; has a transport
/// @param optics, bounds, occupancy  of the volume; outlive it
/// @param tissues  of the transfer function
PathScene pathScene(const Lighting& lighting, const Camera& camera, const VolumeInfo& info,
                    const Optics& optics, const ExtinctionBounds& bounds, const Occupancy* occupancy,
                    std::uint32_t seed, const std::vector<Tissue>& tissues = {});

/// Radiance of the sky from a direction, unit, patient space.
glm::vec3 skyFrom(const PathScene& scene, const glm::vec3& direction);

/// A direction to the sky that its table draws.
struct ToSky {
    glm::vec3 towards{0}, radiance{0};
    float density = 0; // per steradian
};
/// @param two  random numbers
ToSky wayToSky(const PathScene& scene, const glm::vec2& two);
/// Of the directions that it draws, per steradian; 0 without a table.
float skyDensity(const PathScene& scene, const glm::vec3& direction);

} // namespace tessera
