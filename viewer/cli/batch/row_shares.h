// viewer/cli/batch/row_shares.h: how many rows of a batch are drawn at once, and the memory and threads of
// each.
#pragma once

#include "core/scene/scene.h"
#include "viewer/cli/batch/batch_rows.h"
#include "viewer/cli/batch/run_batch.h"
#include "viewer/cli/options/options.h"

#include <cstddef>

namespace tessera {

/// What each of several rows at once has.
struct RowShares {
    int jobs = 1, threads = 0; // threads: of a row; 0: all processors
    std::size_t ram = 0, gpu = 0;
};

/// By --jobs, or by the budgets and the processors. Throws InputError naming --ram where it has no room for
/// so many.
/// @param scene  that all rows change
/// @param ramBytes, gpuBytes  of all rows at once
RowShares sharesOf(const BatchArguments& arguments, const BatchRows& rows, const Scene& scene,
                   std::size_t ramBytes, std::size_t gpuBytes, const CommonOptions& common);

} // namespace tessera
