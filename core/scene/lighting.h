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

/// To where occlusion rays of method local, positional and rejecting go. sphere: to all sides alike.
/// hemisphere: where tissue has a surface, weighted by the cosine with its normal, away from the denser side.
enum class OcclusionDirections { sphere, hemisphere };
/// More weight for directions of occlusion rays on one side: light that comes from there more than from
/// elsewhere (course notes 6.1, w_k of equation 6.1).
struct DirectionWeights {
    glm::dvec3 towards{0, 0, 1}; // patient space, any length above 0
    double strength = 1;         // a direction d weighs 1 + strength max(0, cosine of d and towards)
    bool operator==(const DirectionWeights&) const = default;
};

/// Ambient occlusion: the share of ambient light that reaches a point.
struct Occlusion {
    OcclusionMethod method = OcclusionMethod::local;
    int rays = 32;
    double radiusMm = 16; // how far they look
    double offsetMm = 0;  // where they begin
    double bias = 0.1, gamma = 0.6;
    double emission = 0; // factor on the light of emissive tissue on its surroundings; 0: none
    double bleeding = 0; // factor on the colours of tissue around, by histograms; 0: none
    std::optional<DirectionWeights> weights = {}; // none: all directions weigh the same
    OcclusionDirections directions = OcclusionDirections::sphere;
    bool operator==(const Occlusion&) const = default;
};

/// Ambient occlusion of isosurfaces and meshes at the first hits of the picture's rays (docs/sampling.md,
/// "Occlusion of isosurfaces"): the share of ambient light that other surfaces and the volume leave a point.
struct SurfaceOcclusion {
    static constexpr int kMostRays = 256, kLeastResolution = 16, kMostResolution = 512;
    int rays = 16;        // per point, [1,kMostRays]
    double radiusMm = 16; // how far they look
    bool filter = true;   // results of neighbouring points are averaged, along edges and not across
    int scale = 1; // 1, 2 or 4: of so many pixels along each axis one is looked at; above 1 with filter
    int resolution = 256;    // voxels of the meshes, along the longest side of their box
    double threshold = 0.45; // share of a mesh's voxels around a place from which on it is inside
    bool operator==(const SurfaceOcclusion&) const = default;
};

/// What shadow maps keep of a light's rays (docs/sampling.md, "Light per voxel"). deep: the light left at
/// every depth. first: the first hit. variance: the mean of first hits around, and of their squares.
enum class ShadowMapKind { deep, first, variance };
struct ShadowMapping {
    static constexpr int kMostFilter = 8;
    ShadowMapKind kind = ShadowMapKind::deep;
    // Not of deep maps:
    double threshold = 0.5; // opacity along a ray that is a hit
    int filter = 1;         // rays to either side that count
    bool operator==(const ShadowMapping&) const = default;
};

/// What brings scattered light to a place: rays to the tissue around it, or maps that light crosses slice by
/// slice (course notes 10; docs/sampling.md, "Light maps").
enum class ScatterSource { rays, map };
struct LightMapping {
    static constexpr int kLeastSize = 16, kMostSize = 192;
    static constexpr double kMostG = 0.95;
    int size = 128; // rays along a side of a map, and slices at most
    double g = 0.8; // mean cosine of the phase function (Henyey and Greenstein)
    bool operator==(const LightMapping&) const = default;
};

struct Lighting {
    static constexpr std::size_t kMaxLights = 4;
    static constexpr int kMostReflections = 8;
    std::vector<Light> lights = {}; // none: one head light
    std::optional<Occlusion> occlusion = {};
    std::optional<SurfaceOcclusion> surfaceOcclusion = {}; // replaces occlusion
    std::optional<Transport> transport = {};               // paths of light in place of the above
    std::optional<Environment> environment = {};           // what they and reflections see beyond the volume
    int reflectionOrder = 3;                               // of isosurfaces with a reflection
    ShadowMapping shadowMap = {};
    ScatterSource scatterBy = ScatterSource::rays;
    double scatterRadiusMm = 2; // rays: how far away the tissue may be that scatters lights to a place
    LightMapping lightMap = {}; // map
    int finestLevel = 0;        // of light per voxel; 1: one sample for 2^3 voxels, and so on
    bool operator==(const Lighting&) const = default;
};

/// Weight of a direction of occlusion rays; 1 in the mean over the sphere.
/// @param direction  unit, patient space
double directionWeight(const Occlusion& occlusion, const glm::dvec3& direction);
/// Lights of intensity above 0, in the scene's order: numbers of lights refer to this list. A head light if
/// the scene has none.
std::vector<Light> shiningLights(const std::vector<Light>& lights);
/// Those of them with visible shadows; a light at the eye has none.
std::vector<Light> castingLights(const std::vector<Light>& lights);
/// True if tissue scatters the light of one of them to its surroundings.
bool scatters(const Lighting& lighting);
/// True if light maps are needed for it.
bool scattersByMaps(const Lighting& lighting);
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
