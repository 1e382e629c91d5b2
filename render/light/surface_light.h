// render/light/surface_light.h: ambient occlusion of isosurfaces (docs/sampling.md, "Occlusion of
// isosurfaces"; course notes 5 and 9.2.3), deferred from the first hits of a picture's rays. Occlusion rays
// start where the middles of pixels hit, and their results are filtered along edges. The ambient light that a
// ray's first surface loses is added to the ray's colour, negative.
#pragma once

#include "core/base/progress.h" // ShareDone
#include "core/image/image.h"
#include "render/contract/ray_state.h"
#include "render/light/surface_tracer.h"
#include "render/plan/frame_plan.h"

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

namespace tessera {

/// Directions in the hemisphere of a normal, the more the nearer to it (by the cosine), one of each of so
/// many parts of it. All sets are alike but for a turn that a key decides.
/// @param normal  unit
/// @param key  the same directions for the same one
std::vector<glm::dvec3> hemisphereDirections(const glm::dvec3& normal, int count, std::uint64_t key);
/// Of a place on a picture, in pixels.
std::uint64_t hemisphereKey(const glm::vec2& place, std::uint32_t seed);

class SurfaceLight {
  public:
    /// The plan outlives it; its scene has occlusion of surfaces (checked).
    /// @param finestSamples  of the volume's own, whatever levels were chosen: the reference's
    /// @param threads  0: all processors
    SurfaceLight(const FramePlan& plan, int threads, bool finestSamples = false);

    /// Looks around from what rays through the middles of all pixels met first.
    void look(std::vector<SurfaceHit> middles, const SurfaceTracer& tracer, const ShareDone& progress = {});
    bool hasLooked() const { return !open_.empty(); }
    /// What they met.
    const std::vector<SurfaceHit>& middles() const { return middles_; }

    /// What is added to the colours of rays by what they met first; alpha 0.
    /// @param places  of the rays on the picture; none: those of look()
    /// @param size    of their array
    Image added(std::span<const SurfaceHit> hits, std::span<const glm::vec2> places, const glm::ivec2& size,
                const SurfaceTracer& tracer) const;

    /// Share of the ambient light that gets to a place; not filtered.
    /// @param place  that decides directions
    float openAt(const SurfaceHit& hit, const glm::vec2& place, const SurfaceTracer& tracer) const;
    /// Of the middles of pixels, row by row, as they were found; 1 where nothing was met.
    const std::vector<float>& open() const { return open_; }

    /// RAM of a pixel.
    /// @param sampled  pixels have several samples
    static std::size_t bytesPerPixel(bool sampled);
    /// That ways take at a time, a segment of theirs, voxels.
    static constexpr double kSegmentVoxels = 1;

    struct Report {
        int rays = 0;
        double radiusMm = 0, seconds = 0;
        std::size_t places = 0, alone = 0; // that looked around: middles of pixels; samples beside them
        std::size_t bytes = 0;
    };
    const Report& report() const { return report_; }

  private:
    struct Way {
        LightWay way;
        double beginMm = 0; // from where all of its direction's begin
        int direction = 0;
    };
    void addWays(const SurfaceHit& hit, std::uint64_t key, std::vector<Way>& ways) const;
    void openAround(std::span<const SurfaceHit> hits, std::span<const std::uint64_t> keys,
                    const SurfaceTracer& tracer, std::span<float> open) const;
    double pitchAt(const glm::dvec3& voxel) const;
    float shared(const SurfaceHit& hit, const glm::ivec2& pixel) const;
    glm::vec2 placeOf(std::size_t pixel) const;

    const FramePlan& plan_;
    SurfaceOcclusion occlusion_;
    int threads_;
    bool finestSamples_;
    std::uint32_t seed_;
    glm::ivec2 size_;
    glm::dmat3 toVoxels_, toPatient_; // linear parts
    std::vector<SurfaceHit> middles_;
    std::vector<float> open_;
    mutable Report report_;
};

} // namespace tessera
