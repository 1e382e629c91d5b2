// viewer/cli/batch/batch_summary.h: what a batch did, printed in its end.
#pragma once

#include "viewer/cli/batch/row_pool.h" // BatchTally
#include "viewer/cli/batch/run_batch.h"

#include <cstddef>

namespace tessera {

/// On stdout, with the first failures, or as JSON.
void printSummary(const BatchArguments& arguments, std::size_t rows, const BatchTally& tally, double seconds);

} // namespace tessera
