// viewer/cli/batch/run_batch.h: `tessera batch`: a picture for each row of a table.
#pragma once

#include "viewer/cli/options/options.h"

#include <string>
#include <vector>

namespace tessera {

struct BatchArguments {
    std::string table, scene, out, report;
    std::string engine = "auto", device = "auto", verify, ram, gpuMemory;
    std::vector<std::string> layers;
    int jobs = 0; // rows at once; 0: by memory and processors
    bool noCheck = false, allowDamaged = false, again = false, claim = false, dryRun = false, json = false;
};

/// Goes on after a row that fails. Throws InputError naming an option, the table or a row before anything is
/// drawn, and Error in the end if any row failed.
void runBatch(const BatchArguments& arguments, const CommonOptions& common);

} // namespace tessera
