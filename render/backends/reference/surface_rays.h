// render/backends/reference/surface_rays.h: crossings of rays and isosurfaces by the cubics of level 0 in
// double, cell by cell. They give the first hits of a picture's rays, and the light that surfaces and the
// volume take along a ray.
#pragma once

#include "render/backends/reference/cells_on_ray.h"
#include "render/backends/reference/reference.h"
#include "render/backends/reference/stored_function.h"
#include "render/contract/optics.h"
#include "render/contract/ray_state.h"
#include "render/light/surface_light.h"

#include <vector>

namespace tessera {

class LatticeReader;

class ReferenceSurfaces : public SurfaceTracer {
  public:
    /// All objects of the input outlive it, slabs and cuts included.
    explicit ReferenceSurfaces(const ReferenceInput& input);

    /// One per ray, in order; what lies before them leaves all light.
    /// @param threads  0: all processors
    /// @param at  gets their parameters along the rays
    std::vector<SurfaceHit> firstHits(const std::vector<ReferenceRay>& rays, int threads,
                                      std::vector<double>& at) const;
    bool showsVolume() const { return showsVolume_; }
    void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const override;

  private:
    template <typename Between, typename Visit>
    void forEachCrossing(const ReferenceRay& ray, double t0, double t1, LatticeReader& samples,
                         const Between& between, const Visit& visit) const;
    SurfaceHit firstHit(const ReferenceRay& ray, LatticeReader& samples, double& at) const;

    ReferenceInput input_;
    StoredFunction function_;
    Optics optics_; // for normals
    EmptyCells emptyCells_;
    bool showsVolume_;
};

} // namespace tessera
