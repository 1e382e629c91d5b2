// viewer/accuracy/accuracy_report.h: sweeps as sections of a page that a person can read: the proof of the
// reference, every scene's figures and equal-error tables, the stiff figure, which settings are the Pareto
// choice, and what was left out and why.
#pragma once

#include "viewer/accuracy/peers.h"
#include "viewer/accuracy/runs_table.h"
#include "viewer/accuracy/stiff.h"
#include "viewer/accuracy/sweep.h"
#include "viewer/accuracy/work_precision.h"
#include "viewer/bench/report.h"

#include <map>
#include <string>
#include <vector>

namespace tessera::accuracy {

/// Errors (root mean square, linear) that times are compared at: NUMERICS C6, largest first.
const std::vector<double>& errorTargets();
constexpr double kDisplayError = 1.0 / 255;

/// Every method's envelope over the settings that have all memory and the finest levels; peers' behind them.
std::map<std::string, std::vector<WorkPoint>> envelopes(const Sweep& sweep,
                                                        const std::vector<PeerPoint>& peers);

/// The setting of least time whose error is at most 1/255, of those that a user would choose among: all
/// memory; null: none.
const Measured* paretoChoice(const Sweep& sweep);
/// A setting's slowdown against each scene's Pareto choice, as a geometric mean.
struct CommonChoice {
    Setting setting;
    double slowdown = 0;
};
/// Settings that stay within 1/255 in every scene, the least slowdown first. Scenes without a Pareto choice
/// are left out.
std::vector<CommonChoice> commonChoices(const std::vector<Sweep>& sweeps);

bench::Report referenceSection(const std::vector<Sweep>& sweeps, const MeasuredOn& on, const Effort& effort);
bench::Report sceneSection(const Sweep& sweep, const std::vector<PeerPoint>& peers);
bench::Report stiffSection();
bench::Report defaultsSection(const std::vector<Sweep>& sweeps);
/// @param omissions  what was not measured, with reasons; a sentence each
bench::Report runsSection(const std::vector<Sweep>& sweeps, const MeasuredOn& on,
                          const std::vector<std::string>& omissions);

} // namespace tessera::accuracy
