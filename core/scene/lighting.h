// core/scene/lighting.h: a scene's lights and ambient occlusion (docs/sampling.md, "Shading").
#pragma once

#include "core/scene/transport.h"

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

/// At the eye, along every ray; from one direction; from a point.
enum class LightKind { head, directional, point };
struct Light {
    LightKind kind = LightKind::head;
    LightFrame frame = LightFrame::camera;
    glm::dvec3 direction{0, 0, 1};   // directional: towards the light, any length; 0: lights no surface
    glm::dvec3 position{0};          // point: mm
    glm::dvec3 attenuation{1, 0, 0}; // point: 1/(c + l d + q d^2), d mm
    double intensity = 1;
    glm::dvec3 colour{1}; // linear light
    bool shadow = false;  // it casts one
    double softness = 0;  // degrees, its diameter as seen from what it lights
    double scatter = 0;   // factor on its light that the tissue around a place scatters to it; 0: none
    bool operator==(const Light&) const = default;
};

/// The weight of an occlusion ray (docs/sampling.md, "Light per voxel"). local: each part counts by the light
/// that is left there (course notes 6.1). positional: the light left at its end (volume-based ambient
/// occlusion, equation 8). rejecting: as positional, but only density that grows along the ray takes light
/// (equations 4 to 7). histogram: by the values around, whatever their order (course notes 6.2).
enum class OcclusionMethod { local, positional, rejecting, histogram };

/// Ambient occlusion: the share of ambient light that reaches a point.
struct Occlusion {
    OcclusionMethod method = OcclusionMethod::local;
    int rays = 32;
    double radiusMm = 16; // how far they look
    double offsetMm = 0;  // where they begin
    double bias = 0.1, gamma = 0.6;
    double emission = 0; // factor on the light of emissive tissue on its surroundings; 0: none
    double bleeding = 0; // factor on the colours of tissue around, by histograms; 0: none
    bool operator==(const Occlusion&) const = default;
};

/// Ambient occlusion of isosurfaces at the first hits of the picture's rays (docs/sampling.md, "Occlusion of
/// isosurfaces"): the share of ambient light that other isosurfaces leave a point.
struct SurfaceOcclusion {
    static constexpr int kMostRays = 256;
    int rays = 16;        // per point, [1,kMostRays]
    double radiusMm = 16; // how far they look
    bool filter = true;   // results of neighbouring points are averaged, along edges and not across
    bool operator==(const SurfaceOcclusion&) const = default;
};

struct Lighting {
    static constexpr std::size_t kMaxLights = 4;
    std::vector<Light> lights = {}; // none: one head light
    std::optional<Occlusion> occlusion = {};
    std::optional<SurfaceOcclusion> surfaceOcclusion = {}; // replaces occlusion if only surfaces are visible
    std::optional<Transport> transport = {};               // paths of light in place of the above
    std::optional<Environment> environment = {};           // what they see beyond the volume
    double scatterRadiusMm = 2; // how far away the tissue may be that scatters lights to a place
    int finestLevel = 0;        // of light per voxel; 1: one sample for 2^3 voxels, and so on
    bool operator==(const Lighting&) const = default;
};

/// Lights of intensity above 0, in the scene's order: numbers of lights refer to this list. A head light if
/// the scene has none.
std::vector<Light> shiningLights(const std::vector<Light>& lights);
/// Those of them with visible shadows; a light at the eye has none.
std::vector<Light> castingLights(const std::vector<Light>& lights);
/// True if tissue scatters the light of one of them to its surroundings.
bool scatters(const Lighting& lighting);
/// Channels of ambient light per voxel: none, one for all colours, or one each.
int ambientChannels(const Lighting& lighting);
/// Channels of light per voxel: ambient light, and the share of every light that casts a shadow.
int lightChannels(const Lighting& lighting);
constexpr int kMostLightChannels = 4;
/// The same, as stored: three take the room of four.
int keptLightChannels(const Lighting& lighting);
/// True if there is one white head light of intensity 1, and nothing else.
bool isHeadLightAlone(const std::vector<Light>& lights);
/// Upper bound on incident light: the largest RGB component of the lights' sum.
double maxIncidentLight(const std::vector<Light>& lights);

} // namespace tessera
