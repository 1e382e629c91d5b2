// core/scene/transport.h: light that a scene's picture follows along paths, with all its scatterings
// (docs/sampling.md, "Paths").
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>

namespace tessera {

enum class PhaseKind { henyeyGreenstein, schlick, rayleigh };

/// How a medium scatters light to all sides.
struct Phase {
    static constexpr double kMostG = 0.99;
    PhaseKind kind = PhaseKind::henyeyGreenstein;
    double g = 0; // mean cosine (Schlick: of the lobe that it is like), [-kMostG,kMostG]; 0: evenly. Henyey
                  // and Greenstein, Schlick
    /// Henyey and Greenstein: a second lobe, of mean cosine backG, and its share.
    double backG = 0, backShare = 0;
    bool operator==(const Phase&) const = default;
};

/// The frame of a light's direction or position. Camera: x to the picture's right, y up, z towards the
/// viewer, positions from the eye (parallel projection: from the camera's position), mm. Patient: LPS.
enum class LightFrame { camera, patient };

/// Uniform: the same from everywhere. Overcast: (1 + 2 z)/3 from above, z the height (CIE). Two tones: from
/// above and from below, in equal parts. Softboxes: two squares, to the left and to the right of the front.
enum class Sky { uniform, overcast, twoTone, softboxes };

class EnvironmentMap; // render/transport/environment_map.h

/// A picture of all directions, by longitude and latitude.
struct EnvironmentFile {
    std::filesystem::path path = {}; // OpenEXR or Radiance; "": none
    /// What was read of it; null until then. Not in files.
    std::shared_ptr<const EnvironmentMap> map = {};
    bool operator==(const EnvironmentFile& other) const { return path == other.path; }
};

/// Light from all around, at an infinite distance (docs/sampling.md, "Paths": directions).
struct Environment {
    Sky sky = Sky::uniform;
    double intensity = 1;                   // radiance overhead; of a file a factor
    glm::dvec3 colour{1};                   // linear
    glm::dvec3 below{0.25};                 // of two tones the lower one, of softboxes the right one
    glm::dvec3 up{0, 0, 1};                 // any length but 0
    EnvironmentFile file = {};              // in place of the sky
    double rotation = 0;                    // degrees about up, by the right hand
    LightFrame frame = LightFrame::patient; // of up, and of the front
    bool operator==(const Environment&) const = default;
};

/// Gradient lengths between volume and surface lighting, in physical units per mm. Shading is that of a
/// volume up to the lower one, that of a surface from the higher on.
struct GradientWeight {
    double low = 0, high = 0;
    bool operator==(const GradientWeight&) const = default;
};

/// How a surface answers light along paths: evenly to its own side and by a lobe to the other, below a coat
/// that mirrors.
struct SurfaceFinish {
    static constexpr double kMostPower = 1024;
    double mirrored = 0.028;      // share of light that the coat mirrors at right angles, [0,1]; 0: no coat
    double roughness = 0.35;      // of the coat, [0.05,1]
    double translucent = 0;       // share of light below the coat that goes through the surface, [0,1]
    double translucentPower = 10; // exponent of its lobe around the straight way, [0,kMostPower]; 0: even
    bool operator==(const SurfaceFinish&) const = default;
};

/// Where the field is steep, light is scattered as by a surface.
struct SurfaceScattering {
    GradientWeight gradient;
    SurfaceFinish finish = {};
    bool operator==(const SurfaceScattering&) const = default;
};

/// How tissue of a range of values answers light along paths, in place of the transport's own phase function
/// and of its surface's finish.
struct Tissue {
    double from = 0, to = 0; // physical units, `to` excluded
    std::optional<Phase> phase = {};
    std::optional<SurfaceFinish> finish = {};
    bool operator==(const Tissue&) const = default;
};

/// What a transfer function's colours are where tissue scatters as a medium. Albedo: the share of light that
/// one scattering leaves. Reflectance: the share that a thick layer of it sends back to who faces it, under
/// light from all sides.
enum class TransportColours { albedo, reflectance };

/// Physical: everything that a scene lights is lit by paths. Contract: the light that docs/sampling.md
/// defines under "Shading", with its shadows and local occlusion, without planes, maps and a number of rays:
/// one way to each light, and one to a side, in place of the shares that voxels have.
enum class TransportResponse { physical, contract };

/// A coarser light that takes less time (course notes 9.3.1). Few: after some scatterings what is in the way
/// takes light and scatters none. Squared: from the second scattering on all light comes as if by a way like
/// that from the first to it.
enum class PathPreview { none, few, squared };

/// By which gradients surfaces are turned where light is scattered: the operator of shading, or Sobel's,
/// whose normals are smooth.
enum class ScatteringNormals { shading, sobel };

/// How light gets through a scene: along paths, which tissue scatters.
struct Transport {
    static constexpr int kMostBounces = 256;
    static constexpr int kSamples = 64; // of a pixel, unless a scene names another number
    TransportResponse response = TransportResponse::physical;
    // Physical alone:
    int bounces = 8; // scatterings of a path, [1,kMostBounces]
    Phase phase = {};
    std::optional<SurfaceScattering> surface = {}; // none: a medium everywhere
    TransportColours colours = TransportColours::albedo;
    PathPreview preview = PathPreview::none;
    ScatteringNormals normals = ScatteringNormals::shading;
    bool operator==(const Transport&) const = default;
};

} // namespace tessera
