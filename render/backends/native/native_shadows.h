// render/backends/native/native_shadows.h: rays of deep shadow maps in packets, through the bricks as they
// are drawn (packet_shadows.h). Bit-equal to those of the cache's samples (lightAlong()).
#pragma once

#include "render/backends/native/host_plane.h"
#include "render/backends/native/packet.h"
#include "render/light/shadow_maps.h"
#include "render/plan/frame_plan.h"

namespace tessera {

class NativeShadows : public ShadowRays {
  public:
    /// True if packets have all that a scene's rays need.
    static bool canCast(const FramePlan& plan);
    /// @param plane  settled. Both outlive this
    NativeShadows(const FramePlan& plan, const HostPlane& plane,
                  const std::vector<std::unique_ptr<HostPlane>>& labels, const native::PacketTarget& target);
    std::size_t mostAtOnce() const override { return static_cast<std::size_t>(lanes_); }
    bool along(std::span<const SegmentedRay<float>> rays, std::span<const float> mmAtEntry, float dark,
               std::vector<LightLeft>& room, std::span<std::span<const LightLeft>> samples) const override;

  private:
    native::PacketScene scene_;
    int lanes_;
    native::PacketShadowMarch march_;
};

} // namespace tessera
