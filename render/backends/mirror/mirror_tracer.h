// render/backends/mirror/mirror_tracer.h: rays of light among isosurfaces, read through the brick cache:
// surfaceRay() of mirror_surfaces.h, in float. Engines without a tracer of their own use it.
#pragma once

#include "render/backends/mirror/mirror_input.h"
#include "render/light/surface_tracer.h"

namespace tessera {

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
