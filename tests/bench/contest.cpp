// tests/bench/contest.cpp: see contest.h.
#include "tests/bench/contest.h"

#include "core/base/error.h"
#include "tests/bench/bench_tools.h"
#include "tests/bench/peer_truth.h"
#include "tests/bench/report/work_precision.h"

#include <algorithm>
#include <limits>
#include <set>

namespace tessera::bench {
namespace {

constexpr double kGain = 0.97;          // a setting with more than this share of both errors gains nothing
constexpr double kCoarse = 1;           // voxels; above it errors may well rise before they fall
constexpr double kNearBest = 1.05;      // of an rms
constexpr std::size_t kLeastRounds = 2; // of even the slowest

bool gains(const Setting& before, const Setting& after) {
    return after.error.rms < kGain * before.error.rms || after.error.luvP99 < kGain * before.error.luvP99;
}

/// The first setting that meets a target, or none.
std::optional<std::size_t> firstThatMeets(const Contender& contender, const ErrorTarget& target) {
    for (std::size_t i = 0; i < contender.settings.size(); ++i)
        if (target.met(contender.settings[i].error))
            return i;
    return std::nullopt;
}

double between(const Setting& misses, const Setting& meets, double missing, double meeting, double target,
               const OfRounds& of) {
    const auto envelope = accuracy::paretoEnvelope({{missing, of(misses.ms), 0}, {meeting, of(meets.ms), 1}});
    return accuracy::timeAtError(envelope, target).value_or(of(meets.ms));
}

} // namespace

ImageDifference Truth::errorOf(const Image& whole, bool rounded) const {
    const Image some = without(thinned(whole, stride), leftOut);
    return compare(rounded ? roundedTo8Bits(some) : some, picture);
}

void climb(Contender& contender, const std::vector<double>& distances, const Truth& truth,
           const ErrorTarget& target, const ContestLimits& limits) {
    if (contender.tessera) // work of a scene's first frame; VtkRenderer does its own
        contender.draw(distances.front());
    for (const double voxels : distances) {
        std::vector<Setting>& settings = contender.settings;
        const std::size_t n = settings.size();
        if (n > 0 && settings[n - 1].firstMs * settings[n - 1].voxels / voxels > limits.mostMs) {
            contender.stoppedByTime = true;
            return;
        }
        Setting setting;
        setting.voxels = voxels;
        setting.firstMs = contender.draw(voxels);
        setting.error = truth.errorOf(contender.picture(), true);
        setting.unrounded = truth.errorOf(contender.picture(), false);
        settings.push_back(setting);
        if (target.met(setting.error))
            return;
        if (n >= 2 && settings[n - 2].voxels <= kCoarse && !gains(settings[n - 2], settings[n]))
            return;
    }
}

std::vector<std::size_t> decidingSettings(const Contender& contender, const ErrorTarget& target,
                                          std::optional<double> rms) {
    std::set<std::size_t> deciding;
    const auto add = [&](const ErrorTarget& asked) {
        const auto first = firstThatMeets(contender, asked);
        const std::size_t to = first.value_or(contender.settings.size() - 1);
        deciding.insert(to);
        if (first && to > 0)
            deciding.insert(to - 1);
    };
    add(target);
    if (rms)
        add({*rms, std::numeric_limits<double>::infinity()});
    return {deciding.begin(), deciding.end()};
}

void runRounds(std::vector<Contender>& contenders, const std::vector<std::vector<std::size_t>>& deciding,
               const ContestLimits& limits) {
    struct Turn {
        Contender* contender;
        std::size_t setting;
        double spentMs = 0;
    };
    std::vector<Turn> turns;
    for (std::size_t c = 0; c < contenders.size(); ++c)
        for (const std::size_t setting : deciding[c])
            turns.push_back({&contenders[c], setting});
    for (int round = 0; round < limits.rounds; ++round)
        for (std::size_t i = 0; i < turns.size(); ++i) {
            Turn& turn = turns[round % 2 ? turns.size() - 1 - i : i];
            Setting& setting = turn.contender->settings[turn.setting];
            if (setting.ms.size() >= kLeastRounds && turn.spentMs > limits.shareMs)
                continue;
            setting.ms.push_back(turn.contender->draw(setting.voxels));
            turn.spentMs += setting.ms.back();
        }
}

double medianOf(const std::vector<double>& ms) {
    return median(ms);
}

OfRounds ofRound(std::size_t number) {
    return [number](const std::vector<double>& ms) {
        TESSERA_CHECK(!ms.empty());
        return ms[number % ms.size()];
    };
}

TimeAtTarget timeAt(const Contender& contender, const ErrorTarget& target, const OfRounds& of) {
    TimeAtTarget out;
    const auto first = firstThatMeets(contender, target);
    const std::vector<Setting>& settings = contender.settings;
    out.reached = first.has_value();
    out.to = first.value_or(settings.size() - 1);
    out.from = first && out.to > 0 ? out.to - 1 : out.to;
    const Setting &meets = settings[out.to], &misses = settings[out.from];
    out.ms = of(meets.ms);
    if (out.from == out.to)
        return out;
    const ImageDifference &before = misses.error, &after = meets.error;
    double latest = 0;
    if (before.rms > target.rms)
        latest = std::max(latest, between(misses, meets, before.rms, after.rms, target.rms, of));
    if (before.luvP99 > target.luvP99)
        latest = std::max(latest, between(misses, meets, before.luvP99, after.luvP99, target.luvP99, of));
    TESSERA_CHECK(latest > 0); // else the one before had met both
    out.ms = latest;
    return out;
}

std::size_t cheapestOfBest(const Contender& contender) {
    double least = std::numeric_limits<double>::infinity();
    for (const Setting& setting : contender.settings)
        least = std::min(least, setting.error.rms);
    std::size_t i = 0;
    while (contender.settings[i].error.rms > kNearBest * least)
        ++i;
    return i;
}

} // namespace tessera::bench
