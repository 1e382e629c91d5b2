// render/transport/traced_path.h: a path between its scatterings, and what follows from its place alone: its
// normal, ways from it, the light that it makes of a light's.
#pragma once

#include "render/contract/optics.h"
#include "render/transport/path_numbers.h"
#include "render/transport/path_scene.h"
#include "render/transport/phase.h"
#include "render/transport/tracking.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>

namespace tessera {

/// What a place makes of light.
struct PathTissue {
    glm::vec3 albedo{0}, emission{0};
    std::size_t number = 0; // of PathScene::tissues
};

/// Of the tissue that a value is.
inline std::size_t tissueNumber(const PathScene& scene, float value) {
    if (scene.tissues.size() > 1) {
        const float place = placeOf(*scene.optics, value);
        for (std::size_t n = 1; n < scene.tissues.size(); ++n)
            if (place >= scene.tissues[n].from && place < scene.tissues[n].to)
                return n;
    }
    return 0;
}

/// What a path's random numbers follow from: the place of its ray on the picture, pixels, and the number of
/// its sample (Rays::numbers).
struct PathStart {
    glm::vec2 place{0};
    std::optional<std::uint32_t> number = {};
};

/// A path between its scatterings.
struct TracedPath {
    /// @param place  of its ray on the picture, pixels
    /// @param number  of its sample (Rays::numbers), where its pixel has several
    TracedPath(const PathScene& scene, const glm::vec2& place, std::optional<std::uint32_t> number = {})
        : numbers(place, scene.seed) {
        if (number)
            numbers.setSample(*number);
    }

