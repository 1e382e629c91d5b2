// tests/bench/study_commands.h: the commands of `tessera-bench`, as viewer/cli/commands.h.
#pragma once

#include "viewer/cli/options/run_commands.h"

namespace tessera {

void addAccuracyCommand(Command& program, const CommonOptions& common, Action& action);
void addBenchCommand(Command& program, const CommonOptions& common, Action& action);

} // namespace tessera
