// tests/bench/contest.h: renderers of one picture side by side. Each takes ever finer settings until it is
// good enough, then all are timed in turn. The result is the time that each takes to be just good enough.
// Nothing is extrapolated.
#pragma once

#include "core/base/work.h"
#include "core/image/image.h"
#include "core/image/image_metrics.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tessera::bench {

/// A picture is good enough where both are met, against the reference, as 8 bits a channel hold it.
struct ErrorTarget {
    double rms = 1.0 / 255;
    double luvP99 = 3; // CIE L*u*v*
    bool met(const ImageDifference& error) const { return error.rms <= rms && error.luvP99 <= luvP99; }
};

/// One renderer at one distance between samples.
struct Setting {
    double voxels = 0;
    ImageDifference error, unrounded; // as 8 bits hold it; as it came
    double firstMs = 0;               // of the frame whose error it is
    std::vector<double> ms;           // of the rounds; empty: it decides nothing and was not timed
    Work work;                        // where it was counted
};

struct Contender {
    std::string name;
    bool tessera = false;
    std::function<double(double)> draw; // milliseconds of a frame, by voxels
    std::function<Image()> picture;     // of the last frame
    std::function<Work(double)> count;  // may be none
    std::vector<Setting> settings;      // coarse first
    bool stoppedByTime = false;         // finer ones would have taken too long
};

/// What pictures are compared with: the reference on every stride-th pixel of every stride-th row.
struct Truth {
    Image picture;
    std::vector<bool> leftOut; // pixels that renderers may differ in by definition
    int stride = 1;
    ImageDifference errorOf(const Image& whole, bool rounded) const;
};

struct ContestLimits {
    double mostMs = 40000; // a setting that looks like taking longer is not tried
    int rounds = 9;        // at most; two at least
    double shareMs = 6000; // a setting that took so long in all is not drawn again
};

/// Draws a renderer's settings until the target is met, or two halvings together gain nothing.
void climb(Contender& contender, const std::vector<double>& distances, const Truth& truth,
           const ErrorTarget& target, const ContestLimits& limits);

/// Which settings decide: the two around the target (the finest, where it is not met), and, where an rms is
/// given, the two around that.
std::vector<std::size_t> decidingSettings(const Contender& contender, const ErrorTarget& target,
                                          std::optional<double> rms);

/// Times the settings of all, in turn, every other round backwards.
/// @param deciding  per contender
void runRounds(std::vector<Contender>& contenders, const std::vector<std::vector<std::size_t>>& deciding,
               const ContestLimits& limits);

/// What stands for the rounds of a setting: their minimum, their median, or one of them.
using OfRounds = std::function<double(const std::vector<double>&)>;
double medianOf(const std::vector<double>& ms);
/// The round of this number; where a setting has fewer, they are gone through again.
OfRounds ofRound(std::size_t number);

/// How long a renderer takes to meet a target.
struct TimeAtTarget {
    bool reached = false;
    double ms = 0;                // not reached: of its finest setting, so the true one is larger
    std::size_t from = 0, to = 0; // settings that it lies between; the same: the coarsest already meets it
};
/// Between the last setting that misses and the first that meets both, log-log in each error that misses.
TimeAtTarget timeAt(const Contender& contender, const ErrorTarget& target, const OfRounds& of);

/// The cheapest setting whose rms is within a 20th of the renderer's least: past it errors fall no more, and
/// finer settings would be held against it for nothing.
std::size_t cheapestOfBest(const Contender& contender);

} // namespace tessera::bench
