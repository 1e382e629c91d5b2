// render/engines/reference/surface_rays.h: where rays meet isosurfaces, by the reference's own means: the
// cubics of level 0 in double, cell by cell. What pictures' rays meet first, and what surfaces take of the
// light along a way.
#pragma once

#include "render/contract/optics.h"
#include "render/contract/ray_state.h"
#include "render/engines/reference/cells_on_ray.h"
#include "render/engines/reference/reference.h"
#include "render/engines/reference/stored_function.h"
#include "render/light/surface_tracer.h"

#include <vector>

namespace tessera {

class LatticeReader;

class ReferenceSurfaces : public SurfaceTracer {
  public:
    /// All that the input points at outlives it, slabs and cuts too.
    explicit ReferenceSurfaces(const ReferenceInput& input);

    /// Of each ray, in order. @param threads  0: all processors
    std::vector<SurfaceHit> firstHits(const std::vector<ReferenceRay>& rays, int threads) const;
    void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const override;

  private:
    template <typename Visit>
    void forEachCrossing(const ReferenceRay& ray, double t0, double t1, LatticeReader& samples,
                         const Visit& visit) const;
    SurfaceHit firstHit(const ReferenceRay& ray, LatticeReader& samples) const;

    ReferenceInput input_;
    StoredFunction function_;
    Optics optics_; // for normals
    EmptyCells emptyCells_;
};

} // namespace tessera
