// render/light/reflections.h: what isosurfaces mirror and what they show refracted (docs/sampling.md,
// "Reflections of isosurfaces"; course notes 3), deferred from the first hits of a picture's rays. Rays that
// leave a surface are drawn as rays of the eye are, order by order.
#pragma once

#include "core/image/image.h"
#include "render/contract/ray_state.h"
#include "render/light/light_ways.h"
#include "render/plan/frame_plan.h"
#include "render/transport/path_scene.h"

#include <array>
#include <cstddef>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

/// @param direction  of travel; any length
/// @param normal  unit, against it
glm::dvec3 mirroredDirection(const glm::dvec3& direction, const glm::dvec3& normal);
/// None: total reflection. Equation 3.8 of the course notes.
/// @param direction, normal  as above, unit both
/// @param eta  index of refraction here over that behind the surface
std::optional<glm::dvec3> refractedDirection(const glm::dvec3& direction, const glm::dvec3& normal,
                                             double eta);
/// The share of unpolarised light that a smooth dielectric mirrors (Fresnel); 1 of total reflection.
/// @param cosine  of the angle to the normal, [0,1]
double dielectricShare(double cosine, double eta);

class Reflections {
  public:
    /// Draws ways as rays of the picture: their colours, and their first hits.
    using Draw = std::function<void(std::span<const LightWay> ways, std::span<glm::vec4> colours,
                                    std::span<SurfaceHit> hits)>;

    /// The plan outlives it; its isosurfaces reflect (checked).
    /// @param finestSamples  of level 0, whatever levels were chosen: for the reference
    /// @param threads  0: all processors
    Reflections(const FramePlan& plan, int threads, bool finestSamples = false);

    /// The image to add to the colours of rays with these first hits; alpha 0.
    /// @param places  of the rays on the picture; none: the middles of its pixels
    /// @param size    of their array
    Image added(std::span<const SurfaceHit> hits, std::span<const glm::vec2> places, const glm::ivec2& size,
                const Draw& draw) const;

    /// RAM besides what draws the ways.
    /// @param sampled  pixels have several samples
    static std::size_t bytes(const glm::ivec2& imageSize, bool sampled);

    struct Report {
        std::array<std::size_t, Lighting::kMostReflections> ways{}; // by order, from 1 on
        std::size_t met = 0, near = 0; // ways that met such a surface; within two pitches of their start
        double seconds = 0;
    };
    const Report& report() const { return report_; }

  private:
    /// A ray at such a surface, or one that leaves it.
    struct Ray {
        std::size_t pixel = 0;
        float factor = 0;        // on its colour
        glm::dvec3 direction{0}; // unit, patient space
        SurfaceHit hit;          // a ray's at a surface
        glm::dvec3 from{0};      // a way's, voxels
        double pitchMm = 0;      // a way's, where it begins
    };
    struct Leaving {
        std::optional<Ray> mirrored, refracted;
    };
    template <typename Field> Leaving leave(const Ray& ray, Field& field) const;
    std::vector<Ray> waysFrom(std::span<const Ray> rays) const;
    std::vector<Ray> follow(std::span<const Ray> ways, const Draw& draw, Image& out) const;
    void followAll(std::vector<Ray> rays, int order, const Draw& draw, Image& out) const;
    bool reflectsAt(const SurfaceHit& hit) const;
    glm::dvec3 directionAt(const glm::vec2& place) const;

    const FramePlan& plan_;
    int threads_;
    bool finestSamples_;
    int most_; // orders
    std::size_t together_;
    glm::dmat3 toVoxels_, toPatient_; // linear parts
    Selection finest_;                // of finestSamples_
    std::optional<PathScene> sky_;
    mutable Report report_;
};

} // namespace tessera
