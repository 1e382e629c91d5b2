// tests/bench/accuracy/pareto.h: the Pareto choice among a sweep's settings, by error and time: every
// method's envelope, the fastest setting that is good enough, and one setting for several scenes.
#pragma once

#include "tests/bench/accuracy/peers.h"
#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/work_precision.h"

#include <map>
#include <string>
#include <vector>

namespace tessera::accuracy {

/// Errors (root mean square, linear) that times are compared at, largest first.
const std::vector<double>& errorTargets();
constexpr double kDisplayError = 1.0 / 255;

/// Settings that differ in step, integrator, fetch and termination alone: with all memory and the scene's
/// light.
bool isPlain(const Sweep& sweep, const Setting& setting);

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

} // namespace tessera::accuracy
