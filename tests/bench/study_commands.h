// tests/bench/study_commands.h: the commands of `tessera-bench`, as viewer/commands/commands.h.
#pragma once

#include "viewer/options/run_commands.h"

namespace tessera {

void addAccuracyCommand(Command& program, const CommonOptions& common, Action& action);
void addBenchCommand(Command& program, const CommonOptions& common, Action& action);

} // namespace tessera
