// render/backends/native/native_scene.h: a plan as packets of rays read it: numbers and pointers alone.
#pragma once

#include "render/backends/native/fine_blocks.h"
#include "render/backends/native/host_plane.h"
#include "render/backends/native/packet.h"
#include "render/contract/ray.h"
#include "render/contract/strides.h"
#include "render/plan/frame_plan.h"

#include <memory>
#include <vector>

namespace tessera {

/// Outlives all that is made of it.
struct PacketSceneInput {
    const FramePlan& plan;
    const HostPlane& plane;                                       // settled
    const std::vector<std::unique_ptr<HostPlane>>&light, &labels; // a plane a channel
    const Strides& strides;
    bool flat;                                // rays have one sample, at a plane
    bool keepsOn;                             // rays that keep one value go on in another interval
    const Occupancy* occupancy;               // null: nothing is leapt over
    const FineBlocks *blocks, *surfaceBlocks; // null: the maps are read as they are
};
native::PacketScene packetSceneOf(const PacketSceneInput& in);

/// Several volumes: all but their packets' scenes.
native::PacketFusion packetFusionOf(const FramePlan& plan, const Strides& strides);

native::PacketGradient packetGradient(Gradient gradient);

native::PacketFrame packetFrameOf(const RayFrame<float>& frame);

/// A lane's ray, but for what it has gathered.
void setRay(native::PacketJob& job, int lane, const SegmentedRay<float>& ray);

} // namespace tessera
