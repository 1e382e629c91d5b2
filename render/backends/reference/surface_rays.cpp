// render/backends/reference/surface_rays.cpp: see surface_rays.h.
#include "render/backends/reference/surface_rays.h"

#include "core/base/error.h"
#include "core/base/threads.h"
#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/reference_integrator.h"
#include "render/contract/lattice.h"
#include "render/contract/sampler.h"

#include <algorithm>

namespace tessera {

ReferenceSurfaces::ReferenceSurfaces(const ReferenceInput& input)
    : input_(input), function_(*input.function, input.surfaces, *input.info), optics_(shadingOf(input)),
      emptyCells_(input, function_), showsVolume_(!input.function->kinks().empty()) {}

/// Calls visit(t, number of the surface) in order along the ray between t0 and t1, until it returns true.
/// @param between  (cell, from, to) of the parts before, between and behind them, but for cells that show
/// nothing
template <typename Between, typename Visit>
void ReferenceSurfaces::forEachCrossing(const ReferenceRay& ray, double t0, double t1, LatticeReader& samples,
                                        const Between& between, const Visit& visit) const {
    StretchesOfRay stretches;
    bool done = false;
    const auto inCell = [&](double ta, double tb) {
        if (done)
            return;
        const auto position = [&](double t) { return ray.base + t * ray.direction; };
        const Cell cell(samples, glm::ivec3(glm::floor(position(0.5 * (ta + tb)) - 0.5)));
        if (function_.emptyOver(cell.lowest(), cell.highest()))
            return;
        double from = ta;
        done = crossSurfaces(stretches.through(cell, position, ta, tb), function_.surfaces(),
                             [&](double u, std::size_t number) {
                                 const double t = ta + u * (tb - ta);
                                 between(cell, from, t);
                                 from = t;
                                 return visit(t, number);
                             });
        if (!done)
            between(cell, from, tb);
    };
    forEachInterval(ray, t0, t1, kCellExtent, 0, [&](double ta, double tb) {
        if (!done && !emptyCells_.hold(ray, ta, tb))
            forEachInterval(ray, ta, tb, 1.0, 0.5, inCell);
    });
}

SurfaceHit ReferenceSurfaces::firstHit(const ReferenceRay& ray, LatticeReader& samples, double& at) const {
    SurfaceHit hit;
    const RayLine<double> line{ray.base, ray.direction, ray.tMin, 1};
    double t0 = 0, t1 = 0;
    if (!clipToBox(line, glm::dvec3(input_.info->extentVoxels), t0, t1))
        return hit;
    for (const RaySlab<double>& slab : input_.slabs)
        if (!clipToSlab(line, slab, t0, t1) || !(t1 > t0))
            return hit;
    t1 = std::min(t1, ray.tMax);
    if (!(t1 > t0))
        return hit;
    std::vector<RayCuts::Part> parts = {{t0, t1}};
    if (input_.cuts)
        input_.cuts->parts(ray.base, ray.direction, t0, t1, parts);
    bool ends = false; // at what hides all behind it
    for (const RayCuts::Part& part : parts)
        if (hit.surface == 0 && !ends)
            forEachCrossing(
                ray, part.from, part.to, samples, [](const Cell&, double, double) {},
                [&](double t, std::size_t number) {
                    const Isosurface& surface = function_.surfaces()[number];
                    if (input_.reflects && !surface.reflection)
                        return ends = surface.drawnOpacity() >= 1;
                    const glm::dvec3 p = ray.base + t * ray.direction;
                    at = t;
                    hit.position = glm::vec3(p);
                    hit.normal = glm::vec3(unitNormal(
                        optics_, fieldGradient(samples, p, 1.0, input_.shading.gradient), ray.direction));
                    hit.surface = static_cast<int>(number) + 1;
                    hit.weight = 1;
                    return true;
                });
    return hit;
}

std::vector<SurfaceHit> ReferenceSurfaces::firstHits(const std::vector<ReferenceRay>& rays, int threads,
                                                     std::vector<double>& at) const {
    at.assign(rays.size(), 0);
    constexpr std::size_t kStrip = 64;
    std::vector<SurfaceHit> hits(rays.size());
    parallelFor((rays.size() + kStrip - 1) / kStrip, threads, [&](std::size_t strip) {
        LatticeReader samples(*input_.cache, *input_.info, 0, nullptr);
        for (std::size_t i = strip * kStrip; i < std::min(rays.size(), (strip + 1) * kStrip); ++i)
            hits[i] = firstHit(rays[i], samples, at[i]);
    });
    return hits;
}

void ReferenceSurfaces::trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const {
    TESSERA_CHECK(ways.size() == taken.size());
    LatticeReader samples(*input_.cache, *input_.info, 0, nullptr);
    for (std::size_t n = 0; n < ways.size(); ++n) {
        const LightWay& way = ways[n];
        ReferenceIntegrator integral; // of distances as colours
        const auto distance = [&](double t) { return glm::dvec3(t * way.mmPerVoxel, 0, 0); };
        const auto volume = [&](const Cell& cell, double from, double to) {
            if (!showsVolume_ || !(to > from))
                return;
            integral.add(from, to, [&](double t) {
                const glm::dvec3 p = way.from + t * way.direction;
                double extinction = function_.extinction(cell.at(p));
                if (extinction > 0 && optics_.grades())
                    extinction *= gradientFactor(optics_, fieldGradient(samples, p, 1.0, optics_.gradient));
                return RadiantPoint{extinction * way.mmPerVoxel, distance(t)};
            });
        };
        forEachCrossing({way.from, way.direction, 0}, 0, way.voxels, samples, volume,
                        [&](double t, std::size_t number) {
                            integral.addSurface(distance(t), function_.surfaces()[number].drawnOpacity());
                            return integral.opaque();
                        });
        taken[n] = {static_cast<float>(integral.alpha()), static_cast<float>(integral.colour().x)};
    }
}

} // namespace tessera
