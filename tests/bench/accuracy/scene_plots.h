// tests/bench/accuracy/scene_plots.h: the two figures of a scene: error against time, and error against
// step.
#pragma once

#include "tests/bench/accuracy/peers.h"
#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/report.h"

#include <map>
#include <string>
#include <vector>

namespace tessera::accuracy {

/// Every method's measurements with rays that go on and all memory, coarsest step first: what the step alone
/// does. They live as long as the sweep.
std::map<std::string, std::vector<const Measured*>> byStep(const Sweep& sweep);

/// Every method's envelope, peers' too.
bench::Plot workPrecisionPlot(const Sweep& sweep, const std::vector<PeerPoint>& peers);
bench::Plot convergencePlot(const Sweep& sweep);

} // namespace tessera::accuracy
