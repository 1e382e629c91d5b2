// tests/bench/accuracy/accuracy_report.h: the sections of the page about all scenes together: the proof of
// the reference, the stiff figure, the Pareto choice of settings, and what was left out and why.
#pragma once

#include "tests/bench/accuracy/runs_table.h"
#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/report.h"

#include <string>
#include <vector>

namespace tessera::accuracy {

bench::Report referenceSection(const std::vector<Sweep>& sweeps, const MeasuredOn& on, const Effort& effort);
bench::Report stiffSection();
bench::Report defaultsSection(const std::vector<Sweep>& sweeps);
/// @param omissions  what was not measured, with reasons; a sentence each
bench::Report runsSection(const std::vector<Sweep>& sweeps, const MeasuredOn& on,
                          const std::vector<std::string>& omissions);

} // namespace tessera::accuracy
