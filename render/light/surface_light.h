// render/light/surface_light.h: ambient occlusion of isosurfaces and meshes (docs/sampling.md, "Occlusion of
// isosurfaces"; course notes 5 and 9.2.3), deferred from the first hits of a picture's rays. Occlusion rays
// start at the hits of pixel centres, and their results are filtered along edges. The ambient light that a
// ray's first surface loses is added to the ray's colour, negative.
#pragma once

#include "core/base/progress.h" // ShareDone
#include "core/image/image.h"
#include "core/image/picture_tile.h"
#include "render/contract/ray_state.h"
#include "render/geometry/bit_rays.h"
#include "render/light/light_ways.h"
#include "render/plan/frame_plan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

namespace tessera {

// SurfaceTracer: rays of light among isosurfaces, in the volume where that shows, and the light that these
// take. An engine traces them (RayCaster::surfaceTracer()), or the mirror does. All find the same points.

/// The light that isosurfaces and the volume take along a ray.
struct LightTaken {
    float taken = 0; // total, of 1
    float mm = 0;    // sum over what takes it of its part times its distance along the ray
};

class SurfaceTracer {
  public:
    virtual ~SurfaceTracer() = default;
    /// One per ray, in order. Thread-safe.
    /// @param taken  as many as rays
    virtual void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const = 0;
};

/// Cosine-weighted stratified directions in the hemisphere of a normal. Sets differ only by a rotation that
/// depends on a key.
/// @param normal  unit
/// @param key  equal keys give equal directions
std::vector<glm::dvec3> hemisphereDirections(const glm::dvec3& normal, int count, std::uint64_t key);
/// The key of a point on a picture, in pixels.
std::uint64_t hemisphereKey(const glm::vec2& place, std::uint32_t seed);

class SurfaceLight {
  public:
    /// The plan outlives it; its scene has occlusion of surfaces (checked).
    /// @param finestSamples  of level 0, whatever levels were chosen: for the reference
    /// @param threads  0: all processors
    /// @param part  of the picture, where hits are looked at; none: all of it
    SurfaceLight(const FramePlan& plan, int threads, bool finestSamples = false,
                 const std::optional<PictureTile>& part = {});

    /// Pixels around a part whose hits its own pixels take results from.
    static int margin(const SurfaceOcclusion& occlusion);
    /// Casts occlusion rays from the first hits of pixel centres: of all, or of one in scale^2.
    void look(std::vector<SurfaceHit> middles, const SurfaceTracer& tracer, const ShareDone& progress = {});
    bool hasLooked() const { return !open_.empty(); }
    /// These hits.
    const std::vector<SurfaceHit>& middles() const { return middles_; }

    /// The image to add to the colours of rays with these first hits; alpha 0.
    /// @param places  of the rays on the picture; none: those of look()
    /// @param meshAmbient  RayCaster::meshAmbient(); empty: no hit is of a mesh
    /// @param size    of their array
    Image added(std::span<const SurfaceHit> hits, std::span<const glm::vec3> meshAmbient,
                std::span<const glm::vec2> places, const glm::ivec2& size, const SurfaceTracer& tracer) const;

    /// Share of ambient light that reaches a hit; not filtered.
    /// @param place  for the key of directions
    float openAt(const SurfaceHit& hit, const glm::vec2& place, const SurfaceTracer& tracer) const;
    /// Shares at pixel centres, row by row, before filtering; 1 without a hit.
    const std::vector<float>& open() const { return open_; }

    /// RAM per pixel.
    /// @param sampled  pixels have several samples
    /// @param meshes  rays may meet some
    static std::size_t bytesPerPixel(bool sampled, bool meshes);
    /// Segment length of occlusion rays, voxels.
    static constexpr double kSegmentVoxels = 1;

    struct Report {
        int rays = 0;
        double radiusMm = 0, seconds = 0;
        std::size_t places = 0, alone = 0; // points with occlusion rays: pixel centres; other samples
        std::size_t bytes = 0;
    };
    const Report& report() const { return report_; }

  private:
    struct Way {
        WayPart part;
        int direction = 0;
    };
    struct Ways {
        std::vector<Way> ways;     // in the volume
        std::vector<double> reach; // of every direction: up to where meshes leave it free, mm
    };
    struct MeshPlace {
        glm::dvec3 place, normal; // patient space, mm; of the surface itself, unit, towards the viewer
    };
    MeshPlace onMesh(const SurfaceHit& hit) const;
    void addWays(const SurfaceHit& hit, std::uint64_t key, Ways& all) const;
    void openAround(std::span<const SurfaceHit> hits, std::span<const std::uint64_t> keys,
                    const SurfaceTracer& tracer, std::span<float> open) const;
    float shared(const SurfaceHit& hit, const glm::ivec2& pixel) const;
    glm::vec2 placeOf(std::size_t pixel) const;
    std::size_t pixelAt(const glm::ivec2& pixel) const;
    glm::ivec2 lookedFrom(const glm::ivec2& pixel) const;

    const FramePlan& plan_;
    SurfaceOcclusion occlusion_;
    int threads_;
    bool finestSamples_;
    std::uint32_t seed_;
    std::optional<BitRays> meshes_;   // none: there are no meshes
    bool volumeTakes_ = true;         // light
    int isosurfaces_ = 0;             // hits of a greater number are meshes'
    glm::ivec2 from_, size_;          // the pixels that are looked at
    glm::dmat3 toVoxels_, toPatient_; // linear parts
    std::vector<SurfaceHit> middles_;
    std::vector<float> open_;
    mutable Report report_;
};

} // namespace tessera
