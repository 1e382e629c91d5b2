// render/backends/native/packet_rays.h: the rays of a packet: as segmentedRay() in
// render/contract/ray.h, from the same leaves, one ray a lane. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"
#include "render/contract/leaves.h"

namespace tessera::TESSERA_LANES {

using native::PacketFrame;
using native::PacketJob;
using native::PacketPlaces;

inline void makeRays(const PacketFrame& f, const PacketPlaces& places, PacketJob& job) {
    const F zero(0.0f);
    const auto three = [](const float(&v)[3]) { return F3{F(v[0]), F(v[1]), F(v[2])}; };
    F3 base, direction;
    F distance;
    leaf::lineThrough(load(places.x), load(places.y), F(f.imageSize[0]), F(f.imageSize[1]), three(f.centre),
                      three(f.right), three(f.up), three(f.toCentre), f.perspective, base, direction,
                      distance);
    const F mmPerVoxel = leaf::length3(leaf::transformed(Columns{f.patientFromVoxel}, direction));
    F t0 = f.perspective ? zero - distance : F(-kMostFloat), t1(kMostFloat);
    M meets = every();
    const auto clip = [&](F o, F d, float extent) {
        meets = meets & ~leaf::clip(o, d, zero, F(extent), t0, t1);
    };
    clip(base.x, direction.x, f.extent[0]);
    clip(base.y, direction.y, f.extent[1]);
    clip(base.z, direction.z, f.extent[2]);
    M here = t1 > t0;
    for (int n = 0; n < f.slabCount; ++n) {
        const native::PacketFrame::Slab& s = f.slabs[n];
        const F3 normal = three(s.normal);
        meets =
            meets & here &
            ~leaf::clip(leaf::dot3(normal, base), leaf::dot3(normal, direction), F(s.low), F(s.high), t0, t1);
        here = f.flat ? ~(t1 < t0) : t1 > t0;
    }
    const F first = t0 + load(places.phase) * F(f.segmentVoxels);
    const F segments = (t1 - first) / F(f.segmentVoxels);
    meets = meets & here & (segments < F(16777216.0f)); // more than float can count, or no number: nothing
    const I count = f.flat ? select(meets, I(1), I(0))
                           : select(meets, truncated(ceil(select(meets, segments, zero))), I(0));
    const F3 entry = leaf::placeAlong(base, direction, first), step = F(f.segmentVoxels) * direction;
    store(job.entry[0], entry.x), store(job.entry[1], entry.y), store(job.entry[2], entry.z);
    store(job.step[0], step.x), store(job.step[1], step.y), store(job.step[2], step.z);
    store(job.direction[0], direction.x), store(job.direction[1], direction.y);
    store(job.direction[2], direction.z);
    store(job.segmentMm, F(f.segmentVoxels) * mmPerVoxel);
    store(job.tail, segments - number(count - I(1)));
    store(job.count, count);
}

} // namespace tessera::TESSERA_LANES
