// render/backends/native/packet_light.h: occlusion of samples side by side (render/light/occlusion.h). All
// samples of a run send out the same rays, so their samples lie side by side too. For packet_*.cpp alone.
#pragma once

#include "render/backends/native/lanes.h"
#include "render/backends/native/packet.h"
#include "render/contract/leaves.h"

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

/// Between the four samples that a step reads.
/// @param from  the first of them, of register r
TESSERA_LANE single::F between(const float* from, const OcclusionStep& step, const OcclusionPath& path,
                               int r) {
    using single::F;
    const std::int64_t a = path.strideA, b = path.strideB;
    const float* const q = from + step.offset + r * single::kWidth;
    return (F(step.weight[0]) * single::load(q) + F(step.weight[1]) * single::load(q + a)) +
           (F(step.weight[2]) * single::load(q + b) + F(step.weight[3]) * single::load(q + (a + b)));
}

/// The share of light after half a step, by a step's opacity, which rounding may take beyond 1.
TESSERA_LANE single::F leftOfHalf(single::F opacity) {
    using single::F;
    return sqrt(max(F(0.0f), F(1.0f) - opacity));
}

/// Light of all paths together that gets to each of a run.
/// @param take  of every path: (path, light that it brings); its share of all
/// @param visit  at every place that is read: (step, path, light before it, behind it, half a step or
///     a whole one)
template <native::OcclusionSum Kind, typename Take, typename Visit>
TESSERA_LANE LightRun lightOver(const float* opacity, const OcclusionPath* paths, int count, const Take& take,
                                const Visit& visit) {
    using native::OcclusionSum;
    using single::F;
    LightRun sum = runwise([](int) { return F(0.0f); });
    for (const OcclusionPath* path = paths; path != paths + count; ++path) {
        const OcclusionStep* const steps = path->steps;
        const int last = path->count - 1;
        LightRun before = runwise([&](int r) { return between(opacity, steps[0], *path, r); });
        LightRun through = runwise([&](int r) {
            F alpha = before.v[r];
            if constexpr (Kind == OcclusionSum::rejecting)
                alpha = select(between(opacity, steps[1], *path, r) + F(native::kRejectedFall) < alpha,
                               F(0.0f), alpha);
            return leftOfHalf(alpha);
        });
        LightRun seen = runwise([](int) { return F(0.0f); });
        // A fall from a place to the next takes nothing.
        const auto taken = [&](int n, int r) {
            F alpha = between(opacity, steps[n], *path, r);
            if constexpr (Kind == OcclusionSum::rejecting) {
                const F one = before.v[r];
                before.v[r] = alpha;
                alpha = select(alpha + F(native::kRejectedFall) < one, F(0.0f), alpha);
            }
            return alpha;
        };
        const auto see = [&](int n, const LightRun& from, const LightRun& to, F part) {
            if constexpr (Kind == OcclusionSum::local)
                seen = runwise([&](int r) { return seen.v[r] + part * (from.v[r] + to.v[r]); });
            visit(steps[n], *path, from, to, part);
        };
        see(0, runwise([](int) { return F(1.0f); }), through, F(0.5f));
        bool isDark = false;
        for (int n = 1; n < last && !isDark; ++n) {
            const LightRun after = runwise([&](int r) { return through.v[r] - through.v[r] * taken(n, r); });
            see(n, through, after, F(1.0f));
            through = after;
            if (n % kStepsBetweenLooks == 0) { // a run together, however many lanes there are
                unsigned lit = 0;
                for (const F& t : through.v)
                    lit |= bits(F(kNoLight) < t);
                isDark = lit == 0;
            }
        }
        if (!isDark) {
            const LightRun after = runwise([&](int r) { return through.v[r] * leftOfHalf(taken(last, r)); });
            see(last, through, after, F(0.5f));
            through = after;
        }
        const LightRun& got = Kind == OcclusionSum::local ? seen : through;
        sum = runwise([&](int r) { return sum.v[r] + take(*path, r) * got.v[r]; });
    }
    return sum;
}
TESSERA_LANE single::F evenShare(const OcclusionPath& path, int) {
    return single::F(path.share);
}
TESSERA_LANE void addRun(const LightRun& run, float* light) {
    for (int r = 0; r < native::kOcclusionRun / single::kWidth; ++r) {
        float* const to = light + r * single::kWidth;
        single::store(to, single::load(to) + run.v[r]);
    }
}

template <native::OcclusionSum Kind>
inline void occludeBy(const float* opacity, const OcclusionPath* paths, int count,
                      const native::OcclusionNormals* normals, float* light) {
    using single::F;
    const auto nothing = [](const OcclusionStep&, const OcclusionPath&, const LightRun&, const LightRun&, F) {
    };
    if (!normals) {
        addRun(lightOver<Kind>(
                   opacity, paths, count, [](const OcclusionPath& path, int r) { return evenShare(path, r); },
                   nothing),
               light);
        return;
    }
    LightRun weights = runwise([](int) { return F(0.0f); });
    const auto weighted = [&](const OcclusionPath& path, int r) {
        const auto at = [&](const float* from) { return single::load(from + r * single::kWidth); };
        const F cosine =
            (F(path.direction[0]) * at(normals->normal[0]) + F(path.direction[1]) * at(normals->normal[1])) +
            F(path.direction[2]) * at(normals->normal[2]);
        const F weight = at(normals->rest) + max(F(0.0f), cosine);
        weights.v[r] = weights.v[r] + F(path.part) * weight;
        return F(path.share) * weight;
    };
    addRun(lightOver<Kind>(opacity, paths, count, weighted, nothing), light);
    addRun(weights, normals->weights);
}

inline void occludeAndShine(const float* opacity, const float* const (&emission)[3],
                            const OcclusionPath* paths, int count, float* light, float* const (&shine)[3]) {
    using single::F;
    LightRun sum[3];
    for (LightRun& run : sum)
        run = runwise([](int) { return F(0.0f); });
    const LightRun open = lightOver<native::OcclusionSum::local>(
        opacity, paths, count, [](const OcclusionPath& path, int r) { return evenShare(path, r); },
        [&](const OcclusionStep& step, const OcclusionPath& path, const LightRun& from, const LightRun& to,
            F part) {
            const F share = F(path.share) * part;
            for (int c = 0; c < 3; ++c)
                sum[c] = runwise([&](int r) {
                    return sum[c].v[r] +
                           (share * (from.v[r] + to.v[r])) * between(emission[c], step, path, r);
                });
        });
    addRun(open, light);
    for (int c = 0; c < 3; ++c)
        addRun(sum[c], shine[c]);
}

inline void occlude(const float* opacity, const OcclusionPath* paths, int count, native::OcclusionSum sum,
                    const native::OcclusionNormals* normals, float* light) {
    switch (sum) {
    case native::OcclusionSum::local:
        return occludeBy<native::OcclusionSum::local>(opacity, paths, count, normals, light);
    case native::OcclusionSum::positional:
        return occludeBy<native::OcclusionSum::positional>(opacity, paths, count, normals, light);
    case native::OcclusionSum::rejecting:
        return occludeBy<native::OcclusionSum::rejecting>(opacity, paths, count, normals, light);
    }
}

} // namespace tessera::TESSERA_LANES
