// render/backends/native/packet_rays.h: the rays of a packet: twin of segmentedRay() in
// render/contract/ray.h, one ray a lane. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"

namespace tessera::TESSERA_LANES {

using native::PacketFrame;
using native::PacketJob;
using native::PacketPlaces;

TESSERA_LANE F length(F3 v) {
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

inline void makeRays(const PacketFrame& f, const PacketPlaces& places, PacketJob& job) {
    const F one(1.0f), two(2.0f), zero(0.0f);
    const F px = load(places.x), py = load(places.y);
    const F x = two * px / F(f.imageSize[0]) - one, y = one - two * py / F(f.imageSize[1]);
    const auto three = [](const float(&v)[3]) { return F3{F(v[0]), F(v[1]), F(v[2])}; };
    const F3 right = three(f.right), up = three(f.up), toCentre = three(f.toCentre);
    const F3 offset = x * right + y * up;
    const F3 along = f.perspective ? toCentre + offset : toCentre;
    const F distance = length(along);
    const F3 base = three(f.centre) + offset;
    const F3 direction{along.x / distance, along.y / distance, along.z / distance};
    const auto column = [&](int n) {
        return F3{F(f.patientFromVoxel[3 * n]), F(f.patientFromVoxel[3 * n + 1]),
                  F(f.patientFromVoxel[3 * n + 2])};
    };
    const F mmPerVoxel = length(direction.x * column(0) + direction.y * column(1) + direction.z * column(2));
    F t0 = f.perspective ? zero - distance : F(-kMostFloat), t1(kMostFloat);
    M meets = every();
    const auto clip = [&](F o, F d, float extent) {
        const M runsAlong = d == zero;
        meets = meets & ~(runsAlong & ((o < zero) | (o > F(extent))));
        const F a = (zero - o) / d, b = (F(extent) - o) / d;
        t0 = select(runsAlong, t0, max(t0, min(a, b)));
        t1 = select(runsAlong, t1, min(t1, max(a, b)));
    };
    clip(base.x, direction.x, f.extent[0]);
    clip(base.y, direction.y, f.extent[1]);
    clip(base.z, direction.z, f.extent[2]);
    M here = t1 > t0;
    for (int n = 0; n < f.slabCount; ++n) {
        const native::PacketFrame::Slab& s = f.slabs[n];
        const F3 normal = three(s.normal);
        const F o = normal.x * base.x + normal.y * base.y + normal.z * base.z;
        const F d = normal.x * direction.x + normal.y * direction.y + normal.z * direction.z;
        const M runsAlong = d == zero;
        const M outside = s.low < s.high ? (o < F(s.low)) | (o > F(s.high)) : every();
        meets = meets & here & ~(runsAlong & outside);
        const F a = (F(s.low) - o) / d, b = (F(s.high) - o) / d;
        t0 = select(runsAlong, t0, max(t0, min(a, b)));
        t1 = select(runsAlong, t1, min(t1, max(a, b)));
        here = f.flat ? ~(t1 < t0) : t1 > t0;
    }
    const F first = t0 + load(places.phase) * F(f.segmentVoxels);
    const F segments = (t1 - first) / F(f.segmentVoxels);
    meets = meets & here & (segments < F(16777216.0f)); // more than float can count, or no number: nothing
    const I count = f.flat ? select(meets, I(1), I(0))
                           : select(meets, truncated(ceil(select(meets, segments, zero))), I(0));
    const F3 entry = base + first * direction, step = F(f.segmentVoxels) * direction;
    store(job.entry[0], entry.x), store(job.entry[1], entry.y), store(job.entry[2], entry.z);
    store(job.step[0], step.x), store(job.step[1], step.y), store(job.step[2], step.z);
    store(job.direction[0], direction.x), store(job.direction[1], direction.y);
    store(job.direction[2], direction.z);
    store(job.segmentMm, F(f.segmentVoxels) * mmPerVoxel);
    store(job.tail, segments - number(count - I(1)));
    store(job.count, count);
}

} // namespace tessera::TESSERA_LANES
