// tests/bench/memory/memory_budgets.h: the measurement of `tessera bench memory`.
#pragma once

#include "tests/bench/lod/workbench.h"

namespace tessera::bench {

/// Budgets from the floor to unlimited.
Report memoryReport(const Workbench& bench);

} // namespace tessera::bench
