// render/engines/native/packet_light.h: occlusion of samples side by side (render/light/occlusion.h): all of
// a run send out the same rays, so that what they read lies side by side too. For packet_*.cpp alone.
#pragma once

#include "render/contract/leaves.h"
#include "render/engines/native/lanes.h"
#include "render/engines/native/packet.h"

namespace tessera::TESSERA_LANES {

namespace single {
/// 2^n of whole n from -126 to 127.
TESSERA_LANE F powerOfTwo(F n) {
    return asFloat(shl(truncated(n) + I(127), I(23)));
}
} // namespace single

using native::OcclusionPath;
using native::OcclusionStep;

/// Light below which the rest of a ray is left out: it would add less than that to a mean over rays.
constexpr float kNoLight = 1.0f / 65536;
constexpr int kStepsBetweenLooks = 4;

inline void opacities(const float* extinction, int count, float stepMm, float* out) {
    for (int n = 0; n < count; n += single::kWidth) {
        const single::F e = single::load(extinction + n);
        const single::M shows = single::F(0.0f) < e;
        if (bits(shows) == 0u)
            single::store(out + n, single::F(0.0f));
        else
            single::store(out + n, leaf::oneMinusExp(e * single::F(stepMm)));
    }
}

/// In registers one by one: as many as a run takes.
struct LightRun {
    single::F v[native::kOcclusionRun / single::kWidth];
};
template <typename Take> TESSERA_LANE LightRun runwise(const Take& take) {
    LightRun run;
    for (int n = 0; n < native::kOcclusionRun / single::kWidth; ++n)
        run.v[n] = take(n);
    return run;
}

template <native::OcclusionSum Kind>
inline void occludeBy(const float* opacity, const OcclusionPath* paths, int count, float* light) {
    using native::OcclusionSum;
    using single::F;
    LightRun sum = runwise([](int) { return F(0.0f); });
    for (const OcclusionPath* path = paths; path != paths + count; ++path) {
        const std::int64_t a = path->strideA, b = path->strideB;
        LightRun through = runwise([](int) { return F(1.0f); }), seen = runwise([](int) { return F(0.0f); });
        LightRun before = seen; // opacity, of what rejects
        if constexpr (Kind == OcclusionSum::rejecting)
            before = runwise([&](int r) { return single::load(opacity + r * single::kWidth); });
        for (int n = 0; n < path->count; ++n) {
            const OcclusionStep& step = path->steps[n];
            const float* const from = opacity + step.offset;
            const F weights[4] = {F(step.weight[0]), F(step.weight[1]), F(step.weight[2]), F(step.weight[3])};
            const LightRun after = runwise([&](int r) {
                const float* const q = from + r * single::kWidth;
                F alpha = (weights[0] * single::load(q) + weights[1] * single::load(q + a)) +
                          (weights[2] * single::load(q + b) + weights[3] * single::load(q + (a + b)));
                if constexpr (Kind == OcclusionSum::rejecting) {
                    const F last = before.v[r];
                    before.v[r] = alpha;
                    alpha = select(alpha + F(native::kRejectedFall) < last, F(0.0f), alpha);
                }
                return through.v[r] - through.v[r] * alpha;
            });
            if constexpr (Kind == OcclusionSum::local)
                seen = runwise([&](int r) { return seen.v[r] + (through.v[r] + after.v[r]); });
            through = after;
            if (n % kStepsBetweenLooks ==
                kStepsBetweenLooks - 1) { // a run together, however many lanes there are
                unsigned lit = 0;
                for (const F& t : through.v)
                    lit |= bits(F(kNoLight) < t);
                if (lit == 0)
                    break;
            }
        }
        const LightRun& got = Kind == OcclusionSum::local ? seen : through;
        sum = runwise([&](int r) { return sum.v[r] + F(path->share) * got.v[r]; });
    }
    for (int r = 0; r < native::kOcclusionRun / single::kWidth; ++r) {
        float* const to = light + r * single::kWidth;
        single::store(to, single::load(to) + sum.v[r]);
    }
}

inline void occlude(const float* opacity, const OcclusionPath* paths, int count, native::OcclusionSum sum,
                    float* light) {
    switch (sum) {
    case native::OcclusionSum::local:
        return occludeBy<native::OcclusionSum::local>(opacity, paths, count, light);
    case native::OcclusionSum::positional:
        return occludeBy<native::OcclusionSum::positional>(opacity, paths, count, light);
    case native::OcclusionSum::rejecting:
        return occludeBy<native::OcclusionSum::rejecting>(opacity, paths, count, light);
    }
}

} // namespace tessera::TESSERA_LANES
