// tests/bench/accuracy/runs_table.h: sweeps as CSV: runs.csv, a row for every scene, setting and block, and
// fail.csv.
#pragma once

#include "tests/bench/accuracy/sweep.h"
#include "tests/bench/report/report.h"

#include <string>
#include <vector>

namespace tessera::accuracy {

/// Where and by what; no path in it.
struct MeasuredOn {
    std::string version, commit, machine; // commit: empty where it is not known
};

/// Columns of runs.csv, in order.
const std::vector<std::string>& runColumns();
bench::Table runsTable(const std::vector<Sweep>& sweeps, const MeasuredOn& on);
bench::Table failTable(const std::vector<Sweep>& sweeps);

} // namespace tessera::accuracy
