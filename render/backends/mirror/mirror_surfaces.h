// render/backends/mirror/mirror_surfaces.h: rays through a volume with isosurfaces (docs/sampling.md,
// "Isosurfaces"), on the CPU; counterpart of shaders/march_surface.glsl and march_surface_loop.glsl.
#pragma once

#include "core/base/work.h"
#include "render/backends/mirror/mirror_input.h"
#include "render/backends/mirror/mirror_places.h"
#include "render/contract/cell_roots.h"
#include "render/contract/integrators.h"
#include "render/contract/ray.h"
#include "render/contract/ray_state.h"
#include "render/contract/sampler.h" // gradientValues
#include "render/light/surface_light.h"

#include <limits>
#include <vector>

namespace tessera {

/// The first plane of sample centres of this pitch on a ray beyond w, in segments from start.
template <typename Real>
Real nextPlane(const glm::vec<3, Real>& start, const glm::vec<3, Real>& step, Real w, Real pitch,
               Real segmentVoxels) {
    Real next = std::numeric_limits<Real>::max();
    const Real least = w + Real(leaf::kPlaneMargin) / segmentVoxels;
    for (int axis = 0; axis < 3; ++axis)
        if (step[axis] != Real(0))
            next = std::min(next, leaf::planeBehind(start[axis], step[axis], w, pitch, least));
    return next;
}

/// The progress of a ray: its next segment, and what it has gathered.
template <typename Real> struct SurfaceRayState {
    int next = 0;
    glm::vec<4, Real> sum{0};
};

/// Continues a ray from its state to its end, or to a stride where field.lacks(): there it stops with the
/// state before that stride.
/// @param field  as mirrorRay()'s; lacks() besides
/// @param sought  or null; the ray ends there
template <typename Real, typename Field>
void surfaceRay(const SegmentedRay<Real>& ray, Field& field, const MirrorInput& input, Work& work,
                SurfaceHit* hit, SurfaceRayState<Real>& state, SeenPlace<Real>* sought = nullptr) {
    using Vec = glm::vec<3, Real>;
    const Optics& optics = *input.optics;
    const bool ends = needsEnds(optics.integrator);
    const Occupancy* near = input.surfaceOccupancy ? input.surfaceOccupancy : input.occupancy;
    std::vector<Real> isovalues;
    for (const SurfaceLook& s : optics.surfaces)
        isovalues.push_back(static_cast<Real>(s.isovalue));
    glm::vec<4, Real>& sum = state.sum;
    const auto over = [&](const Vec& colour, Real alpha) {
        composite(sum, colour, alpha);
        return Real(1) - sum.a < static_cast<Real>(optics.termination) || !(Real(1) - sum.a > Real(0));
    };
    const auto seen = [&](const Vec& colour, const Vec& gradient, const Vec& position, const auto& material) {
        return seenColour(optics, colour, gradient, ray.direction, position, material, field);
    };
    Real front = 0;     // the field at the start of segment i
    bool known = false; // front is
    int& i = state.next;
    while (i < ray.count) {
        ++work.iterations;
        [[maybe_unused]] const glm::vec<4, Real> before = sum;
        [[maybe_unused]] const bool metBefore = hit && hit->surface != 0;
        const int n = strideAt(input.strides, ray, i);
        const Real length = strideLength(ray, i, n);
        const Vec start = segmentStart(ray, i), end = strideEnd(ray, i, length);
        if (input.occupancy) {
            const int next = nextNotClear(*input.occupancy, input.strides, ray, i);
            if (next > i) {
                i = next;
                known = false;
                continue;
            }
        }
        ++work.segments;
        const bool solves = !near || !isClear(*near, start, end), needs = solves || ends;
        work.samples += !needs ? 0 : known ? 1 : 2;
        if (needs && !known)
            front = field.value(start);
        const Real back = needs ? field.value(end) : Real(0);
        bool done = false; // nothing behind is seen
        // The volume between two places of the stride, segments from its start.
        const auto addVolume = [&](Real from, Real to, Real valueFrom, Real valueTo) {
            const Real part = to - from;
            if (!optics.volumeShows || !(part > Real(0)) || done)
                return;
            const Vec middle = start + (from + Real(0.5) * part) * ray.step;
            work.samples += ends ? 0 : 1;
            const SegmentEnd<Real> b = endOf(optics, ends ? valueTo : field.value(middle));
            const SegmentEnd<Real> a = ends ? endOf(optics, valueFrom) : b;
            Real extinction = segmentExtinction(optics, a, b);
            if (!(extinction > Real(0)))
                return;
            Vec gradient(0);
            const bool smooths = optics.shading && optics.smooths();
            if (optics.grades() || (optics.shading && !smooths)) {
                gradient = field.gradient(middle);
                work.samples += static_cast<std::uint64_t>(gradientValues(optics.gradient));
            }
            if (optics.grades())
                extinction *= gradientFactor(optics, gradient);
            if (smooths) {
                gradient = normalGradient(optics, field, middle);
                work.samples += static_cast<std::uint64_t>(gradientValues(optics.normals));
            }
            const Real depth = extinction * (part * ray.segmentMm);
            const Real alpha = opacityOf(depth);
            const Vec unlit = segmentColour(optics, a, b, depth, alpha, n);
            const auto placeOf = [&](Real share) { return start + (from + share * part) * ray.step; };
            if (sought && alpha > Real(0) && takePlace(sum.a, alpha, depth, unlit, -1, placeOf, *sought)) {
                done = true;
                return;
            }
            if (input.showsDistances) {
                done = over(
                    Vec((static_cast<Real>(i) + (from + Real(0.5) * part)) * ray.segmentMm, Real(0), Real(0)),
                    alpha);
                return;
            }
            const Vec colour =
                sought ? unlit : seen(unlit, gradient, middle, [&] { return materialOf(optics, a, b); });
            done = over(colour, alpha);
        };
        Real from = 0, valueFrom = front; // start of the part of the volume that is not added yet
        const auto addSurface = [&](Real at, std::size_t number) {
            if (done)
                return;
            const SurfaceLook& surface = optics.surfaces[number];
            addVolume(from, at, valueFrom, isovalues[number]);
            from = at;
            valueFrom = isovalues[number];
            if (done)
                return;
            const Vec p = start + at * ray.step;
            Vec gradient(0);
            if (optics.shading || hit) {
                gradient = normalGradient(optics, field, p);
                work.samples += static_cast<std::uint64_t>(gradientValues(optics.normals));
            }
            if (hit && hit->surface == 0 && surface.reports) {
                hit->position = glm::vec3(p);
                hit->weight = static_cast<float>(Real(1) - sum.a);
                hit->normal = glm::vec3(unitNormal(optics, gradient, ray.direction));
                hit->surface = static_cast<int>(number) + 1;
            }
            if (input.showsDistances) {
                done = over(Vec((static_cast<Real>(i) + at) * ray.segmentMm, Real(0), Real(0)),
                            static_cast<Real>(surface.opacity));
                return;
            }
            if (sought && takePlace(
                              sum.a, static_cast<Real>(surface.opacity), Real(1), Vec(surface.colour),
                              static_cast<int>(number), [&](Real) { return p; }, *sought)) {
                done = true;
                return;
            }
            const auto material = [&] { return materialAt(optics, placeOf(optics, isovalues[number])); };
            done = over(seen(Vec(surface.colour), gradient, p, material), static_cast<Real>(surface.opacity));
        };
        if (solves) {
            Real w = 0, value = front;
            while (w < length && !done) {
                const Vec p = start + w * ray.step;
                const Real next = std::min(nextPlane(start, ray.step, w, field.pitch(p),
                                                     static_cast<Real>(input.strides.segmentVoxels)),
                                           length);
                const Real piece = next - w;
                const Real v1 = field.value(start + (w + piece * Real(1.0 / 3)) * ray.step);
                const Real v2 = field.value(start + (w + piece * Real(2.0 / 3)) * ray.step);
                const Real v3 = next == length ? back : field.value(start + next * ray.step);
                work.samples += next == length ? 2 : 3;
                forEachCrossing<Real>(value, v1, v2, v3, isovalues,
                                      [&](Real u, std::size_t number) { addSurface(w + u * piece, number); });
                w = next;
                value = v3;
            }
        }
        addVolume(from, length, valueFrom, back);
        if constexpr (requires { field.lacks(); }) {
            if (field.lacks()) {
                sum = before;
                if (hit && !metBefore)
                    *hit = SurfaceHit();
                return;
            }
        }
        front = back;
        known = needs;
        i = done ? ray.count : i + n;
    }
}

// Rays of light among isosurfaces, read through the brick cache: surfaceRay(), in float.
// Engines without a tracer of their own use it.

class MirrorTracer : public SurfaceTracer {
  public:
    /// For the current scene, which outlives it.
    /// @param voxels  of a segment
    MirrorTracer(const FramePlan& scene, double voxels);
    MirrorTracer(const MirrorTracer&) = delete;
    MirrorTracer& operator=(const MirrorTracer&) = delete;
    void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const override;

  private:
    Optics optics_; // of surfaces alone
    MirrorInput input_;
};

} // namespace tessera
