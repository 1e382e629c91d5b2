// render/backends/mirror/mirror.h: the mirror, a CPU oracle: the contract of docs/sampling.md in float and in
// double. The GPU ray caster in exact mode must equal the float mirror; a difference is a fault of one of
// them.
#pragma once

#include "bricking/levels/visibility.h"
#include "core/base/work.h"
#include "render/backends/mirror/mirror_fused.h"
#include "render/backends/mirror/mirror_input.h"
#include "render/backends/mirror/mirror_places.h"
#include "render/backends/mirror/mirror_sample.h"
#include "render/backends/mirror/mirror_surfaces.h"
#include "render/contract/integrators.h"
#include "render/contract/lattice.h"
#include "render/contract/optics.h"
#include "render/contract/ray.h"
#include "render/contract/ray_state.h"
#include "render/contract/sampler.h"
#include "render/empty_space/occupancy.h"
#include "render/empty_space/value_bounds.h"
#include "render/transport/path.h"
#include "render/transport/path_beginning.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

namespace tessera {

// Rays that keep one of the values along them, or their mean (docs/sampling.md, "Modes"), on the CPU;
// counterpart of shaders/march_values_loop.glsl.

/// Continues a ray to its end.
/// @param field  value(p) at a place in voxels
template <typename Real, typename Field>
void keepAlong(const SegmentedRay<Real>& ray, Field& field, const MirrorInput& input, Work& work,
               KeptValue<Real>& k) {
    const Optics& o = *input.optics;
    const bool least = o.reduction == Reduction::minimum;
    const Real end = least ? Real(0) : static_cast<Real>(o.table.size() - 1);
    k.any = k.any || ray.count > 0;
    for (int i = 0; i < ray.count;) {
        ++work.iterations;
        const int n = strideAt(input.strides, ray, i);
        const Real length = strideLength(ray, i, n);
        const glm::vec<3, Real> p = stridePosition(ray, i, length);
        if (input.bounds) {
            const int next = nextContributing(*input.bounds, input.strides, ray, i, n, p, k.kept);
            if (next > i) {
                i = next;
                continue;
            }
        }
        ++work.segments;
        ++work.samples;
        const Real value = field.value(p);
        if (o.reduction == Reduction::average) {
            k.kept = k.kept + length * value;
            k.length = k.length + length;
        } else {
            const Real place = clampedPlaceOf(o, value);
            k.kept = least ? std::min(k.kept, place) : std::max(k.kept, place);
            if (k.kept == end)
                return; // no value can change it
        }
        i += n;
    }
}

/// Composites a ray, or a part of it, behind what it has gathered before. Premultiplied colour and alpha.
/// @param field  value(p) and gradient(p) at a point in voxels; pitch(p), distance of samples there
/// @param hit  with isosurfaces: gets the first hit
/// @param at  or null; the ray ends there
template <typename Real, typename Field>
void compositeAlong(const SegmentedRay<Real>& ray, Field& field, const MirrorInput& input, Work& work,
                    SurfaceHit* hit, glm::vec<4, Real>& sum, SeenPlace<Real>* at = nullptr) {
    const Optics& optics = *input.optics;
    if (!optics.surfaces.empty()) {
        SurfaceRayState<Real> state{0, sum};
        surfaceRay(ray, field, input, work, hit, state, at);
        sum = state.sum;
        return;
    }
    const bool ends = needsEnds(optics.integrator);
    SegmentEnd<Real> front; // at the start of segment i
    bool known = false;     // front is
    [[maybe_unused]] Real firstSeen = Real(leaf::kNothingSeen);
    for (int i = 0; i < ray.count;) {
        ++work.iterations;
        const int n = strideAt(input.strides, ray, i);
        const Real length = strideLength(ray, i, n);
        if (input.occupancy) {
            const int next = ends ? nextShown(*input.occupancy, input.strides, ray, i)
                                  : nextOccupied(*input.occupancy, input.strides, ray, i, n,
                                                 stridePosition(ray, i, length));
            if (next > i) {
                i = next;
                known = false;
                continue;
            }
        }
        ++work.segments;
        ++work.samples;
        if (ends && !known) {
            ++work.samples;
            front = endOf(optics, field.value(segmentStart(ray, i)));
        }
        const SegmentEnd<Real> back =
            endOf(optics, field.value(ends ? strideEnd(ray, i, length) : stridePosition(ray, i, length)));
        SeenSegment<Real> seen;
        if (seeSegment(optics, field, front, back, stridePosition(ray, i, length), ray.direction,
                       length * ray.segmentMm, n, work, seen, !at)) {
            const auto placeOf = [&](Real share) {
                return leaf::placeAlong(ray.entry, ray.step, static_cast<Real>(i) + share * length);
            };
            if (seen.opacity > Real(0) && sum.a == Real(0))
                firstSeen = static_cast<Real>(i);
            if (at && seen.opacity > Real(0) &&
                takePlace(sum.a, seen.opacity, seen.extinction * (length * ray.segmentMm), seen.colour, -1,
                          placeOf, *at)) {
                if (at->parts && !ends) {
                    const Real from = leaf::soughtFrom(static_cast<Real>(i), length, firstSeen),
                               steps = (static_cast<Real>(i) - from) + length;
                    const auto partOf = [&](Real share) {
                        return leaf::placeAlong(ray.entry, ray.step, from + share * steps);
                    };
                    seekInParts(optics, field, ray.direction, steps * ray.segmentMm,
                                leaf::soughtShare(static_cast<Real>(i), from, at->alpha, sum.a, seen.opacity,
                                                  at->share),
                                partOf, work, *at);
                }
                return;
            }
            composite(sum, seen.colour, seen.opacity);
            if (Real(1) - sum.a < static_cast<Real>(optics.termination))
                break;
        }
        front = back;
        known = true;
        i += n;
    }
}

/// True if nothing behind it is visible.
template <typename Real> bool isOpaque(const Optics& optics, const glm::vec<4, Real>& sum) {
    return Real(1) - sum.a < static_cast<Real>(optics.termination) || !(Real(1) - sum.a > Real(0));
}

/// The same of the parts of one ray, in order.
template <typename Real, typename Field>
glm::vec<4, Real> mirrorRayOf(std::span<const SegmentedRay<Real>> parts, Field& field,
                              const MirrorInput& input, Work& work, SurfaceHit* hit) {
    const Optics& optics = *input.optics;
    if (optics.reduction != Reduction::composite) {
        KeptValue<Real> kept = keepsNothing<Real>(optics);
        for (const SegmentedRay<Real>& part : parts)
            keepAlong(part, field, input, work, kept);
        return colourOfKept(optics, kept);
    }
    glm::vec<4, Real> sum(0);
    for (const SegmentedRay<Real>& part : parts)
        if (!isOpaque(optics, sum))
            compositeAlong(part, field, input, work, hit, sum);
    return sum;
}

/// The same through several volumes.
template <typename Real>
glm::vec<4, Real> mirrorRayOf(std::span<const SegmentedRay<Real>> parts,
                              const std::vector<FusedField<Real>>& fields, const MirrorInput& input,
                              Work& work) {
    glm::vec<4, Real> sum(0);
    for (const SegmentedRay<Real>& part : parts)
        if (!isOpaque(*input.optics, sum))
            fusedAlong(part, fields, input, work, sum);
    return sum;
}

/// Premultiplied colour and alpha of one ray.
template <typename Real, typename Field>
glm::vec<4, Real> mirrorRay(const SegmentedRay<Real>& ray, Field& field, const MirrorInput& input, Work& work,
                            SurfaceHit* hit = nullptr) {
    return mirrorRayOf<Real>(std::span(&ray, 1), field, input, work, hit);
}

/// A ray's parts, in a list that is reused for all rays of a thread.
/// @param number  from input.firstRay on
template <typename Real>
std::span<const SegmentedRay<Real>> partsOf(const MirrorInput& input, const SegmentedRay<Real>& ray,
                                            std::size_t number, std::vector<SegmentedRay<Real>>& parts) {
    parts.clear();
    if (!input.cuts)
        parts.push_back(ray);
    else
        for (std::size_t n = 0; n < input.cuts->count(input.firstRay + number); ++n)
            parts.push_back(partOf(ray, input.cuts->at(input.firstRay + number, n),
                                   static_cast<Real>(input.segmentVoxels), input.hullSamples));
    return parts;
}

/// Source of rays: pixel index (row by row) -> ray.
template <typename Real> using RaySource = std::function<SegmentedRay<Real>(std::size_t)>;

/// One colour per ray, in order. Bit-equal at any number of threads.
template <typename Real>
std::vector<glm::vec<4, Real>> mirrorRays(const MirrorInput& input, std::size_t rayCount,
                                          const RaySource<Real>& rays, int threads, Work& work);

extern template std::vector<glm::vec4> mirrorRays<float>(const MirrorInput&, std::size_t,
                                                         const RaySource<float>&, int, Work&);
extern template std::vector<glm::dvec4> mirrorRays<double>(const MirrorInput&, std::size_t,
                                                           const RaySource<double>&, int, Work&);

/// The colour of a path of light that a ray sees the end of, and the ray's opacity.
/// @param parts  of the ray, in order
/// @param beginning  takes where the path begins; null: nobody asks
template <typename Field>
glm::vec4 pathColour(std::span<const SegmentedRay<float>> parts, Field& field, const MirrorInput& input,
                     const PathScene& scene, const PathStart& start, float alpha, Work& work,
                     PathBeginning* beginning = nullptr) {
    TracedPath path(scene, start.place, start.number);
    SeenPlace<float> at;
    at.alpha = path.numbers.pair(0).x * alpha;
    at.parts = scene.transport.response == TransportResponse::physical;
    glm::vec4 sum(0);
    for (const SegmentedRay<float>& part : parts)
        if (!at.found && !isOpaque(*input.optics, sum))
            compositeAlong(part, field, input, work, nullptr, sum, &at);
    if (!at.shows)
        return {0, 0, 0, alpha};
    PathTracer<Field> tracer(scene, field, work.paths);
    const glm::vec3& direction = parts.front().direction;
    path.isosurface = at.isosurface;
    if (at.isosurface >= 0)
        tracer.start(path, at.place, tracer.tissueOf(at.isosurface), direction);
    else
        tracer.start(path, at.place, at.colour, direction, field.value(at.place));
    if (beginning)
        *beginning = beginningOf(scene, path, field.gradient(at.place, scene.normals));
    if (scene.transport.response == TransportResponse::contract)
        return {alpha * tracer.contractColour(path, path.tissue.albedo, direction), alpha};
    return {alpha * tracer.lightFrom(path), alpha};
}

/// Sets colours of rays whose alpha is known to those of paths.
/// @param starts  of a ray, by its number
/// @param beginnings  of rays whose paths are asked where they begin; else none
void mirrorPaths(const MirrorInput& input, const PathScene& scene, const RaySource<float>& rays,
                 const std::function<PathStart(std::size_t)>& starts, std::span<glm::vec4> colours,
                 std::span<PathBeginning> beginnings, int threads, Work& work);

/// The first hits of rays and isosurfaces, one per ray, in order.
template <typename Real>
std::vector<SurfaceHit> mirrorHits(const MirrorInput& input, std::size_t rayCount,
                                   const RaySource<Real>& rays, int threads);
extern template std::vector<SurfaceHit> mirrorHits<float>(const MirrorInput&, std::size_t,
                                                          const RaySource<float>&, int);
extern template std::vector<SurfaceHit> mirrorHits<double>(const MirrorInput&, std::size_t,
                                                           const RaySource<double>&, int);

/// Adds the visibility of bricks along a ray, by the input's selection, strides and optics. Thread-safe.
/// @param field  value(p) and gradient(p) at a place in voxels
template <typename Field>
void seeAlong(const SegmentedRay<float>& ray, Field& field, const MirrorInput& input,
              std::span<SeenBrick> seen) {
    float alpha = 0;
    std::size_t last = seen.size();
    for (int i = 0, n = 0; i < ray.count; i += n) {
        n = strideAt(input.strides, ray, i);
        const float length = strideLength(ray, i, n);
        const glm::vec3 p = stridePosition(ray, i, length);
        const glm::ivec3 at =
            glm::clamp(glm::ivec3(p) / kBrickExtent, glm::ivec3(0), input.selection->bricks - 1);
        if (const std::size_t brick = linearIndex(at, input.selection->bricks); brick != last) {
            last = brick;
            std::atomic_ref(seen[brick].light) +=
                static_cast<std::uint32_t>((1 - alpha) * static_cast<float>(SeenBrick::kLightOfRay) + 0.5f);
            ++std::atomic_ref(seen[brick].rays);
        }
        float extinction = lookUp(*input.optics, field.value(p)).a;
        if (extinction > 0 && input.optics->grades())
            extinction *= gradientFactor(*input.optics, field.gradient(p));
        extinction = LabelledSample<float>(*input.optics, field, p).take(extinction);
        if (extinction > 0)
            alpha += (1 - alpha) * opacityOf(extinction * (length * ray.segmentMm));
    }
}

/// The visibility of bricks, counted like VisibilityPass: light is added in whole numbers, so the result does
/// not depend on threads. Shading, termination and occupancy are ignored.
std::vector<SeenBrick> mirrorSeen(const MirrorInput& input, std::size_t rayCount,
                                  const RaySource<float>& rays, int threads);

/// Phase of a ray, by its number in an array.
template <typename Real> Real phaseIn(const RayFrame<Real>& frame, std::size_t index, std::size_t columns) {
    return frame.phased ? phaseOf<Real>(static_cast<int>(index % columns), static_cast<int>(index / columns))
                        : Real(0);
}

/// Rays of a frame, row by row from the top left pixel.
template <typename Real> RaySource<Real> frameRays(const RayFrame<Real>& frame) {
    return [frame](std::size_t index) {
        const auto width = static_cast<std::size_t>(frame.imageSize.x);
        const glm::vec<2, Real> pixel(static_cast<Real>(index % width) + Real(0.5),
                                      static_cast<Real>(index / width) + Real(0.5));
        return segmentedRay(frame, pixel, phaseIn(frame, index, width));
    };
}
/// Rays through points on the picture; without points through every pixel centre. The points outlive it.
/// @param columns  of their array, for phases
template <typename Real>
RaySource<Real> frameRays(const RayFrame<Real>& frame, std::span<const glm::vec2> places, int columns = 1) {
    if (places.empty())
        return frameRays(frame);
    return [frame, places, columns](std::size_t index) {
        return segmentedRay(frame, glm::vec<2, Real>(places[index]),
                            phaseIn(frame, index, static_cast<std::size_t>(columns)));
    };
}

} // namespace tessera
