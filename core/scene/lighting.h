// core/scene/lighting.h: a scene's lights and ambient occlusion (docs/sampling.md, "Shading").
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace tessera {

/// At the eye, along every ray; from one direction; from a place.
enum class LightKind { head, directional, point };
/// What a light's direction or place is fixed to. Camera: x to the picture's right, y up, z towards the
/// viewer, places from the eye (parallel projection: from the camera's position), mm. Patient: LPS.
enum class LightFrame { camera, patient };

struct Light {
    LightKind kind = LightKind::head;
    LightFrame frame = LightFrame::camera;
    glm::dvec3 direction{0, 0, 1};   // directional: towards the light, any length; 0: lights nothing
    glm::dvec3 position{0};          // point: mm
    glm::dvec3 attenuation{1, 0, 0}; // point: 1/(c + l d + q d^2), d mm
    double intensity = 1;
    glm::dvec3 colour{1}; // linear light
    bool shadow = false;  // it casts one
    double softness = 0;  // degrees, its diameter as seen from what it lights
    bool operator==(const Light&) const = default;
};

/// The part of a ray that counts (docs/sampling.md, "Light per voxel"). local: all of it, each part by the
/// light that is left there (course notes 6.1). positional: the light left at its end (volume-based ambient
/// occlusion, equation 8). rejecting: the same, but only density that grows along the ray takes light
/// (equations 4 to 7).
enum class OcclusionMethod { local, positional, rejecting };

/// Ambient occlusion: how much of the light that comes from all sides reaches a place.
struct Occlusion {
    OcclusionMethod method = OcclusionMethod::local;
    int rays = 32;
    double radiusMm = 16; // how far they look
    double offsetMm = 0;  // where they begin
    double bias = 0.1, gamma = 0.6;
    double emission = 0; // how strongly tissue that sends light lights what is around it; 0: not at all
    bool operator==(const Occlusion&) const = default;
};

/// Ambient occlusion of isosurfaces, from what rays of the picture meet first (docs/sampling.md, "Occlusion
/// of isosurfaces"): how much of the light from all sides other isosurfaces leave a place.
struct SurfaceOcclusion {
    static constexpr int kMostRays = 256;
    int rays = 16;        // directions of every place, [1,kMostRays]
    double radiusMm = 16; // how far they look
    bool filter = true;   // places side by side share what their rays found, along edges and not across
    bool operator==(const SurfaceOcclusion&) const = default;
};

struct Lighting {
    static constexpr std::size_t kMaxLights = 4;
    std::vector<Light> lights = {}; // none: one head light
    std::optional<Occlusion> occlusion = {};
    std::optional<SurfaceOcclusion> surfaceOcclusion =
        {};              // in place of occlusion, where surfaces are all that shows
    int finestLevel = 0; // of light that is kept of voxels; 1: one sample for 2^3 voxels, and so on
    bool operator==(const Lighting&) const = default;
};

/// Those that send light, in the scene's order: what numbers of lights mean everywhere else. A head light
/// where the scene names none.
std::vector<Light> shiningLights(const std::vector<Light>& lights);
/// Those of them whose shadows can be seen: a light at the eye casts none that can.
std::vector<Light> castingLights(const std::vector<Light>& lights);
/// Of light from all sides that is kept of every voxel: none, one for all colours, or one each.
int ambientChannels(const Lighting& lighting);
/// Light that is kept of every voxel: that from all sides, and the share of every light that casts a shadow.
int lightChannels(const Lighting& lighting);
constexpr int kMostLightChannels = 4;
/// The same, as many as memory is kept for: three take the room of four.
int keptLightChannels(const Lighting& lighting);
/// One white head light of intensity 1 shines, and nothing else.
bool isHeadLightAlone(const std::vector<Light>& lights);
/// Upper bound on incident light: the largest RGB component of the lights' sum.
double maxIncidentLight(const std::vector<Light>& lights);

} // namespace tessera