    PathNumbers numbers;
    glm::vec3 p{0};                  // voxels
    glm::vec3 travel{0};             // unit, patient space
    PathTissue tissue;               // there
    glm::vec3 sum{0}, throughput{1}; // of light
    int bounce = 0;                  // scatterings
    /// Of a surface, unit, patient space, on the viewer's side; none: the place scatters as a medium.
    bool isSurface = false;
    int isosurface = -1; // that its place is on, by number; -1: on none
    glm::vec3 normal{0};
    glm::vec3 albedo{0}; // of its scattering
    glm::vec3 shine{0};  // the light that comes by aim()'s way, where nothing is in it
    float density = 1;   // of turn()'s direction, per steradian; where the sky has a table
    float passed = 1;    // share of light between its first place and its second; where a preview asks
};

inline const TissueResponse& responseOf(const PathScene& scene, const TracedPath& path) {
    return scene.tissues[path.tissue.number];
}

/// What a preview makes of a path (docs/sampling.md, "Paths").
inline bool isSquared(const PathScene& scene, const TracedPath& path) {
    return scene.transport.preview == PathPreview::squared && path.bounce >= 2;
}
/// The way on only takes light.
inline bool isLast(const PathScene& scene, const TracedPath& path) {
    constexpr int kFew = 3;
    return isSquared(scene, path) || (scene.transport.preview == PathPreview::few && path.bounce >= kFew);
}
/// TracedPath::passed is to be found.
inline bool asksWhatPassed(const PathScene& scene, const TracedPath& path) {
    return scene.transport.preview == PathPreview::squared && path.bounce == 1;
}

inline const SurfaceResponse& surfaceOf(const PathScene& scene, const TracedPath& path) {
    const SurfaceResponses& of = path.isosurface >= 0
                                     ? scene.isosurfaces[static_cast<std::size_t>(path.isosurface)]
                                     : responseOf(scene, path).surface;
    return path.bounce > 1 ? of.later : of.first;
}

/// Steep places are surfaces, others with the chance that the length of their gradient gives them.
inline void findSurface(const PathScene& scene, TracedPath& path, const glm::vec3& gradient) {
    path.isSurface = false;
    if (!scene.transport.surface && path.isosurface < 0)
        return;
    const glm::vec3 g = leaf::transformed(scene.optics->voxelFromPatientTransposed, gradient);
    const float length = std::sqrt(glm::dot(g, g));
    if (path.isosurface >= 0) {
        path.isSurface = length > 0.0f;
    } else {
        const float t = std::clamp((length - scene.steepFrom) * scene.perSteep, 0.0f, 1.0f);
        path.isSurface = path.numbers.next() < t * t * (3.0f - 2.0f * t) && length > 0.0f;
    }
    if (path.isSurface) {
        path.normal = g / length;
        if (glm::dot(path.normal, path.travel) > 0.0f)
            path.normal = -path.normal;
    }
}

/// What a path's place scatters as.
inline void findScattering(const PathScene& scene, TracedPath& path, const glm::vec3& gradient) {
    findSurface(scene, path, gradient);
    path.albedo = path.tissue.albedo;
    if (scene.transport.colours == TransportColours::reflectance && !path.isSurface)
        for (int channel = 0; channel < 3; ++channel)
            path.albedo[channel] = albedoOf(path.albedo[channel], responseOf(scene, path).meanCosine);
}

/// From a place in a direction, unit, patient space, to where no tissue follows.
inline Way wayFrom(const PathScene& scene, const glm::vec3& p, const glm::vec3& direction) {
    const glm::vec3 perMm = scene.voxelFromPatient * direction;
    Way way{p, perMm, mmToLeave(p, perMm, scene.extent)};
    for (const RaySlab<float>& slab : scene.slabs)
        way.mm = std::min(way.mm, mmToLeave(p, perMm, slab));
    return way;
}

/// The way that light takes from a scattering. A surface stands for all that its tissue becomes within some
/// voxels: ways begin above it, so that slanted ones are not in the shadow of its unevenness, and those that
/// go through it as far below. From an isosurface they begin so near that it is not crossed again at once.
/// @param direction  unit, patient space
/// @param most  mm: how long it is at most
inline Way wayOn(const PathScene& scene, const TracedPath& path, const glm::vec3& direction, float most) {
    constexpr float kOffIsosurface = 1.0f / 128; // of the way from others
    if (!path.isSurface) {
        Way way = wayFrom(scene, path.p, direction);
        way.mm = std::min(way.mm, most);
        return way;
    }
    const float slant = glm::dot(path.normal, direction);
    float above = path.isosurface >= 0 ? kOffIsosurface * scene.leavesFromMm : scene.leavesFromMm;
    if (slant < 0.0f)
        above = -above;
    Way way = wayFrom(scene, path.p + above * (scene.voxelFromPatient * path.normal), direction);
    way.mm = std::min(way.mm, std::max(0.0f, most - above * slant));
    return way;
}

/// The way from a path's place to a light: the direction, drawn within the light's own, and where it
/// ends.
struct ToLight {
    bool any = false;
    glm::vec3 towards{0}; // unit, patient space
    float mm = std::numeric_limits<float>::max();
};
/// @param two  random numbers
inline ToLight wayTo(const PathScene& scene, const PathLight& light, const glm::vec3& p,
                     const glm::vec2& two) {
    ToLight to{true, light.towards};
    if (light.isPoint) {
        const glm::vec3 way = scene.optics->patientFromVoxel * (light.towards - p);
        to.mm = std::sqrt(glm::dot(way, way));
        to.any = to.mm > 0.0f;
        to.towards = to.any ? way / to.mm : way;
    }
    if (to.any && light.cosine < 1.0f)
        to.towards = directionAround(to.towards, 1.0f - two.x * (1.0f - light.cosine), two.y);
    return to;
}
/// What a path's place makes of light from a direction, per steradian of radiance.
inline glm::vec3 scatteredFrom(const PathScene& scene, const TracedPath& path, const glm::vec3& towards) {
    if (!path.isSurface)
        return path.albedo * phaseOf(responseOf(scene, path).phase, glm::dot(path.travel, towards));
    const float slant = glm::dot(path.normal, towards);
    return surfaceOf(scene, path).of(path.albedo, path.normal, -path.travel, towards) * std::abs(slant);
}
/// Density of the directions in which such a path goes on, per steradian.
inline float densityOf(const PathScene& scene, const TracedPath& path, const glm::vec3& towards) {
    return path.isSurface ? surfaceOf(scene, path).density(path.normal, -path.travel, towards)
                          : phaseOf(responseOf(scene, path).phase, glm::dot(path.travel, towards));
}
/// The light that comes by such a way, if nothing is in it.
inline glm::vec3 lightOf(const PathScene& scene, const PathLight& light, const ToLight& to,
                         const TracedPath& path) {
    glm::vec3 power = light.power;
    if (light.isPoint)
        power /= light.fading.x + to.mm * (light.fading.y + to.mm * light.fading.z);
    return power * scatteredFrom(scene, path, to.towards);
}
/// The sky's, by a direction of its table. A direction in which the path itself may go on counts by its share
/// of both densities (Veach and Guibas 1995, balance heuristic).
inline glm::vec3 lightOf(const PathScene& scene, const ToSky& to, const TracedPath& path) {
    return to.radiance * scatteredFrom(scene, path, to.towards) *
           (1.0f / (to.density + densityOf(scene, path, to.towards)));
}
/// What a path that leaves the volume sees of it: the other share.
inline glm::vec3 skyBeyond(const PathScene& scene, const TracedPath& path) {
    const glm::vec3 sky = skyFrom(scene, path.travel);
    return scene.skyTable ? sky * (path.density / (path.density + skyDensity(scene, path.travel))) : sky;
}

} // namespace tessera
