// bricking/analysis/lumen/leak_guard.cpp: see leak_guard.h.
#include "bricking/analysis/lumen/leak_guard.h"

#include "core/base/interrupt.h"

#include <algorithm>
#include <cmath>

namespace tessera {
namespace {

constexpr double kStep = 1 / 20.0,
                 kFinestStep = 1 / 160.0; // of the way from the lumen's value to the threshold
constexpr double kLike = 1 / 8.0;         // the same
constexpr double kNoisesInside =
    3;                           // at this distance from the lumen's value nearly all of the lumen is inside
constexpr double kNoisesOff = 1; // distance of a threshold to a leak
constexpr double kExplosion = 1.5;
constexpr double kFewMm3 = 5000; // smaller regions may grow freely: a trachea around the seed

} // namespace

GuardedLumen growWithoutLeaks(BrickCache& cache, const VolumeInfo& info, const SeedNeighbourhood& around,
                              const glm::ivec3& seed, bool always, MemoryBudget& ram,
                              const std::function<void(std::uint64_t)>& soFar) {
    const auto ruleAt = [&](double share) {
        LumenRule rule = around.rule;
        rule.threshold = around.lumen + share * (around.rule.threshold - around.lumen);
        return rule;
    };
    const glm::dvec3 mm = info.spacingMm();
    const auto few = static_cast<std::uint64_t>(kFewMm3 / (mm.x * mm.y * mm.z)) + 1000;
    const double way = std::abs(around.rule.threshold - around.lumen);
    const double inside = way > 0 ? std::clamp(kNoisesInside * around.noise / way, kStep, 1.0) : 1;
    if (!always) {
        GrowLimits limits;
        limits.like = LikeSeed{ruleAt(std::max(kLike, inside)), 0};
        limits.like->mostUnlike = 4 * few;
        GrownLumen grown = growLumen(cache, info, around.rule, seed, ram, limits, soFar);
        if (!grown.stopped && 2 * grown.unlike <= grown.count)
            return {std::move(grown), around.rule, false};
    }
    // starts where most of the lumen around the seed is inside
    double share = inside;
    GrownLumen best = growLumen(cache, info, ruleAt(share), seed, ram, {}, soFar);
    bool leaked = false;
    for (double step = kStep; share < 1 && step >= kFinestStep;) {
        checkInterrupted();
        const double next = std::min(1.0, share + step);
        GrowLimits limits;
        limits.mostVoxels =
            std::max(few, static_cast<std::uint64_t>(kExplosion * static_cast<double>(best.count)));
        GrownLumen grown = growLumen(cache, info, ruleAt(next), seed, ram, limits, soFar);
        if (grown.stopped) {
            leaked = true;
            step /= 2;
            continue;
        }
        share = next;
        best = std::move(grown);
    }
    // before noise opens a path through the wall, single voxels are open
    if (const double back = kNoisesOff * around.noise / way; leaked && back > kFinestStep) {
        share = std::max(inside, share - back);
        best = growLumen(cache, info, ruleAt(share), seed, ram, {}, soFar);
    }
    return {std::move(best), ruleAt(share), leaked};
}

} // namespace tessera
