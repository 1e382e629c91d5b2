// render/backends/mirror/mirror_tracer.h: rays of light among isosurfaces, read through the brick cache:
// surfaceRay() of mirror_surfaces.h, in float. Every engine that has no tracer of its own uses it.
#pragma once

#include "render/backends/mirror/mirror_input.h"
#include "render/light/surface_tracer.h"

namespace tessera {

class MirrorTracer : public SurfaceTracer {
  public:
    /// Of the scene as it is, which outlives it.
    /// @param voxels  of a segment
    MirrorTracer(const FramePlan& scene, double voxels);
    MirrorTracer(const MirrorTracer&) = delete;
    MirrorTracer& operator=(const MirrorTracer&) = delete;
    void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const override;

  private:
    Optics optics_; // surfaces, and nothing else
    MirrorInput input_;
};

} // namespace tessera
