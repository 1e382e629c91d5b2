// render/backends/native/native_tracer.h: rays of light among isosurfaces, in packets: the ray casting loop
// of packet_surfaces.h through the bricks as they are drawn. Bit-equal to the mirror's (mirror_surfaces.h).
#pragma once

#include "render/backends/native/packet.h"
#include "render/light/surface_light.h"

namespace tessera {

class NativeTracer : public SurfaceTracer {
  public:
    /// @param scene  of a caster, which outlives it; all its bricks are there
    NativeTracer(native::PacketScene scene, const native::PacketTarget& target, double voxels);
    void trace(std::span<const LightWay> ways, std::span<LightTaken> taken) const override;

  private:
    native::PacketScene scene_;
    int lanes_;
    double voxels_; // of a segment
    native::PacketMarch march_;
};

} // namespace tessera
