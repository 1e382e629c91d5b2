// render/backends/native/packet_shadows.h: rays of deep shadow maps side by side, the same as lightAlong()
// (render/light/shadow_maps.h), and maps looked up at places side by side, the same as
// DeepShadowMap::between() (render/light/deep_shadow_map.h). For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet_march.h"
#include "render/backends/native/packet_tissue.h"

namespace tessera::TESSERA_LANES {

using native::PacketShadowMarch;
using native::PacketShadows;
using native::ShadowLook;

/// Lanes that take light: the light before and behind their strides.
/// @param follows  nothing lies between this stride and the last that was written
inline __attribute__((noinline)) void writeLight(PacketShadows& out, M takes, M follows, const F& start,
                                                 const F& end, const F& before, const F& behind) {
    alignas(64) float from[kWidth], to[kWidth], left[kWidth], after[kWidth];
    store(from, start), store(to, end), store(left, before), store(after, behind);
    const unsigned known = bits(follows);
    for (unsigned lanes = bits(takes); lanes != 0; lanes &= lanes - 1) {
        const int lane = __builtin_ctz(lanes);
        float* next = out.out[lane] + 2 * static_cast<std::int64_t>(out.written[lane]);
        if ((known >> lane & 1u) == 0) {
            next[0] = from[lane], next[1] = left[lane];
            next += 2;
            ++out.written[lane];
        }
        next[0] = to[lane], next[1] = after[lane];
        ++out.written[lane];
    }
}

template <SampleKind K, bool Mixed>
void shadowRays(const PacketScene& s, PacketJob& job, PacketShadows& out) {
    const PacketField& f = s.field;
    const PacketOptics& o = s.optics;
    const bool skips = s.space.map != nullptr;
    const PacketRays rays{load3(job.entry), load3(job.step), load(job.tail), load(job.count)};
    const F segmentMm = load(job.segmentMm), mmAtEntry = load(out.mmAtEntry);
    const LeapingRays leaping = leapingRays(rays.entry, rays.step);
    Here<Mixed> here = hereAtFirst<Mixed>(f);
    Strides strides;
    I i(0), written(-1); // the end of the last stride that was written
    F left(1.0f);
    M active = i < rays.count, ready = none();
    job.waiting = 0;
    while (any(active)) {
        const I n = shl(I(1), stridesAt<Mixed>(s, rays, strides, i, active));
        const F length = strideLength(rays, i, n);
        const F3 middle = along(rays, leaf::strideMiddle(number(i), length));
        if (skips) {
            const M leapt = leapOver<Mixed>(s, rays, strides, leaping, middle, n, i, active, ready);
            if (paysToWait(leapt, active, ready))
                continue;
        } else {
            ready = active;
        }
        if (!any(ready))
            continue;
        M m = ready;
        PacketRows rows;
        PacketRows* const kept = rowsToKeep(o, rows);
        const F value = valueOf<K, true>(s, here, middle, m, kept);
        if (any(ready & ~m)) {
            job.waiting = bits(ready & ~m);
            return;
        }
        F extinction = extinctionOf(o, entriesOf(o, value), m);
        if (isGraded(o)) {
            Beside beside;
            extinction = gradedExtinction<K>(s, here, middle, extinction, beside, m, kept);
            if (any(ready & ~m)) {
                job.waiting = bits(ready & ~m);
                return;
            }
        }
        const M takes = m & (extinction > F(0.0f));
        if (any(takes)) {
            const F behind = left * (F(1.0f) - opacityOf(extinction * (length * segmentMm), takes));
            writeLight(out, takes, written == i, mmAtEntry + number(i) * segmentMm,
                       mmAtEntry + (number(i) + length) * segmentMm, left, behind);
            left = select(takes, behind, left);
            written = select(takes, i + n, written);
            i = select(takes & (left < F(out.dark)), rays.count, i);
        }
        i = select(m, i + n, i);
        active = active & (i < rays.count);
        ready = none();
    }
}

template <SampleKind K> PacketShadowMarch shadowsOf(const PacketScene& s) {
    return s.field.mixed ? shadowRays<K, true> : shadowRays<K, false>;
}
inline PacketShadowMarch chooseShadows(const PacketScene& s) {
    return withSamples(s.field, [&](auto of) { return shadowsOf<decltype(of)::kind>(s); });
}

/// Points of a ray that are not beyond a distance.
TESSERA_LANE int pointsBefore(const float* ray, float mm) {
    constexpr int kPoints = native::kNumbersOfRay / 2;
    unsigned before = 0;
    for (int n = 0; n < kPoints; n += single::kWidth)
        before |= bits(single::load(ray + n) <= single::F(mm)) << n;
    return __builtin_popcount(before & ((1u << kPoints) - 1u));
}

/// A ray that nothing is in the way of.
constexpr float kLit[native::kNumbersOfRay] = {
    kMostFloat, kMostFloat, kMostFloat, kMostFloat, kMostFloat, kMostFloat, kMostFloat, kMostFloat,
    1,          1,          1,          1,          1,          1,          1,          1};

inline void addShadows(const ShadowLook& look, float* light) {
    using single::F;
    constexpr int kRun = native::kOcclusionRun, kPoints = native::kNumbersOfRay / 2;
    alignas(64) float x[kRun], y[kRun], mm[kRun];
    for (int n = 0; n < kRun; ++n) {
        const auto d = [&](int axis) {
            return ((look.place[axis] + static_cast<double>(n) * look.step[axis]) + look.offset[axis]) -
                   look.centre[axis];
        };
        const double dx = d(0), dy = d(1), dz = d(2);
        const auto along = [&](const double(&v)[3]) { return dx * v[0] + dy * v[1] + dz * v[2]; };
        x[n] = static_cast<float>(0.5 * (1 + along(look.right)) * static_cast<double>(look.size));
        y[n] = static_cast<float>(0.5 * (1 - along(look.up)) * static_cast<double>(look.size));
        mm[n] = static_cast<float>(along(look.forward));
    }
    alignas(64) float cornerX[kRun], cornerY[kRun], partX[kRun], partY[kRun];
    const auto split = [](const float* at, float* corner, float* part) {
        for (int n = 0; n < kRun; n += single::kWidth) {
            const F from = single::load(at + n) - F(0.5f), low = floor(from);
            single::store(corner + n, low);
            single::store(part + n, from - low);
        }
    };
    split(x, cornerX, partX);
    split(y, cornerY, partY);

    // For each of the four rays around a place: the points before and behind it; the same one twice beside
    // the first and the last.
    alignas(64) float mmBefore[4][kRun], mmBehind[4][kRun], lightBefore[4][kRun], lightBehind[4][kRun];
    const auto edge = static_cast<float>(look.size - 1);
    const std::int64_t row = std::int64_t{look.size} * native::kNumbersOfRay;
    for (int n = 0; n < kRun; ++n) {
        const float cx = cornerX[n], cy = cornerY[n];
        const float* ray[4];
        if (cx >= 0 && cy >= 0 && cx < edge && cy < edge) [[likely]] {
            ray[0] = look.rays + static_cast<std::int64_t>(cy) * row +
                     static_cast<std::int64_t>(cx) * native::kNumbersOfRay;
            ray[1] = ray[0] + native::kNumbersOfRay;
            ray[2] = ray[0] + row, ray[3] = ray[1] + row;
        } else { // unobstructed beyond the map's edges
            for (int r = 0; r < 4; ++r) {
                const float rx = cx + static_cast<float>(r & 1), ry = cy + static_cast<float>(r >> 1);
                ray[r] = rx >= 0 && ry >= 0 && rx <= edge && ry <= edge
                             ? look.rays + static_cast<std::int64_t>(ry) * row +
                                   static_cast<std::int64_t>(rx) * native::kNumbersOfRay
                             : kLit;
            }
        }
#pragma GCC unroll 4
        for (int r = 0; r < 4; ++r) {
            const int count = pointsBefore(ray[r], mm[n]);
            const int before = count > 0 ? count - 1 : 0, behind = count < kPoints ? count : kPoints - 1;
            mmBefore[r][n] = ray[r][before], mmBehind[r][n] = ray[r][behind];
            lightBefore[r][n] = ray[r][kPoints + before], lightBehind[r][n] = ray[r][kPoints + behind];
        }
    }
    for (int n = 0; n < kRun; n += single::kWidth) {
        const F at = single::load(mm + n);
        F l[4];
#pragma GCC unroll 4
        for (int r = 0; r < 4; ++r) {
            const F from = single::load(mmBefore[r] + n), to = single::load(mmBehind[r] + n);
            const F a = single::load(lightBefore[r] + n), b = single::load(lightBehind[r] + n);
            const F between = a + (b - a) * ((at - from) / (to - from));
            l[r] = min(max(select(from < to, between, a), F(0.0f)), F(1.0f));
        }
        const F px = single::load(partX + n), py = single::load(partY + n);
        const F above = l[0] + px * (l[1] - l[0]), below = l[2] + px * (l[3] - l[2]);
        single::store(light + n, single::load(light + n) + (above + py * (below - above)));
    }
}

} // namespace tessera::TESSERA_LANES
